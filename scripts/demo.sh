#!/usr/bin/env bash
# Installs what is missing, builds a Release tree in build/release, runs the demo program, and plots
# what it writes to demo-output/.
# SPDX-License-Identifier: BSD-3-Clause
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash scripts/install.sh build demo

tree=build/release
output=$PWD/demo-output
generator=()
if [ ! -f "$tree/CMakeCache.txt" ] && command -v ninja >/dev/null; then generator=(-G Ninja); fi
cmake -S . -B "$tree" ${generator[@]+"${generator[@]}"} -DCMAKE_BUILD_TYPE=Release \
    -DMBSR_TESTS=OFF -DMBSR_EXAMPLES=ON
cmake --build "$tree" --parallel "$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)"

mkdir -p "$output"
"$tree/examples/demo_oscillators" "$output"
if command -v gnuplot >/dev/null; then
    script=$PWD/examples/oscillators.gp
    (cd "$output" && gnuplot "$script")
    echo "Plots:"
    find "$output" -name '*.png' | sort
else
    echo "gnuplot is missing: no plot. The numbers are in $output."
fi
