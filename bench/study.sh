#!/usr/bin/env bash
# What studies cost: two processes against one, by --jobs and by mpirun with a third that hands out; what a dispatcher
# uses; bytes a run. Writes CSV: medians of interleaved repetitions. Efficiency: time of one process over twice that of two,
# each less the time of a study of two runs, which is that of starting.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: study.sh PROGRAM [RUNS [REPEATS]]
set -eu
program=$(realpath "$1") runs=${2:-400} repeats=${3:-3}
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cp "$project/examples/models/quarter_car.xml" .
{
    echo '<mujoco><option gravity="0 0 -9.81"/><worldbody>'
    for k in $(seq 30); do
        printf '<body name="b%d" pos="0.1 0 0"><joint name="j%d" axis="0 1 0" stiffness="50" damping="1"/><geom size="0.02" mass="0.2"/>' "$k" "$k"
    done
    for k in $(seq 30); do printf '</body>'; done
    echo '</worldbody></mujoco>'
} >arm.xml
printf '%s\n' 'model quarter_car.xml' 'run --t-end 0.5 --start pushed' "sample sobol $runs" 'vary bodies.body.mass 250 400' \
    'keep damper max' 'keep damper at 0.5' >car.study
printf '%s\n' 'model arm.xml' 'run --t-end 0.1' "sample sobol $runs" 'vary bodies.b1.mass 0.1 0.4' 'keep j30 at 0.1' 'keep j1 max' >arm.study
printf '%s\n' 'model quarter_car.xml' 'run --t-end 1e-6' "sample sobol $runs" 'vary bodies.body.mass 250 400' 'keep damper at 1e-6' >empty.study
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 TIMEFORMAT='%R %U %S'

for study in empty car arm; do sed "s/sobol $runs/sobol 2/" $study.study >$study.begin.study; done

# once STUDY WAY: wall, user and system seconds, into $work/STUDY.WAY
once() {
    rm -rf out.csv out.csv.runs
    case $2 in
    mpi3)
        # shellcheck disable=SC2016 # for the shell of each process
        { time mpirun -n 3 bash -c '"$@"; if [ "$OMPI_COMM_WORLD_RANK" = 0 ]; then times >dispatcher; fi' - \
            "$program" study "$1.study" -o out.csv --quiet >/dev/null 2>told; } 2>>"$1.$2" ;;
    *) { time "$program" study "$1.study" -o out.csv --quiet --jobs "${2#jobs}" >/dev/null 2>told; } 2>>"$1.$2" ;;
    esac
    [ -s out.csv ] || { cat told >&2; exit 1; }
}

# median STUDY WAY: wall and processor seconds
median() {
    sort -n "$1.$2" | awk '{ line[NR] = $0 } END { split(line[int((NR + 1) / 2)], x, " "); print x[1], x[2] + x[3] }'
}

# net STUDY WAY: wall seconds without those of starting
net() {
    echo "$(median "$1" "$2") $(median "$1.begin" "$2")" | awk '{ print $1 - $3 }'
}

ways="jobs1 jobs2"
if command -v mpirun >/dev/null; then ways="$ways mpi3"; fi
echo "study,way,runs,wall (s),processors (s),efficiency,journal (bytes/run),result (bytes/run),dispatcher"
for study in empty car arm; do
    for ((k = 0; k < repeats; ++k)); do
        for way in $ways; do
            once $study.begin "$way"
            once $study "$way"
        done
    done
    bytes=$(cat out.csv.runs/*.journal | wc -c)
    for way in $ways; do
        read -r wall processors <<<"$(median $study "$way")"
        efficiency=
        if [ "$way" != jobs1 ]; then efficiency=$(echo "$(net $study jobs1) $(net $study "$way")" | awk '{ printf "%.2f", $1 / (2 * $2) }'); fi
        told=
        if [ "$way" = mpi3 ]; then told=$(tail -1 dispatcher); fi
        echo "$study,$way,$runs,$wall,$processors,$efficiency,$((bytes / runs)),$(($(wc -c <out.csv) / runs)),$told"
    done
done
