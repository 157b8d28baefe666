#!/bin/sh
# Studies: the same results for any number of processes, killed and gone on, on a full disk; what is refused.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: study.sh PROGRAM PROJECT_DIR [FULL_DISK_LIBRARY [MPIRUN]]
set -u
program=$1
project=$2
full=${3:-}
work=$(mktemp -d)
trap 'umount "$work/disk" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 1
failed=0
cp "$project/examples/models/quarter_car.xml" .
runs=30 kills=3 every=4
if [ -n "${MBSR_TEST_LONG:-}" ]; then runs=2000 kills=20 every=1; fi

fail() {
    echo "FAILED: $*"
    failed=1
}

# ends CODE WORDS ARGUMENT...: ends with that code and says the words on either stream.
ends() {
    code=$1 words=$2
    shift 2
    "$program" "$@" >out 2>err </dev/null
    got=$?
    if [ $got -ne "$code" ] || ! cat out err | grep -q -e "$words"; then
        echo "mbsrank $*: ended with $got, expected $code and '$words'"
        cat out err
        failed=1
    fi
}

# write NAME LINE...: a study of these lines.
write() {
    name=$1
    shift
    { for line; do echo "$line"; done; } >"$name.study"
}

# ---- results ----

write car 'model quarter_car.xml' 'run --t-end 0.3 --start pushed --step 0.01' "sample latin $runs seed 4" \
    'vary bodies.body.mass 250 400 unit kg' 'vary forces.force2.damping 800 2500 log' \
    'keep damper every 0.1 to 0.3' 'keep damper max unit m' 'keep damper.rate falls 0.1 unit s' \
    'keep body.pos.z mean' 'keep kinetic at 0.3'
ends 0 'damper max .* m .*'"$runs" study car.study -o one.csv --quiet
for jobs in 2 3; do
    ends 0 'damper max' study car.study -o "$jobs.csv" --jobs $jobs
    cmp -s one.csv "$jobs.csv" || fail "$jobs processes have other results than one"
done
[ "$(wc -l <one.csv)" -eq $((runs + 1)) ] || fail "one.csv has $(wc -l <one.csv) lines"
ends 0 'damper max' study car.study -o one.csv # done already
ends 0 '"done": '"$runs"', "failed": 0' study car.study -o one.csv --json

# the same numbers as a run of its own
line=$(sed -n 8p one.csv)
mass=$(echo "$line" | cut -d, -f2)
damping=$(echo "$line" | cut -d, -f3)
"$program" run quarter_car.xml --t-end 0.3 --start pushed --step 0.1 --output damper --quiet \
    --set "bodies.body.mass=$mass" --set "forces.force2.damping=$damping" >run.csv
for k in 2 3 4 5; do
    single=$(sed -n "${k}p" run.csv | cut -d, -f2)
    [ "$single" = "$(echo "$line" | cut -d, -f$((k + 2)))" ] || fail "run 6: damper at line $k: $single: $line"
done

# by MPI, where the program and the machine have it
mpirun=${4:-}
if [ -n "$mpirun" ]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
    for processes in 1 3; do
        "$mpirun" -n $processes "$program" study car.study -o "mpi$processes.csv" --quiet >out 2>err </dev/null ||
            { fail "mpirun -n $processes"; cat out err; }
        cmp -s one.csv "mpi$processes.csv" || fail "$processes processes of MPI have other results than one"
    done
    "$mpirun" -n 2 "$program" study none.study >out 2>err && fail "mpirun: there is no study"
fi

# ---- killed ----

k=0
while [ $k -lt $kills ]; do
    "$program" study car.study -o killed.csv --jobs 2 --quiet >/dev/null 2>&1 &
    process=$!
    sleep "0.$((k % 3 + 1))"
    signal=KILL
    [ $((k % 3)) -ne 2 ] || signal=TERM
    kill -$signal $process 2>/dev/null
    wait $process 2>/dev/null
    k=$((k + 1))
