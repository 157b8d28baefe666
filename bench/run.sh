#!/bin/sh
# Builds the benchmark programs in Release mode and writes their results to bench/results.
# SPDX-License-Identifier: BSD-3-Clause
#
#   bench/run.sh [samples [largest N]]      the arguments of bench_scaling
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
build=$root/build/bench
results=$root/bench/results

cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
    -DMBSR_BENCH=ON -DMBSR_TESTS=OFF -DMBSR_EXAMPLES=OFF -DMBSR_IDA=OFF
cmake --build "$build" --target bench_scaling

# The flags the library was compiled with, without paths and warnings.
MBSR_BENCH_FLAGS=$(grep '"command".*backward\.c' "$build/compile_commands.json" | tr ' ' '\n' |
    grep -E '^-(O|D|f|g|m|std)' | tr '\n' ' ')
export MBSR_BENCH_FLAGS

# One core: the last of those this shell may use.
pin=
if command -v taskset > /dev/null; then
    core=$(taskset -cp $$ | sed 's/.*[:, -]//')
    pin="taskset -c $core"
fi

# An interrupted run leaves the old results as they are.
mkdir -p "$results"
$pin "$build/bench/bench_scaling" "$@" > "$build/scaling.csv"
mv "$build/scaling.csv" "$results/scaling.csv"
sed -n '/^# least squares/,$p' "$results/scaling.csv"
