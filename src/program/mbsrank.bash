# Completion of mbsrank in bash.
# SPDX-License-Identifier: BSD-3-Clause
_mbsrank() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}
    local common="--start --floating --package --arg --set --folder --anywhere --no-limits --no-friction --no-contacts --stop-stiffness --stop-damping --slip --strict --help"
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        mapfile -t COMPREPLY < <(compgen -W "info check run study fit static modes linearise plot view fmu convert --help --version" -- "$word")
        return
    fi
    case $before in
    --form) mapfile -t COMPREPLY < <(compgen -W "momentum index1" -- "$word"); return ;;
    esac
    case $word in
    -*)
        case ${COMP_WORDS[1]} in
        run) common="$common --t-end --step --rtol --atol --form --inputs --output -o --quiet --json" ;;
        fit) common="$common --data --vary --noise -o --rtol --atol --form --inputs --quiet --json" ;;
        study) common="-o --jobs --anew --json --quiet --help" ;;
        fmu) common="$common -o --fmi --kind --fixed-step --sources --order --rtol --atol --t-end --step --name" ;;
        plot) common="--columns --over --title -o --help" ;;
        convert) common="--floating --package --arg --set --folder --anywhere --strict --help" ;;
        view) common="$common --inputs --live -o" ;;
        modes) common="$common --count --mode -o --as-drawn --json" ;;
        linearise) common="$common --inputs --outputs --response -o --as-drawn --json" ;;
        static) common="$common --trim --hold --json" ;;
        check) common="$common --small --time --tolerance --json" ;;
        info) common="$common --parameters --json" ;;
        *) common="$common --json" ;;
        esac
        mapfile -t COMPREPLY < <(compgen -W "$common" -- "$word") ;;
    *) mapfile -t COMPREPLY < <(compgen -f -- "$word") ;;
    esac
}
complete -o filenames -F _mbsrank mbsrank
