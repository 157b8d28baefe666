#!/usr/bin/env bash
# Makes the tables of measurements in README.md and the documents from bench/results. A table stands between the
# lines "<!-- table NAME -->" and "<!-- end -->"; table_NAME below prints it.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: tables.sh [--check]     --check: writes nothing, and fails where a table differs
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
results=bench/results
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# rows FILE AWK...: the lines of a result, comments and head left out, by a program of awk.
rows() {
    local file=$results/$1.csv
    shift
    grep -v '^#' "$file" | tail -n +2 | awk -F, "$@"
}

# Functions of awk that write numbers as the documents do.
numbers='
    function digits(x, n,    e) {           # n digits, no exponent
        if (x == 0) return "0"
        e = int(log(x < 0 ? -x : x) / log(10) + 1e-9); if (x < 1 && x > -1) --e
        return e >= n - 1 ? sprintf("%.0f", x) : sprintf("%." (n - 1 - e) "f", x)
    }
    function grouped(n,    text) {          # 12 345 from 10 000 on
        text = sprintf("%.0f", n)
        if (length(text) < 5) return text
        return grouped(substr(text, 1, length(text) - 3)) " " substr(text, length(text) - 2)
    }
    function ns(x) { return x < 999.5 ? sprintf("%.0f", x) : digits(x / 1000, 2) " µs" }
    function short(x,    text) { text = sprintf("%.0e", x); sub(/e\+?/, "e", text); sub(/e-0/, "e-", text); sub(/e0+/, "e", text); return text }
'

# What others do with massless bodies, loops, stiff springs and flexible bodies, and what was measured beside them.
table_neighbours() {
    local costs
    costs=$(
        rows trees "$numbers"' $2 == "chain30" && $4 == "forward" { print "tree_" $1 "=" digits($9, 2) }'
        rows loop_runs "$numbers"' $1 == "fourbars" && $3 == 400 && $8 < 2e-4 && !($2 in seen) {
            seen[$2]; print "loop_" $2 "=" digits($7, 2) }'
        rows newton "$numbers"' $1 == "beam" && $2 == 400 && ($5 == "tree" && $6 == 1e-4 || $5 == "mujoco_Euler") {
            print "stiff_" $5 "=" digits($19, 2) }'
    )
    local tree_mbsrank tree_mujoco tree_simbody tree_rbdl tree_pinocchio loop_libmbsrank_rk4 loop_mujoco loop_rbdl
    local loop_pinocchio stiff_tree stiff_mujoco_Euler name
    while IFS='=' read -r name value; do
        case $name in *[!A-Za-z0-9_]*) ;; *) printf -v "$name" %s "$value" ;; esac
    done <<<"$costs"
    cat <<END
| | massless body | closed loop | stiff spring | flexible body | tree | loops | stiff |
|---|---|---|---|---|---:|---:|---:|
| libmbsrank | anywhere; zero stays zero, its velocities are found | exact, multipliers in an index-1 DAE; redundant rows named | any stiffness at the cost of a rigid joint | modes, beams, finite elements, SID; static modes without mass | $tree_mbsrank | $loop_libmbsrank_rk4 | $stiff_tree |
| MuJoCo | refused on a joint: mass and inertia above 1e-15 | soft equality constraints | a force; implicit integrators | soft constraints between many bodies | $tree_mujoco | $loop_mujoco | $stiff_mujoco_Euler |
| Pinocchio | links before one with mass | \`constraintDynamics\`, proximal | your force | – | $tree_pinocchio | $loop_pinocchio | – |
| RBDL | links before one with mass | \`ConstraintSet\`, Baumgarte optional | your force | – | $tree_rbdl | $loop_rbdl | – |
| Simbody | not at the end of a branch | constraints, projected | a force | – | $tree_simbody | – | – |
| Drake | not at the end of a branch | constraints of discrete plants, or bushings | a force | deformable bodies of discrete plants | – | – | – |
| MBDyn | static nodes, held by joints or elastic elements | constraints in redundant coordinates | elastic joints | beams, shells, modal joint | – | – | – |
END
}

# Reduction of solids from finite elements.
table_fe() {
    echo '| dofs | entries of the factor | s | MB | frequencies | deflections |'
    echo '|---:|---:|---:|---:|---:|---:|'
    rows fe "$numbers"' { printf "| %s (%s) | %s | %s | %s | %s | %s |\n",
        grouped($2), $1, $4 == "" ? "–" : sprintf("%.1e", $4), digits($6, 2), $12, short($13), short($14) }'
}

# Time per body of chains with bodies of several kinds.
table_kinds() {
    echo '| chain | forward dynamics | inverse dynamics | momentum residual | factor + solve |'
    echo '|---|---:|---:|---:|---:|'
    rows kinds "$numbers"'
        BEGIN {
            n = split("space|in space, stock hinges;one_own_joint|one own hinge;ten_own_joints|ten own hinges;" \
                "own_joints|all hinges own;short_joints|all hinges by hand;general|ten general bodies;" \
                "general_derivatives|the same, derivatives of their joints given;plane|in the plane", names, ";")
        }
        { time[$1 "," $3] = $4 }
        END {
            for (k = 1; k <= n; ++k) {
                split(names[k], name, "|"); c = name[1] ","
                if ((c "forward") in time)
                    printf "| %s | %s | %s | %s | %s |\n", name[2], ns(time[c "forward"]), ns(time[c "inverse"]),
                        ns(time[c "residual"]), ns(time[c "factor_solve"])
            }
        }'
}

# fill FILE: the file with its tables made anew.
fill() {
    local line name
    while IFS= read -r line || [ -n "$line" ]; do
        case $line in
        '<!-- table '*' -->')
            name=${line#<!-- table }
            name=${name% -->}
            printf '%s\n' "$line"
            "table_$name"
            while IFS= read -r line && [ "$line" != '<!-- end -->' ]; do :; done
            ;;
        esac
        printf '%s\n' "$line"
    done <"$1"
}

status=0
count=0
for document in README.md docs/*.md bench/README.md; do
    grep -q '^<!-- table ' "$document" || continue
    count=$((count + $(grep -c '^<!-- table ' "$document")))
    fill "$document" >"$work/filled"
    if [ "${1:-}" = --check ]; then
        diff -u "$document" "$work/filled" || { echo "$document: run scripts/tables.sh"; status=1; }
    elif ! cmp -s "$document" "$work/filled"; then
        cat "$work/filled" >"$document"
    fi
done
echo "$count tables"
[ "$count" -gt 0 ] || status=1
exit $status
