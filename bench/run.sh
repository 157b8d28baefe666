#!/bin/sh
# Builds the benchmark programs in Release mode and writes their results to bench/results, and the
# pictures of bench_precision to docs.
# SPDX-License-Identifier: BSD-3-Clause
#
#   bench/run.sh                                  all of these
#   bench/run.sh scaling [samples [largest N]]    needs no SUNDIALS
#   bench/run.sh kinds [samples]                  nor does this
#   bench/run.sh flexible [samples [links]]
#   bench/run.sh loops [samples]                  KLU, too, where SUNDIALS has it; MuJoCo, RBDL and Pinocchio where installed
#   bench/run.sh report [samples]                 nor this
#   bench/run.sh files [samples [bodies]]         nor this
#   bench/run.sh fe [largest number of dofs]      nor this; CHOLMOD where it is, 3 GB and some minutes for 100000
#   bench/run.sh stepper [steps]                  nor this
#   bench/run.sh contact [case [spheres]]         MuJoCo, too, where npm fetches it
#   bench/run.sh outputs [samples [outputs]]
#   bench/run.sh sensitivity [largest N [kind]]
#   bench/run.sh threads [samples [threads]]      nor this; elapsed time, on all cores
#   bench/run.sh precision [smallest tolerance]
#   bench/run.sh newton [largest number of bodies]     MuJoCo, too, where it is installed
#   bench/run.sh explicit [samples]
#   bench/run.sh driver [cells|mechanisms|ordinary|all|grid [runs]]
#   bench/run.sh trees [samples [rounds]]         peers/run.sh: other libraries, too
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
build=$root/build/bench
results=$root/bench/results
trees=$root/bench/peers/run.sh
what=${1:-all}
[ $# -eq 0 ] || shift
case $what in
all | flexible | loops | outputs | precision | newton | explicit | driver | contact | sensitivity) ida=ON ;; # loops: for KLU
scaling | kinds | report | files | fe | stepper | threads) ida=OFF ;;
trees) exec sh "$trees" "$@" ;;
*)
    sed -n 's/^#   //p' "$0" >&2
    exit 2
    ;;
esac

cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
    -DMBSR_BENCH=ON -DMBSR_TESTS=OFF -DMBSR_EXAMPLES=OFF -DMBSR_IDA=$ida
cmake --build "$build"

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

# wanted NAME: whether this part is to run.
wanted() {
    [ "$what" = all ] || [ "$what" = "$1" ]
}

# build_peers TARGET: a program that times another library; false where there is no such library.
peers=$root/build/bench-peers
build_peers() {
    library=$(find "$build/src" -name 'libmbsrank.*' | sort | head -n 1)
    command -v c++ > /dev/null &&
        cmake -S "$root/bench/peers" -B "$peers" -DCMAKE_BUILD_TYPE=Release \
            -DMBSRANK_LIBRARY="$library" &&
        cmake --build "$peers" --target "$1"
}

# An interrupted run leaves the old results as they are.
mkdir -p "$results"
if wanted scaling; then
    $pin "$build/bench/bench_scaling" "$@" > "$build/scaling.csv"
    mv "$build/scaling.csv" "$results/scaling.csv"
    sed -n '/^# least squares/,$p' "$results/scaling.csv"
fi
for part in kinds flexible loops report files fe stepper outputs explicit driver contact sensitivity; do
    wanted $part || continue
    OPENBLAS_NUM_THREADS=1 $pin "$build/bench/bench_$part" "$@" > "$build/$part.csv"
    if [ $part = loops ]; then
        mkdir -p "$build/loops"
        "$build/bench/bench_loops" --write "$build/loops"
        OPENBLAS_NUM_THREADS=1 $pin "$build/bench/bench_loop_runs" "$build/loops" > "$build/loop_runs.csv"
        for name in mujoco rbdl pinocchio; do
            if build_peers "loops_$name"; then
                $pin "$peers/loops_$name" "$build/loops" "$@" >> "$build/loops.csv"
                $pin "$peers/loops_$name" --runs "$build/loops" >> "$build/loop_runs.csv"
            else
                echo "no loops_$name: goes without"
            fi
        done
    fi
    if [ $part = contact ]; then
        mkdir -p "$build/mujoco"
        if (cd "$build/mujoco" && npm install --no-audit --no-fund @mujoco/mujoco@3.14.0); then
            (cd "$build/mujoco" && $pin node "$root/bench/peers/contact_mujoco.mjs") >> "$build/contact.csv"
        else
            echo "no MuJoCo from npm: goes without"
        fi
    fi
    mv "$build/$part.csv" "$results/$part.csv"
    [ $part != loops ] || mv "$build/loop_runs.csv" "$results/loop_runs.csv"
done
if wanted threads; then
    "$build/bench/bench_threads" "$@" > "$build/threads.csv"
    mv "$build/threads.csv" "$results/threads.csv"
fi
if wanted precision; then
    $pin "$build/bench/bench_precision" "${1:-1e-10}" "$build/bead.csv" > "$build/precision.csv"
    mv "$build/precision.csv" "$results/precision.csv"
    if command -v gnuplot > /dev/null; then
        (cd "$build" && gnuplot -e "results='$results/precision.csv'; pictures='$root/docs'" \
            "$root/bench/precision.gp")
    else
        echo "gnuplot is missing: no pictures"
    fi
fi
if wanted newton; then
    mkdir -p "$build/newton"
    $pin "$build/bench/bench_newton" "$build/newton" "$@" > "$build/newton.csv"
    if build_peers runs_mujoco; then
        $pin "$peers/runs_mujoco" "$build/newton" >> "$build/newton.csv"
    else
        echo "no MuJoCo: goes without"
    fi
    mv "$build/newton.csv" "$results/newton.csv"
    grep '^# time of a step' "$results/newton.csv"
fi
if [ "$what" = all ]; then sh "$trees"; fi
