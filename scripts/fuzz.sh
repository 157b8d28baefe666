#!/usr/bin/env bash
# Every libFuzzer target for some minutes, with address and undefined-behaviour sanitizers. What it finds is kept in
# build/fuzz/found; what covers something new in build/fuzz/corpus, from where the next call goes on.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: fuzz.sh MINUTES [TARGET]...    for each target; fuzz_model, fuzz_files, fuzz_xacro, fuzz_fe, fuzz_study, fuzz_fmu
set -eu
[ $# -ge 1 ] || { echo "usage: fuzz.sh MINUTES [TARGET]..." >&2; exit 2; }
minutes=$1
shift
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash scripts/install.sh build test
tree=build/fuzz
cmake -S . -B "$tree" -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -g1" -DMBSR_FUZZ=ON -DMBSR_EXAMPLES=OFF -DMBSR_PROGRAM=OFF \
    -DMBSR_FENCES=ON -DMBSR_SANITIZE=fuzzer-no-link,address,undefined >/dev/null
targets=${*:-fuzz_model fuzz_files fuzz_xacro fuzz_fe fuzz_study fuzz_fmu}
# shellcheck disable=SC2086 # targets are several words
cmake --build "$tree" --parallel "$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)" --target $targets
status=0
for target in $targets; do
    mkdir -p "$tree/corpus/$target" "$tree/found"
    seeds=()
    case $target in fuzz_files | fuzz_xacro) seeds=(tests/fuzz/corpus examples/models) ;; esac
    echo "==== $target"
    "$tree/tests/$target" -max_total_time=$((60 * minutes)) -timeout=20 -rss_limit_mb=2048 -print_final_stats=1 \
        -artifact_prefix="$tree/found/$target-" "$tree/corpus/$target" ${seeds[@]+"${seeds[@]}"} 2>"$tree/$target.log" ||
        { status=1; tail -40 "$tree/$target.log"; }
    grep -E 'stat::(number_of_executed_units|average_exec|new_units)|^#[0-9]+.*DONE' "$tree/$target.log" || true
done
exit $status
