#!/bin/sh
# Each call of the operating system that mbsrank makes fails in turn, and each allocation: it ends as it should, with a word on
# standard error, or does what it does without the failure.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: faults.sh PROGRAM PROJECT_DIR FAULTS    FAULTS: the library of faults.c
set -u
program=$1
models=$2/examples/models
faults=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
long=${MBSR_TEST_LONG:-0}
failed=0
tries=0

fail() {
    echo "$1"
    head -5 err 2>/dev/null
    failed=1
}

# try FUNCTION AT RESULT ARGUMENT...: what RESULT names is a result that is whole, or there is none.
try() {
    function=$1 at=$2 result=$3
    shift 3
    rm -rf "$result" count study.csv.*
    MBSR_FAULT=$function MBSR_FAULT_AT=$at MBSR_FAULT_COUNT=$work/count LD_PRELOAD=$faults "$program" "$@" >out 2>err </dev/null
    got=$?
    tries=$((tries + 1))
    if [ $got -gt 128 ]; then
        fail "mbsrank $*: $function $at: ended by signal $((got - 128))"
    elif [ $got -ne 0 ]; then
        [ -s err ] || fail "mbsrank $*: $function $at: ended with $got without a word"
    elif [ "$result" != none ]; then
        [ -s "$result" ] || fail "mbsrank $*: $function $at: ended well without a result"
        cmp -s "$result" "good/$result" || fail "mbsrank $*: $function $at: ended well with another result"
    fi
}

# each RESULT FUNCTIONS ARGUMENT...: every call of every function; two of each in the short form.
each() {
    result=$1 functions=$2
    shift 2
    rm -rf "$result"
    "$program" "$@" >out 2>err </dev/null || fail "mbsrank $*: ends with $? where nothing fails"
    mkdir -p good
    [ "$result" = none ] || cp "$result" good/
    for function in $functions; do
        try "$function" 0 "$result" "$@"
        calls=$(cat count)
        step=1
        [ "$long" = 0 ] && step=$((calls / 2 + 1))
        at=1
        while [ $at -le "$calls" ]; do
            try "$function" $at "$result" "$@"
            at=$((at + step))
        done
    done
}

car=$models/quarter_car.xml
each none 'fopen fread realpath' info "$car"
each arm.xml 'fclose fflush' convert "$models/arm.urdf" arm.xml
each run.csv 'fopen fflush' run "$car" --t-end 0.01 --quiet -o run.csv
"$program" view "$car" -o view.html >out 2>err && each view.html 'fopen fclose fflush' view "$car" -o view.html

# allocations ARGUMENT...: each of them, in one process. SUNDIALS and HDF5 use what they have not got: no runs, no .h5.
allocations() {
    rm -f count
    MBSR_FAULT_EACH=1 MBSR_FAULT=malloc MBSR_FAULT_COUNT=$work/count LD_PRELOAD=$faults "$program" "$@" >out 2>err </dev/null ||
        fail "mbsrank $*: an allocation fails: ended with $?"
    [ -s count ] || return # main did not return
    [ "$(cat count)" -eq 0 ] && return # another C library than GNU's
    [ "$(cat count)" -gt 50 ] || fail "mbsrank $*: few allocations"
    tries=$((tries + $(cat count)))
}

allocations info --json "$car"
allocations info --parameters "$models/wiper.sdf"
allocations check "$car"
allocations check --json "$models/wiper.sdf"
allocations convert "$models/arm.urdf" arm.xml
printf 'before<!--data-->after' >bundle
export MBSRANK_VIEWER="$work/bundle"
allocations view "$car" run.csv -o -
unset MBSRANK_VIEWER
if "$program" --help | grep -q '^  modes'; then
    allocations static --trim forces.force1.rest --hold all "$car"
    allocations modes "$car"
    allocations modes --count 2 --json "$car"
    allocations modes --mode 1 -o mode.csv "$car"
    allocations linearise --json --inputs tyre --outputs tyre,bodies.body.z "$car"
    allocations linearise --inputs tyre -o linear.mat "$car"
    allocations linearise --inputs forces.force1.rest --outputs bodies.body.z --response 0.5:5:3 "$car"
fi
"$program" --help | grep -q '^  fmu' && allocations fmu "$models/arm.urdf" -o arm.fmu
if "$program" --help | grep -q '^  study'; then
    cp "$car" .
    printf '%s\n' 'model quarter_car.xml' 'run --t-end 0.01' 'sample grid' 'vary bodies.body.mass 250 400 levels 2' \
        'keep damper max' >small.study
    each study.csv 'mkdir opendir flock fsync rename fork mmap fopen' study small.study --jobs 2 -o study.csv
fi
echo "$tries tries"
exit $failed
