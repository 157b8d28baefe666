#!/usr/bin/env bash
# Installs what is missing, builds a Release tree in build/release, runs the demo program, and plots
# what it writes to demo-output/.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: demo.sh [tree [BODIES] | loops | file]   `tree`: the second part, a tree of 9999 bodies; `loops`:
# the third, a mechanism with three loops; `file`: the fourth, models from files by the program mbsrank
set -eu
part=${1:-oscillators}
case $part in
oscillators | loops | file) ;;
tree) bodies=${2:-9999} ;;
*)
    echo "usage: $0 [tree [BODIES] | loops | file]" >&2
    exit 2
    ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
purposes=(build demo)
if [ "$part" = file ]; then purposes+=(page); fi
bash scripts/install.sh "${purposes[@]}"

tree=build/release
output=$PWD/demo-output
script=$PWD/examples/$part.gp
if [ "$part" = loops ]; then script=$PWD/examples/squeezer.gp; fi
generator=()
if [ ! -f "$tree/CMakeCache.txt" ] && command -v ninja >/dev/null; then generator=(-G Ninja); fi
cmake -S . -B "$tree" ${generator[@]+"${generator[@]}"} -DCMAKE_BUILD_TYPE=Release \
    -DMBSR_TESTS=OFF -DMBSR_EXAMPLES=ON
cmake --build "$tree" --parallel "$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)"

mkdir -p "$output"
program=$tree/src/program/mbsrank

# show MODEL OUTPUT COLUMNS OPTION...: checks a model from a file, runs it, plots columns, writes its page.
show() {
    local model=examples/models/$1 name=$output/${1%.*} written=$2 columns=$3
    shift 3
    "$program" info "$model"
    "$program" check "$model"
    "$program" run "$model" --output "$written" -o "$name.csv" "$@"
    if command -v gnuplot >/dev/null; then
        "$program" plot "$name.csv" -o "$name.png" --columns "$columns"
        echo "Plot: $name.png"
    else
        echo "gnuplot is missing: no plot."
    fi
    if [ -f "$tree/src/program/viewer.html" ]; then
        "$program" view "$model" "$name.csv" -o "$name.html" 2>/dev/null
        echo "Page: $name.html"
    else
        echo "the packages of npm were not to be had: no page."
    fi
}

if [ "$part" = file ]; then
    show quarter_car.xml state tyre,damper,rubber --t-end 2 --step 0.005 --start pushed
    show arm.urdf state,hand.pos shoulder,elbow,pitch:hand.pos --t-end 4 --step 0.01
    show suspension.xml state lower,steering --t-end 2 --inputs examples/models/steer.csv
    exit 0
fi
if [ "$part" = loops ]; then
    (cd "$output" && "$OLDPWD/$tree/examples/33_squeezer")
else
    "$tree/examples/demo_$part" "$output" ${bodies:+"$bodies"}
fi
if command -v gnuplot >/dev/null; then
    (cd "$output" && gnuplot "$script")
    echo "Plot: $output/$(basename "$script" .gp).png"
else
    echo "gnuplot is missing: no plot. The numbers are in $output."
fi
