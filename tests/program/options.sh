#!/bin/sh
# Options of mbsrank: each that takes a value is refused without one, by its name, and so are those of other commands, too many
# of them, and what is no number. What cannot be written to standard output.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: options.sh PROGRAM PROJECT_DIR WITH_RUN (1 or 0)
set -u
program=$1
models=$2/examples/models
with_run=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

# refused WORDS ARGUMENT...: wrong use, with these words on standard error and nothing on standard output.
refused() {
    words=$1
    shift
    "$program" "$@" >"$work/out" 2>"$work/err" </dev/null
    got=$?
    if [ $got -ne 2 ] || [ -s "$work/out" ] || ! grep -q -e "$words" "$work/err"; then
        echo "mbsrank $*: ended with $got, expected 2 and '$words'"
        cat "$work/out" "$work/err"
        failed=1
    fi
}

model="--start --package --arg --folder --stop-stiffness --stop-damping --slip --set"
drive="--t-end --step --rtol --atol --form --output --inputs -o"
linear="--inputs --outputs --count --trim --hold --response --mode -o"
car=$models/quarter_car.xml

# without COMMAND OPTION...: each needs a value, at the end and before others.
without() {
    command=$1
    shift
    for option; do refused "$option needs a value" "$command" "$car" "$option"; done
}

has() { "$program" --help | grep -q "^  $1 "; }

without info $model
without check $model --time --tolerance
without view $model --inputs -o
without convert --package --arg --folder
without plot -o --columns --over --title
if [ "$with_run" = 1 ]; then
    without run $model $drive
    if has study; then
        without study --jobs -o
        without fit --data --vary --noise -o
    fi
fi
if has fmu; then without fmu $model -o --fmi --kind --fixed-step --order --rtol --atol --t-end --step --name; fi
if has modes; then
    without modes $model $linear
    for command in static linearise; do without $command --start $linear; done
    for option in --inputs --outputs --response --count; do refused 'are for modes and linearise' static "$option" x "$car"; done
    refused 'are for modes and linearise' static --as-drawn "$car"
    for option in --mode -o; do refused 'are for modes' static "$option" 1 "$car"; done
    refused '--hold is for --trim' static --hold all "$car"
    for option in --inputs --outputs --response; do refused 'are for linearise' modes "$option" x "$car"; done
    for option in --trim --hold; do
        refused 'are for static' modes "$option" x "$car"
        refused 'are for static' linearise "$option" x "$car"
    done
    refused '--count is for modes' linearise --count 3 "$car"
    refused '--mode is for modes' linearise --mode 1 "$car"
    for count in 0 1001 many; do refused '--count is 1 .. 1000' modes --count $count "$car"; done
    refused '--count is 1 .. 1000' modes --count 2 --as-drawn "$car"
    refused '--mode K from 1 on' modes --mode 0 -o "$work/a" "$car"
    refused '--mode K from 1 on' modes --mode 1 "$car"
    refused '--mode K from 1 on' modes -o "$work/a" "$car"
    refused '--mode K from 1 on' modes --mode 1 -o "$work/a" --count 3 "$car"
    for response in 1 0:1:2 2:1:2 1:inf:2 1:2:0 1:2:200000 1:2:3:4; do
        refused '--response is FROM:TO:COUNT' linearise --inputs tyre --outputs bodies.body.z --response $response "$car"
    done
fi

# pairs: what is none, too many, no number
refused "is not NAME=DIR" info --package folder "$car"
refused "is not NAME=DIR" info --package =folder "$car"
refused "is not NAME=VALUE" info --arg name "$car"
refused "is not NAME=VALUE" info --set name "$car"
refused "which is no number" info --set name= "$car"
refused "which is no number" info --set name=1x "$car"
refused "which is no number" info --set name=inf "$car"
many() { # OPTION VALUE COUNT: as many arguments
    k=0
    while [ $k -lt "$3" ]; do
        printf '%s %s ' "$1" "$2"
        k=$((k + 1))
    done
}
refused '--set: there are more than' info $(many --set a=1 1100) "$car"
refused '--arg: there are more than' info $(many --arg a=1 1100) "$car"
refused '--package: there are more than' info $(many --package a=b 1100) "$car"
refused '--folder: there are more than' info $(many --folder . 40) "$car"

if [ "$with_run" = 1 ] && has fit; then
    fit="fit $car --data none.csv"
    refused "is no parameter" $fit --vary =1:2
    refused "comes twice" $fit --vary a --vary a
    for range in a= a=1 a=1: a=x:2 a=2:1 a=1:2x; do refused "is not NAME=LOW:HIGH" $fit --vary $range; done
    for noise in x =1; do refused "is not COLUMN=DEVIATION" $fit --vary a --noise $noise; done
    refused 'noise' $fit --vary a --noise x=y
    for jobs in 0 -1 1.5 2000 many; do refused 'jobs' study --jobs $jobs none.study; done
    refused 'second one' study a.study b.study
    refused 'there is no file' study
    refused 'no option --fast' study --fast a.study
fi

# A full disk behind standard output.
lost() {
    "$program" "$@" >/dev/full 2>"$work/err" </dev/null
    got=$?
    if [ $got -ne 4 ] || ! grep -q 'cannot be written' "$work/err"; then
        echo "mbsrank $* >/dev/full: ended with $got, expected 4 and 'cannot be written'"
        cat "$work/err"
        failed=1
    fi
}
if [ -e /dev/full ]; then
    lost --help
    lost --version
    lost info --help
    for command in 'info' 'info --json' 'info --parameters' 'check' 'check --json'; do lost $command "$car"; done
    if has modes; then for command in static modes linearise; do lost $command "$car"; done; fi
    if [ "$with_run" = 1 ]; then
        lost run --t-end 0.01 "$car"
        lost run --t-end 0.01 --json -o "$work/run.csv" "$car"
    fi
fi
exit $failed
