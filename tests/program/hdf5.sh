#!/bin/sh
# Runs as HDF5: the numbers are those of CSV to the bit, files that are no runs are refused by name, Ctrl-C keeps what was
# computed.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: hdf5.sh PROGRAM PROJECT_DIR HDF5_FILE     HDF5_FILE: the program of hdf5_file.c; empty: the build has no HDF5
set -u
program=$1
models=$2/examples/models
hdf5_file=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

fail() {
    echo "$1"
    failed=1
}

# ends CODE WORDS ARGUMENT...: ends with that code and says the words.
ends() {
    code=$1 words=$2
    shift 2
    "$program" "$@" >"$work/out" 2>&1 </dev/null
    got=$?
    if [ $got -ne "$code" ] || ! grep -q -e "$words" "$work/out"; then
        fail "mbsrank $*: ended with $got, expected $code and '$words'"
        cat "$work/out"
    fi
}

if [ -z "$hdf5_file" ]; then
    ends 4 'run.h5: this mbsrank was built without HDF5' run "$models/arm.urdf" --t-end 1 -o "$work/run.h5"
    ends 4 'run.hdf5: this mbsrank was built without HDF5' plot "$work/run.hdf5" -o "$work/a.svg"
    echo "HDF5 is not part of this build: only that is tested"
    exit $failed
fi

# same NAME OPTION...: a run as CSV and as HDF5.
same() {
    name=$1
    shift
    "$program" run "$@" --quiet -o "$work/$name.csv" && "$program" run "$@" --quiet -o "$work/$name.h5" &&
        "$hdf5_file" csv "$work/$name.h5" >"$work/back.csv" && cmp "$work/$name.csv" "$work/back.csv" ||
        fail "$name: HDF5 and CSV are not the same"
}

# says NAME VALUE: an attribute of arm.h5.
says() {
    got=$("$hdf5_file" attribute "$work/arm.h5" "$1")
    [ "$got" = "$2" ] || fail "attribute $1 is '$got', not '$2'"
}

same arm "$models/arm.urdf" --t-end 1 --output state,hand.pos,energy --rtol 1e-5
says format 'mbsrank run 1'
says model "$models/arm.urdf"
says form momentum
says rtol 1.0000000000000001e-05
says end 'done'
says lines 101
says elbow/unit rad
says left_finger.rate/unit m/s
says hand.pos.z/unit m
says kinetic/unit J
says t/unit s
steps=$("$hdf5_file" attribute "$work/arm.h5" steps)
"$program" run "$models/arm.urdf" --t-end 1 --rtol 1e-5 --json --quiet -o "$work/other.csv" |
    grep -q "^{\"end\": \"done\", \"t\": 1, \"lines\": 101, \"steps\": $steps," || fail "--json has no $steps steps"
same many "$models/quarter_car.xml" --start pushed --t-end 1 --step 0.0004 --output state # more lines than a block
same short "$models/quarter_car.xml" --t-end 0.01 --step 1

# names that are there twice, that would be groups, or the time
cat >"$work/names.xml" <<'END'
<mujoco><worldbody><body><freejoint/><geom size="1"/><body><joint name="a/b"/><geom size="1"/>
<body><joint/><joint axis="1 0 0"/><geom size="1"/><body><joint name="t" type="ball"/><geom size="1"/></body></body></body></body></worldbody>
<actuator><motor name="m" joint="a/b"/></actuator></mujoco>
END
same names "$work/names.xml" --t-end 0.1 --output state
[ "$("$hdf5_file" attribute "$work/names.h5" 'joint.px/unit')" = m ] || fail "the unit of joint.px"
[ "$("$hdf5_file" attribute "$work/names.h5" 'joint.vz/name' 2>&1)" != joint.vz ] || fail "joint.vz is not its rate"
[ "$("$hdf5_file" attribute "$work/names.h5" 'joint.rate.vz/unit')" = m/s ] || fail "the unit of joint.rate.vz"
[ "$("$hdf5_file" attribute "$work/names.h5" 'a:b/name')" = a/b ] || fail "the name of a:b"

# view and plot, and inputs
printf 'before<!--data-->after' >"$work/bundle"
MBSRANK_VIEWER=$work/bundle
export MBSRANK_VIEWER
for ending in csv h5; do
    "$program" view "$models/arm.urdf" "$work/arm.$ending" -o "$work/$ending.html" 2>/dev/null || fail "no page of arm.$ending"
