#!/bin/sh
# Times the trees of tests/reference/trees in libmbsrank, compiled in several ways, and in other
# libraries, on one core, by turns; the table goes to bench/results/trees.csv.
# SPDX-License-Identifier: BSD-3-Clause
#
#   bench/run.sh trees [samples [rounds]]     samples a round of each measurement
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
work=$root/build/bench-trees
results=$root/bench/results
samples=${1:-7}
rounds=${2:-3}
jobs=$(getconf _NPROCESSORS_ONLN 2> /dev/null || echo 2)

# The other libraries, as far as this system has them.
packages="libmujoco-dev libsimbody-dev libbullet-dev g++ pkg-config"
for package in $packages; do
    if command -v dpkg-query > /dev/null && command -v apt-get > /dev/null &&
        ! dpkg-query -W -f '${db:Status-Status}' "$package" 2> /dev/null | grep -qx installed; then
        sudo=
        [ "$(id -u)" -eq 0 ] || sudo=sudo
        $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends \
            "$package" || echo "$package: not installed, goes without"
    fi
done

# build NAME COMPILER OPTION...: libmbsrank and bench_trees.
build() {
    name=$1
    compiler=$2
    shift 2
    cmake -S "$root" -B "$work/$name" -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_COMPILER="$compiler" \
        -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DMBSR_BENCH=ON -DMBSR_TESTS=OFF -DMBSR_EXAMPLES=OFF \
        -DMBSR_IDA=OFF "$@"
    cmake --build "$work/$name" --parallel "$jobs" --target bench_trees
}

# flags NAME FILE: what a source was compiled with, without paths and warnings.
flags() {
    grep "\"command\".*$2" "$work/$1/compile_commands.json" | tr ' ' '\n' |
        grep -E '^-(O|D|f|g|m|std)' | tr '\n' ' '
}

# Names in the table: mbsrank is gcc with all kernels, mbsrank_clang the same by clang,
# mbsrank_baseline gcc with the kernels for every x86-64 processor only.
mkdir -p "$work" "$results"
own=mbsrank
build mbsrank "$(command -v gcc || command -v cc)"
if command -v clang > /dev/null; then
    build mbsrank_clang clang
    own="$own mbsrank_clang"
fi
if grep -q 'MBSR_HAS_V3:INTERNAL=1' "$work/mbsrank/CMakeCache.txt"; then
    build mbsrank_baseline "$(command -v gcc || command -v cc)" -DMBSR_HAS_V3=OFF -DMBSR_HAS_V4=OFF
    own="$own mbsrank_baseline"
fi
peers=
if command -v c++ > /dev/null &&
    cmake -S "$root/bench/peers" -B "$work/peers" -DCMAKE_BUILD_TYPE=Release \
        -DMBSRANK_LIBRARY="$(find "$work/mbsrank/src" -name 'libmbsrank.*' | sort | head -n 1)"; then
    cmake --build "$work/peers" --parallel "$jobs"
    for program in "$work"/peers/peer_*; do
        if [ -f "$program" ] && [ -x "$program" ]; then peers="$peers ${program##*/peer_}"; fi
    done
fi

# One core: the last of those this shell may use.
pin=
if command -v taskset > /dev/null; then
    core=$(taskset -cp $$ | sed 's/.*[:, -]//')
    pin="taskset -c $core"
fi

files=
round=1
while [ "$round" -le "$rounds" ]; do
    mkdir -p "$work/round$round"
    for name in $own $peers; do
        out=$work/round$round/$name.csv
        echo "round $round of $rounds: $name" >&2
        case $name in
        mbsrank*)
            MBSR_BENCH_FLAGS="$(flags "$name" dynamics\\.c)"
            for kernels in kernels_base kernels_v3 batch_v4; do
                MBSR_BENCH_FLAGS="$MBSR_BENCH_FLAGS; $kernels: $(flags "$name" "$kernels\\.c")"
            done
            export MBSR_BENCH_FLAGS
            $pin "$work/$name/bench/bench_trees" "$root/tests/reference/trees" "$samples" > "$out"
            ;;
        *) $pin "$work/peers/peer_$name" "$root/tests/reference/trees" "$samples" > "$out" ;;
        esac
        files="$files $out"
    done
    round=$((round + 1))
done

# An interrupted run leaves the old results as they are.
# shellcheck disable=SC2086 # a list
awk -f "$root/bench/peers/merge.awk" $files > "$work/trees.csv"
mv "$work/trees.csv" "$results/trees.csv"
sed -n '/^# medians of/,$p' "$results/trees.csv"