done
ends 0 'damper max' study car.study -o killed.csv --jobs 2
cmp -s one.csv killed.csv || fail "a study that was killed has other results"

# half a run at the end of a journal, as a machine that has crashed leaves it
truncate -s -5 killed.csv.runs/0.journal
rm killed.csv
ends 0 'runs are done already' study car.study -o killed.csv
cmp -s one.csv killed.csv || fail "a journal cut short gives other results"

# ---- runs that fail ----

write fails 'model quarter_car.xml' 'run --t-end 0.2' 'limit 40 steps' 'sample list' 'vary bodies.body.mass' \
    'vary forces.force1.stiffness' 'keep damper max' 'values 300 1.8e5' 'values -1 1.8e5' 'values 300 1.9e5'
ends 0 '3 of 3 runs failed; run 0: more than 40 steps' study fails.study -o fails.csv
sed -i 's/^limit.*//' fails.study
ends 2 'belongs to another study' study fails.study -o fails.csv
ends 0 '1 of 3 runs failed; run 1: .*mass is -1' study fails.study -o fails.csv --anew
grep -q '^1,-1,180000,,failed,-1003,0,".*mass is -1' fails.csv || { fail "the text of run 1"; cat fails.csv; }
write slow 'model quarter_car.xml' 'run --t-end 1 --start pushed' 'limit 1e-6 s' 'sample list' 'vary bodies.body.mass' \
    'keep damper at 1' 'values 300'
for time in 1 2; do ends 0 '1 runs took too long' study slow.study -o slow.csv; done
grep -q ',time,' slow.csv || fail "a run that took too long is not marked"

# ---- refused before the first run ----

# refused WORDS LINE: the study with another line in the place of the last one
refused() {
    write bad 'model quarter_car.xml' 'run --t-end 1' 'sample sobol 4' 'vary bodies.body.mass 1 2' "$2" 'keep damper max'
    ends "${3:-2}" "$1" study bad.study
    [ ! -e bad.h5.runs ] && [ ! -e bad.csv.runs ] || fail "$2: something was begun"
}
refused 'bad.study:5: there is no parameter bodies.body.weight' 'vary bodies.body.weight 1 2'
refused "bad.study:5: forces.force2.damping has the unit 'N.s/m', not 'kg'" 'vary forces.force2.damping 1 2 unit kg'
refused "bad.study:5: there is no column 'dampers'" 'keep dampers max'
refused "bad.study:5: 'damper' has the unit 'm', not 'rad'" 'keep damper max unit rad'
refused "bad.study:5: time 1.5 of 'damper' is behind --t-end 1" 'keep damper at 1 1.5'
refused "bad.study:5: no line of a study begins with 'vari'" 'vari x 1 2' 3
printf '%s' '<mujoco><worldbody><body><joint type="slide"/><geom size=".1" mass="1"/><site name="s"/></body></worldbody>' \
    '<sensor><accelerometer name="felt" site="s"/><velocimeter name="seen" site="s"/></sensor></mujoco>' >felt.xml
write bad 'model felt.xml' 'run --t-end 0.1' 'sample latin 1 seed 1' 'vary bodies.body0.mass 1 2' 'keep seen.x rises 1' 'keep felt.x rises 1'
ends 2 "bad.study:6: crossings are of positions and velocities, not of 'felt.x'" study bad.study
write bad 'model quarter_car.xml' 'run --t-ende 1' 'sample sobol 4' 'vary bodies.body.mass 1 2' 'keep damper max'
ends 2 'bad.study:2: run: there is no option --t-ende' study bad.study
write bad 'model none.xml' 'run --t-end 1' 'sample sobol 4' 'vary bodies.body.mass 1 2' 'keep damper max'
ends 3 'none.xml cannot be read' study bad.study
write bad 'sample sobol 4' 'vary bodies.body.mass 1 2' 'keep damper max'
ends 3 'there is no line of model' study bad.study
ends 3 'none.study cannot be read' study none.study
ends 2 'there is no file' study
ends 2 'no option --fast' study car.study --fast
ends 2 'whole number' study car.study --jobs 1.5
ends 0 'damper max' study car.study -o changed.csv
sed -i 's/mass="300"/mass="301"/' quarter_car.xml
ends 2 'its file or its model has changed' study car.study -o changed.csv
sed -i 's/mass="301"/mass="300"/' quarter_car.xml