done
cmp "$work/csv.html" "$work/h5.html" || fail "the pages are not the same"
cp "$models/arm.urdf" "$work/arm.urdf"
echo '<!-- changed -->' >>"$work/arm.urdf"
ends 0 'the run is of a model with another text' view "$work/arm.urdf" "$work/arm.h5" -o -
if command -v gnuplot >/dev/null; then
    for ending in csv h5; do
        "$program" plot "$work/arm.$ending" -o "$work/$ending.svg" --columns hand || "$program" plot \
            "$work/arm.$ending" -o "$work/$ending.svg" --columns hand.pos || fail "no picture of arm.$ending"
    done 2>/dev/null
    cmp "$work/csv.svg" "$work/h5.svg" || fail "the pictures are not the same"
fi

# what is refused
refused() {
    ends 3 "$1" plot "$work/bad.h5" -o "$work/a.svg"
}
head -c 9000 "$work/arm.h5" >"$work/bad.h5"
refused 'bad.h5 cannot be read: truncated file'
cp "$work/arm.csv" "$work/bad.h5"
refused 'bad.h5 cannot be read: file signature not found'
rm "$work/bad.h5"
refused 'bad.h5 cannot be read: unable to open file'
"$hdf5_file" foreign "$work/bad.h5"
refused 'bad.h5 is HDF5, but no run of mbsrank'
cp "$work/arm.h5" "$work/bad.h5"
"$hdf5_file" shorten "$work/bad.h5" elbow
refused "bad.h5: column 'elbow' has not as many numbers as t"
cp "$work/arm.h5" "$work/bad.h5"
"$hdf5_file" put "$work/bad.h5" pitch 7 nan
refused "bad.h5: 'pitch'\[7\] is no number"
"$hdf5_file" put "$work/bad.h5" pitch 7 0
"$hdf5_file" put "$work/bad.h5" t 8 0.01
refused 'bad.h5: t\[8\]: times must ascend'
"$hdf5_file" drop "$work/bad.h5" roll
refused 'bad.h5: there is no column 3'
"$hdf5_file" drop "$work/bad.h5" t
refused 'bad.h5: the first column must be t'
ends 4 'run.h5 cannot be written: unable to' run "$models/arm.urdf" --t-end 1 -o "$work/none/run.h5"

# matrices of linear equations
if "$program" --help | grep -q '^  linearise'; then
    for ending in csv h5; do
        "$program" linearise --inputs tyre --outputs damper -o "$work/linear.$ending" "$models/quarter_car.xml"
    done
    for name in descriptor_E descriptor_A descriptor_B A B C D; do
        "$hdf5_file" matrix "$work/linear.h5" $name
    done | cmp - "$work/linear.csv" || fail "matrices in HDF5 are not those in CSV"
    ends 4 'linear.h5 cannot be written: unable to' linearise -o "$work/none/linear.h5" "$models/quarter_car.xml"
fi

# stopped before its end
for ending in csv h5; do
    "$program" run "$models/arm.urdf" --t-end 1e6 --step 0.01 --quiet -o "$work/stopped.$ending" 2>"$work/err" &
    for _ in $(seq 300); do # on a busy processor it starts late, and a shell's background ignores the signal until then
        [ ! -s "$work/stopped.$ending" ] || break
        sleep 0.1
    done
    for more in $(seq 300); do # until there are lines enough; of the file in HDF5, as long as those took
        sleep 0.1
        if [ $ending = csv ]; then took=$more lines=$(wc -l <"$work/stopped.csv"); fi
        if [ "$more" -ge 5 ] && [ "$more" -ge "$took" ] && [ "$lines" -gt 40 ]; then break; fi
    done
    kill -INT $!
    wait $!
    got=$?
    [ $got -eq 4 ] && grep -q 'stopped at t = .*kept' "$work/err" || fail "stopped.$ending: ended with $got"
done
[ "$("$hdf5_file" attribute "$work/stopped.h5" end)" = interrupted ] || fail "the file does not say that it was stopped"
"$hdf5_file" csv "$work/stopped.h5" >"$work/back.csv"
both=$(wc -l <"$work/back.csv")
[ "$both" -le "$(wc -l <"$work/stopped.csv")" ] || both=$(wc -l <"$work/stopped.csv")
[ "$both" -gt 20 ] || fail "only $both lines before it was stopped"
head -n "$both" "$work/stopped.csv" >"$work/one"
head -n "$both" "$work/back.csv" | cmp - "$work/one" || fail "the stopped runs are not the same"
exit $failed
