#!/bin/sh
# Parameters from data: without noise the truth comes out, with it the intervals hold it; what is refused.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: fit.sh PROGRAM PROJECT_DIR
set -u
program=$1
car=$2/examples/models/quarter_car.xml
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failed=0

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

# noisy SEED SHARE FILE: each column with normal noise of so much of its largest number.
noisy() {
    awk -F, -v seed="$1" -v share="$2" '
        NR == FNR { for (k = 2; k <= NF && FNR > 1; ++k) { x = $k < 0 ? -$k : $k; if (x > most[k]) most[k] = x } next }
        FNR == 1 { srand(seed); print; next }
        { line = $1
          for (k = 2; k <= NF; ++k)
              line = line sprintf(",%.9g", $k + share * most[k] * sqrt(-2 * log(1 - rand())) * cos(6.283185307 * rand()))
          print line }' "$3" "$3"
}

# within VALUE TRUTH RELATIVE
within() {
    awk -v x="$1" -v y="$2" -v e="$3" 'BEGIN { d = x - y; exit !(x != "" && (d < 0 ? -d : d) <= e * (y < 0 ? -y : y)) }'
}

# number PARAMETER FIELD: of the line of a parameter in out
number() {
    awk -v name="$1" -v field="$2" '$1 == name { print $field }' out
}

"$program" run "$car" --t-end 0.4 --step 0.02 --start pushed --output damper,rubber --quiet --rtol 1e-9 --atol 1e-10 >clean.csv
pair="--vary forces.force2.damping=100:10000 --vary forces.force3.stiffness"
# shellcheck disable=SC2086 # several words
ends 0 'deviation' fit "$car" --start pushed --data clean.csv $pair --set forces.force2.damping=1200 --noise damper=1e-3 --noise rubber=1e-4
within "$(number forces.force2.damping 2)" 1500 1e-5 || { fail 'the damping without noise'; cat out; }
within "$(number forces.force3.stiffness 2)" 160000 1e-5 || { fail 'the stiffness without noise'; cat out; }
# The law of a contact is by the masses of the file, whatever the mass that is looked for: how a ball sinks in tells it.
printf '%s' '<mujoco><worldbody><geom type="plane" size="0 0 1"/><body name="b" pos="0 0 .5"><freejoint/>' \
    '<geom type="sphere" size=".1" mass="4"/></body></worldbody></mujoco>' >ball.xml
"$program" run ball.xml --t-end 0.6 --step 0.02 --output b.pos --quiet --rtol 1e-9 --atol 1e-10 >ball.csv
if "$program" run ball.xml --t-end 0.1 2>&1 | grep -q 'shapes touch'; then
    ends 0 'deviation' fit ball.xml --data ball.csv --vary bodies.b.mass=2:10 --set bodies.b.mass=5
    grep -q '^b.pos.y is met exactly' out || { fail 'a column without noise'; cat out; }
    within "$(number bodies.b.mass 2)" 4 1e-5 || { fail 'the mass of a ball'; cat out; }
fi
# With a closure, and a finger that moves by rounding alone, which says nothing.
arm=$2/examples/models/arm.urdf
"$program" run "$arm" --t-end 0.4 --step 0.02 --set 'bodies.upper.com[3]=.23' --output elbow,shoulder,left_finger --quiet --rtol 1e-10 --atol 1e-11 >arm.csv
ends 0 'left_finger is met exactly' fit "$arm" --data arm.csv --vary 'bodies.upper.com[3]'
within "$(number 'bodies.upper.com[3]' 2)" 0.23 1e-5 || { fail 'the centre of mass of an arm'; cat out; }
# by sensitivities; by differences, which a column with accelerations needs
ends 0 '"runs": [1-9]}' fit "$car" --start pushed --data clean.csv $pair --set forces.force2.damping=1200 --noise damper=1e-3 --noise rubber=1e-4 --json
noisy 1 0.02 clean.csv >noise.csv
# shellcheck disable=SC2086
ends 0 'noise of damper' fit "$car" --start pushed --data noise.csv $pair -o fitted.csv
within "$(number forces.force2.damping 2)" 1500 0.1 || { fail 'the damping'; cat out; }
[ "$(head -1 fitted.csv)" = 't,"damper.measured","damper.fitted","rubber.measured","rubber.fitted"' ] || fail 'the first line of fitted.csv'
[ "$(wc -l <fitted.csv)" -eq 22 ] || fail 'fitted.csv'
ends 0 'the data do not tell +1.00 bodies.body.Ixx' fit "$car" --start pushed --data noise.csv --vary forces.force2.damping --vary bodies.body.Ixx
ends 0 '"unit": "N.s/m", "value": 1[45][0-9][0-9]\.' fit "$car" --start pushed --data noise.csv --vary forces.force2.damping --json
"$program" fit "$car" --start pushed --data noise.csv --vary forces.force2.damping=1600:2000 --set forces.force2.damping=1700 >out 2>err
grep -q 'at its lower bound' out || { fail 'a bound'; cat out err; }