# ---- pictures ----

ends 2 "one.csv has no column 'dampers'" plot one.csv -o a.svg --columns dampers
ends 2 "one.csv has no column 'x'" plot one.csv -o a.svg --over x
ends 2 'for results of a study' plot run.csv -o a.svg --over x
if command -v gnuplot >/dev/null; then
    "$program" plot one.csv -o a.svg || fail 'plot'
    for words in 'damper, ' '5 to 95' 'damper max' 'kinetic at 0.3'; do
        grep -q "${words%, }" a.svg || fail "plot: there is no '$words' in the picture"
    done
    "$program" plot one.csv -o b.svg --columns 'damper at 0.2' --over bodies.body.mass
    grep -q 'bodies.body.mass' b.svg || fail 'plot --over'
    if "$program" study car.study -o c.h5 --quiet >/dev/null 2>&1; then
        "$program" plot c.h5 -o c.svg --columns 'damper,damper max'
        grep -q 'damper max, m' c.svg || fail 'plot of HDF5: no unit'
    fi
fi

# ---- a full disk: at every write ----

if [ -n "$full" ]; then
    write small 'model quarter_car.xml' 'run --t-end 0.05' 'sample grid' 'vary bodies.body.mass 250 400 levels 4' \
        'keep damper at 0.05' 'keep damper max'
    for ending in csv h5; do
        ends 0 'damper max' study small.study -o "whole.$ending"
        at=1
        while [ $at -le 40 ]; do
            rm -rf full.*
            MBSR_FULL_AT=$at LD_PRELOAD=$full "$program" study small.study -o "full.$ending" >out 2>err
            got=$?
            [ $got -ne 0 ] || break
            grep -q 'cannot be written\|No space left' err || { fail "write $at of $ending: no clear error"; cat err; }
            [ ! -e "full.$ending" ] || fail "write $at of $ending: there is a result"
            ends 0 'damper max' study small.study -o "full.$ending"
            cmp -s "full.$ending" "whole.$ending" || fail "write $at: another $ending when there is room again"
            at=$((at + every))
        done
        [ $at -gt 4 ] || fail "$ending: there were $at writes"
        [ $at -le 40 ] || fail "$ending: there are too many writes"
    done
fi

# ---- a small disk that is full, where one may be mounted ----

mkdir disk
if mount -t tmpfs -o size=64k tmpfs disk 2>/dev/null; then
    write disk 'model quarter_car.xml' 'run --t-end 0.3 --start pushed --step 0.01' 'sample latin 30 seed 4' \
        'vary bodies.body.mass 250 400' 'keep damper every 0.01 to 0.3'
    ends 0 'at more times' study disk.study -o roomy.csv
    head -5 one.csv >old.csv
    cp old.csv disk/old.csv
    for room in 56 44 32; do # kB taken: the journal finds no room, then the result
        dd if=/dev/zero of=disk/filler bs=1k count=$room 2>/dev/null
        ends 4 'cannot be written: No space left' study disk.study -o disk/a.csv
        [ ! -e disk/a.csv ] || fail "full disk: there is a result beside $room kB"
        cmp -s disk/old.csv old.csv || fail "full disk: what was there has changed"
        rm disk/filler
    done
    ends 0 'at more times' study disk.study -o disk/a.csv
    cmp -s disk/a.csv roomy.csv || fail 'other results when the disk has room again'
    umount disk
fi
exit $failed