ends 2 '--data is missing' fit "$car" --vary forces.force2.damping
ends 2 'nothing is fitted' fit "$car" --data noise.csv
ends 2 'there is no parameter forces.force2.damp;' fit "$car" --data noise.csv --vary forces.force2.damp
ends 2 'is not NAME=LOW:HIGH' fit "$car" --data noise.csv --vary forces.force2.damping=2
ends 2 'is not NAME=LOW:HIGH' fit "$car" --data noise.csv --vary forces.force2.damping=2:1
ends 2 'comes twice' fit "$car" --data noise.csv --vary a --vary a
ends 2 'begins at 1500, which is not in 1 .. 2' fit "$car" --data noise.csv --vary forces.force2.damping=1:2
ends 2 "has no column 'tyre'" fit "$car" --data noise.csv --vary forces.force2.damping --noise tyre=1
ends 2 'not COLUMN=DEVIATION' fit "$car" --data noise.csv --vary forces.force2.damping --noise tyre
ends 2 'no option --fast' fit "$car" --data noise.csv --vary forces.force2.damping --fast
printf 't,dampers\n0,1\n1,2\n' >wrong.csv
ends 2 "wrong.csv:1: there is no column 'dampers'" fit "$car" --data wrong.csv --vary forces.force2.damping
printf 't,damper\n' >wrong.csv
ends 3 'less than two lines' fit "$car" --data wrong.csv --vary forces.force2.damping
ends 3 'none.csv cannot be read' fit "$car" --data none.csv --vary forces.force2.damping

# Twenty parameters of a chain whose every other part has no mass: intervals of 95 % hold the truth.
if [ -n "${MBSR_TEST_LONG:-}" ]; then
    {
        echo '<mujoco><option gravity="0 0 -9.81"/><worldbody>'
        for k in 0 1 2 3 4 5 6 7 8 9; do
            printf '<body name="b%d"><joint name="j%d" type="slide" axis="0 0 1" stiffness="%d" damping="%d"/>' $k $k \
                $((1500 - 100 * k)) $((40 - 3 * k))
            [ $((k % 2)) -eq 0 ] || printf '<geom size="0.1" mass="1"/>'
        done
        for k in 0 1 2 3 4 5 6 7 8 9; do printf '</body>'; done
        echo '</worldbody></mujoco>'
    } >chain.xml
    columns=j0 vary=
    for k in 1 2 3 4 5 6 7 8 9; do columns=$columns,j$k; done
    "$program" info --parameters chain.xml 2>/dev/null | sed -n 's/^\(forces\.[^ ]*\.\(stiffness\|damping\)\) = \([0-9.]*\) .*/\1 \3/p' >truth
    [ "$(wc -l <truth)" -eq 20 ] || { fail "there are $(wc -l <truth) parameters"; cat truth; }
    while read -r name value; do vary="$vary --vary $name"; done <truth
    "$program" run chain.xml --t-end 1 --step 0.02 --output $columns --quiet --rtol 1e-9 --atol 1e-10 2>/dev/null >chain.csv
    : >held
    seed=1
    while [ $seed -le 100 ]; do
        noisy $seed 0.01 chain.csv >noise.csv
        # shellcheck disable=SC2086
        "$program" fit chain.xml --quiet --data noise.csv $vary >out 2>err || { fail "seed $seed"; cat err; }
        while read -r name value; do
            echo "$name $(number "$name" 4) $(number "$name" 6) $value"
        done <truth >>held
        seed=$((seed + 1))
    done
    awk '{ ++all; in_it = $2 <= $4 && $4 <= $3; inside += in_it; each[$1] += in_it }
        END { for (name in each) { print name, each[name]; if (each[name] < 88) bad = 1 }
              print inside / all; exit bad || all != 2000 || inside < 0.93 * all || inside > 0.97 * all }' held ||
        fail 'intervals'
fi
exit $failed
