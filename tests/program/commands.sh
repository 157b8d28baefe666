#!/bin/sh
# The commands of mbsrank: what they write, what they refuse, how they end.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: commands.sh PROGRAM PROJECT_DIR WITH_RUN (1 or 0) [SHORT (1: short runs, as under sanitizers)]
set -u
program=$1
models=$2/examples/models
with_run=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

short=${4:-0} seconds=1
if [ "$short" = 1 ]; then seconds=0.2; fi

# ends CODE WORDS ARGUMENT...: ends with that code and says the words on either stream.
ends() {
    code=$1 words=$2
    shift 2
    "$program" "$@" >"$work/out" 2>"$work/err" </dev/null
    got=$?
    if [ $got -ne "$code" ] || ! grep -q -e "$words" "$work/out" "$work/err"; then
        echo "mbsrank $*: ended with $got, expected $code and '$words'"
        cat "$work/out" "$work/err"
        failed=1
    fi
}

ends 0 'usage: mbsrank COMMAND' --help
ends 0 '^mbsrank [0-9]' --version
ends 2 'no command' fly
ends 2 'usage: mbsrank COMMAND'
"$program" 2>/dev/null | grep -q . && { echo 'without arguments mbsrank writes to standard output'; failed=1; }
for command in info check; do
    ends 0 "usage: mbsrank $command" $command --help
    ends 2 'there is no file' $command
    ends 2 'no option --fast' $command "$models/arm.urdf" --fast
    ends 2 'second one' $command "$models/arm.urdf" "$models/arm.urdf"
    ends 2 '--start needs a value' $command "$models/arm.urdf" --start
    ends 3 'none.urdf cannot be read: No such file or directory' $command "$work/none.urdf"
    ends 3 'cannot be read: Is a directory' $command "$work"
done

ends 0 'mass 7.7 kg' info "$models/arm.urdf"
ends 0 "slide 'damper' q\[1\]" info "$models/quarter_car.xml"
ends 0 '^    fore  1.2 kg  hinge' info "$models/arm.urdf"
ends 0 '^      wrist_1  no mass  hinge' info "$models/arm.urdf"
ends 0 '"name": "fore", "parent": 1, "massless": false, "mass": 1.2}' info --json "$models/arm.urdf"
ends 0 '"name": "wrist_1", "parent": 2, "massless": true, "mass": 0}' info --json "$models/arm.urdf"
ends 0 '"name": "elbow", "type": "hinge", "body": 2, "q": 1, "u": 1, "range": \[-2.5, 2.5\]}' info --json "$models/arm.urdf"
ends 0 '"nq": 7, "nu": 7, "rows": 1' info --json "$models/arm.urdf"
ends 0 '^bodies.body.mass = 300 kg$' info --parameters "$models/quarter_car.xml"
ends 0 '{"name": "forces.force0.gz", "value": -9.81' info --parameters --json "$models/quarter_car.xml"
ends 0 '^mass 56 kg' info --set bodies.body.mass=20 --set=bodies.wheel.mass=36 "$models/quarter_car.xml"
ends 2 'no parameter bodies.body.weight' info --set bodies.body.weight=20 "$models/quarter_car.xml"
ends 2 "body 2 'body'.*mass is -1" info --set bodies.body.mass=-1 "$models/quarter_car.xml"
ends 2 'which is no number' info --set bodies.body.mass=heavy "$models/quarter_car.xml"
ends 2 "no key 'up'" info --start up "$models/quarter_car.xml"
printf '<robot name="r">\n<link name="a"/>\n<link name="b"/>\n</robot>\n' >"$work/two.urdf"
ends 3 "two.urdf:3: link 'b': there is a second root" info "$work/two.urdf"
printf '<robot name="r">\n<link name="a"/>\n</robot>\n' >"$work/one.urdf"
ends 0 "one.urdf:2: link 'a': it has no <inertial>" info "$work/one.urdf"
ends 3 'strict' info --strict "$work/one.urdf"
ends 0 '"line": 2, "element": "link ' info --json "$work/one.urdf"
ends 1 '6 undetermined' check --floating "$work/one.urdf"
ends 1 '"undetermined": 6' check --json --floating "$work/one.urdf"
ends 0 "hinge 'rod_pin'" info "$models/wiper.sdf"
if "$program" --help | grep -q '^  modes'; then
    for command in static modes linearise; do
        ends 0 "usage: mbsrank $command" $command --help
        ends 2 'no option --fast' $command "$models/arm.urdf" --fast
        if [ "$short" = 1 ] && [ $command != linearise ]; then continue; fi
        ends 4 'no equilibrium was found.*base' $command --floating "$models/arm.urdf"
    done
    ends 0 '^  damper ' static "$models/quarter_car.xml"
    ends 0 '"steps": [0-9]*, "q": \[' static --json "$models/quarter_car.xml"
    ends 2 'for modes' static --as-drawn "$models/quarter_car.xml"
    ends 0 '^5 states; 4 of 9 equations eliminated' modes "$models/quarter_car.xml"
    ends 0 '^ *1.1704 *28.5.*damper 1.00, tyre 0.11' modes "$models/quarter_car.xml"
    ends 0 '^ *1.1704 *28.5.*damper 1.00.*energy in transmission 4 0.86' modes --count 1 "$models/quarter_car.xml"
    ends 2 'count is 1 .. 1000' modes --count 0 "$models/quarter_car.xml"
    ends 2 'count is for modes' linearise --count 2 "$models/quarter_car.xml"
    ends 0 '^6 states; 33 of 39' modes "$models/suspension.xml"
    ends 0 '"states": 2, "eliminated": 22' modes --json "$models/wiper.sdf"
    "$program" modes --mode 1 -o "$work/mode.csv" "$models/quarter_car.xml"
    [ "$(wc -l <"$work/mode.csv")" = 62 ] || { echo "the motion of a mode has not 62 lines"; failed=1; }
    ends 2 'there are' modes --mode 9 -o "$work/mode.csv" "$models/quarter_car.xml"
    ends 2 'goes with -o' modes --mode 1 "$models/quarter_car.xml"
    ends 2 'for linearise' modes --inputs tyre "$models/quarter_car.xml"
    ends 0 '^# D 2 1' linearise --inputs tyre --outputs tyre,damper "$models/quarter_car.xml"
    ends 0 '"B": \[\[' linearise --json --inputs tyre "$models/quarter_car.xml"
    ends 0 '^  forces.force1.rest = 0.018312 m' static --trim forces.force1.rest --hold all "$models/quarter_car.xml"
    ends 0 '"parameters": {"forces.force1.rest": 0.0183.*"growth": -2.18' static --json --trim forces.force1.rest --hold tyre "$models/quarter_car.xml"
    ends 0 'not determined' static --trim forces.force1.rest --hold rubber "$models/quarter_car.xml"
    ends 2 "no parameter 'wing'" static --trim wing "$models/quarter_car.xml"
    ends 2 "no joint 'wing'" static --trim forces.force1.rest --hold wing "$models/quarter_car.xml"
    ends 2 'hold is for --trim' static --hold all "$models/quarter_car.xml"
    ends 0 '^0.5,1.2033759' linearise --inputs forces.force1.rest --outputs bodies.body.z --response 0.5:5:3 "$models/quarter_car.xml"
    "$program" linearise --inputs tyre -o "$work/linear.mat" "$models/quarter_car.xml"
    "$program" linearise --inputs tyre -o "$work/linear.csv" "$models/quarter_car.xml"
    if command -v python3 >/dev/null; then
        python3 -B "$2/tests/program/mat.py" "$work/linear.mat" "$work/linear.csv" || failed=1
    fi
    ends 2 'name in .mat, .h5' linearise -o "$work/linear.txt" "$models/quarter_car.xml"
    ends 2 'name in .mat, .h5' linearise -o .csv "$models/quarter_car.xml" # an ending is no name
    ends 2 'FROM:TO:COUNT' linearise --inputs tyre --response 1:2 "$models/quarter_car.xml"
    ends 2 'has no motion\[1\]' linearise --inputs 'bodies.body.motion[1]' "$models/quarter_car.xml"
    ends 2 "no joint 'wing'" linearise --inputs wing "$models/quarter_car.xml"
fi
ends 0 '6 rows of closures, 3 independent; mobility 1' check "$models/wiper.sdf"
ends 0 '1 damped, 0 elastic, 0 undetermined; index 1' check "$models/quarter_car.xml"
ends 0 '"determined": true' check --json "$models/arm.urdf"

# xacro: arguments, packages, folders
mkdir -p "$work/robot/parts" "$work/other"
cat >"$work/robot/arm.urdf.xacro" <<'END'
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="mass" default="1"/>
  <xacro:include filename="$(find other)/link.xacro"/><xacro:link name="a" mass="${2 * $(arg mass)}"/>
</robot>
END
cat >"$work/other/link.xacro" <<'END'
<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="link" params="name mass">
  <link name="${name}"><inertial><mass value="${mass}"/></inertial></link>
  <link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>
</xacro:macro></robot>
END
model=$work/robot/arm.urdf.xacro
for command in info check; do
    ends 3 "arm.urdf.xacro:2: xacro:include: where the package 'other' is" $command "$model"
done
ends 0 'mass 2 kg' info "$model" --package "other=$work/other"
ends 0 "link.xacro:3: link 'b': it has no <inertial>" info "$model" --package "other=$work/other"
ends 0 'mass 5 kg' info "$model" --package="other=$work/other/" --arg mass=2.5
ends 2 "'mass' is not NAME=VALUE" info "$model" --arg mass
ends 0 "body 'b': it has no mass" convert "$model" "$work/to.xml" --package "other=$work/other" --arg mass=3
sed 's/$(find other)/..\/other/' "$model" >"$work/robot/up.xacro"
ends 3 "is elsewhere than the model" info "$work/robot/up.xacro"
ends 0 'mass 2 kg' info "$work/robot/up.xacro" --anywhere

# what no loop holds is named, all of it that is counted
cat >"$work/loop.xml" <<'END'
<mujoco><worldbody>
  <body name="arm"><joint name="ja" axis="0 1 0"/><geom type="sphere" size=".1" pos="1 0 0" mass="1"/>
    <body name="cross" pos="1 0 0"><joint name="jb" axis="0 1 0"/><joint name="jc" axis="1 0 0"/></body></body>
  <body name="dial"><joint name="jd" axis="0 1 0"/></body>
</worldbody><equality><joint joint1="ja" joint2="jd"/></equality></mujoco>
END
ends 1 'of which no loop holds 2' check "$work/loop.xml"
[ "$(grep -c '^undetermined: .*cross' "$work/out")" -eq 2 ] ||
    { echo "check names not both directions"; cat "$work/out"; failed=1; }
ends 1 '"directions": \[{"kind": "undetermined"' check --json "$work/loop.xml"

# small masses: a wheel of 36 g instead of 36 kg may be zero, one of 3.6 kg may not at 10 micrometres
sed 's/mass="36"/mass="0.036"/' "$models/quarter_car.xml" >"$work/light.xml"
sed 's/mass="36"/mass="3.6"/' "$models/quarter_car.xml" >"$work/wheel.xml"
sed 's/mass="36"/mass="360"/' "$models/quarter_car.xml" >"$work/heavy.xml"
ends 0 'no mass is below a tenth' check --small "$work/heavy.xml"
ends 0 'wheel .* may be zero' check --small --start pushed --time $seconds "$work/light.xml"
if [ "$short" != 1 ]; then
    ends 0 'wheel .* may not be zero' check --start pushed --time 2 --tolerance 1e-5 "$work/wheel.xml"
fi
ends 0 '"small_masses": {"from": 0, .*"body": "wheel", "parts": "both".*"verdict": "may be zero"' \
    check --small --json --start pushed --time $seconds "$work/light.xml"
cp "$work/out" "$work/small.json"
ends 1 '6 undetermined' check --small --floating "$work/one.urdf"
ends 2 "'0' is not" check --time 0 "$work/light.xml"
ends 2 'no option --small' info --small "$models/arm.urdf"
if command -v python3 >/dev/null; then
    python3 <"$work/small.json" -c 'import json, sys; r = json.load(sys.stdin); assert r["small_masses"]["masses"][0]["direction"]["body"] == "wheel" and r["index"] == 1' ||
        { echo "check --small --json is no JSON"; failed=1; }
fi

# files that a model names: from its folder, from meshes beside it, from folders that are named; no devices
mkdir -p "$work/robots/own" "$work/robots/meshes" "$work/far"
printf '<mujocoinclude><body name="part"><joint/><geom size="1"/></body></mujocoinclude>' >"$work/robots/meshes/part.xml"
for place in own/part.xml ../far/part.xml; do cp "$work/robots/meshes/part.xml" "$work/robots/$place"; done
for place in part.xml ../meshes/part.xml ../../far/part.xml /dev/zero; do
    printf '<mujoco><worldbody><include file="%s"/></worldbody></mujoco>' "$place" >"$work/robots/own/model.xml"
    case $place in
    /dev/zero) ends 3 'no file /dev/zero: No such device' info "$work/robots/own/model.xml" --anywhere ;;
    *far*)
        ends 3 'far/part.xml is elsewhere than the model: --folder' info "$work/robots/own/model.xml"
        ends 0 'hinge' info "$work/robots/own/model.xml" --folder "$work/far"
        ends 0 'hinge' info "$work/robots/own/model.xml" --anywhere ;;
    *) ends 0 'hinge' info "$work/robots/own/model.xml" ;;
    esac
done

# control characters of a file do not reach the terminal
printf '<mujoco model="a&#127;b&#x9b;c"><worldbody><body name="d&#9;e"/></worldbody></mujoco>' >"$work/odd.xml"
ends 0 '^a?b?c: 1 bodies' info "$work/odd.xml"
printf '<mujoco><worldbody><body name="d&#x9b;e"><joint/></body></worldbody></mujoco>' >"$work/odd.xml"
ends 1 "^body 0 'd?e': .* or lock it\$" check "$work/odd.xml"
[ -z "$("$program" check "$work/odd.xml" | tail -c 1)" ] || { echo "the last line of check has no end"; failed=1; }

ends 0 'usage: mbsrank convert' convert --help
ends 2 'there is no file' convert
ends 2 'where to is missing' convert "$models/arm.urdf"
ends 2 'third one' convert "$models/arm.urdf" a.xml b.xml
ends 2 'no option --fast' convert "$models/arm.urdf" "$work/arm.xml" --fast
ends 0 "arm.xml: body 'wrist_1': it has no mass" convert "$models/arm.urdf" "$work/arm.xml"
"$program" check --json "$models/arm.urdf" >"$work/before" && "$program" check --json "$work/arm.xml" >"$work/after"
cmp "$work/before" "$work/after" || { echo "the converted arm has another report"; failed=1; }
ends 2 'no option --json' convert "$models/arm.urdf" "$work/arm.xml" --json
ends 2 'no option --start' convert "$models/arm.urdf" "$work/arm.xml" --start a
ends 4 'strict mode' convert --strict "$models/arm.urdf" "$work/arm.xml"
ends 4 'cannot be written' convert "$models/arm.urdf" "$work/none/arm.xml"

ends 0 '"actuators": \["road"\], "keys": \["pushed"\], "findings"' info --json "$models/quarter_car.xml"
printf '<robot name="r"><link name="a"><inertial><mass value="1"/></inertial><visual><geometry><mesh filename="m.stl"/></geometry></visual><visual><geometry><mesh filename="m.stl"/></geometry></visual></link></robot>' \
    >"$work/far.urdf"
ends 0 "^mesh 'm.stl' is missing" info "$work/far.urdf"
ends 0 '"missing": \["m.stl"\]' info --json --strict "$work/far.urdf"
printf 'solid\nendsolid\n' >"$work/m.stl"
ends 0 '"missing": \[\]' info --json "$work/far.urdf"
rm "$work/m.stl"

# How far a run is, on a terminal alone; a pendulum swings for ever.
printf '<mujoco><worldbody><body><joint axis="0 1 0"/><geom size="0.1" pos="1 0 0"/></body></worldbody></mujoco>' \
    >"$work/pendulum.xml"
run="timeout --foreground -s INT 0.8 '$program' run '$work/pendulum.xml' --t-end 1e9 --step 100 -o /dev/null"
if [ "$with_run" = 1 ] && command -v script >/dev/null; then
    script -qec "$run" /dev/null >"$work/terminal" 2>&1 </dev/null
    grep -q 'run:   0 %, [0-9]* s left' "$work/terminal" || { echo "no progress on a terminal"; failed=1; }
    sh -c "$run" 2>"$work/terminal"
    grep -q 'stopped at' "$work/terminal" || { echo "the run was not stopped"; failed=1; }
    grep -q '%' "$work/terminal" && { echo "progress where no terminal is"; failed=1; }
fi

# The page is the bundle with the data in it.
printf 'before<!--data-->after' >"$work/bundle"
MBSRANK_VIEWER=$work/bundle
export MBSRANK_VIEWER
ends 0 'usage: mbsrank view' view --help
ends 2 'there is no file' view
ends 2 'no option --fast' view "$models/arm.urdf" --fast
ends 2 'no option --json' view "$models/arm.urdf" --json -o -
ends 2 '-o is missing' view -
here=$(pwd)
cd "$work" || exit 1
ends 0 'the page is arm.html' view "$models/arm.urdf"
ends 2 'arm.html is no page of mbsrank' view "$models/arm.urdf" # it has no bundle's head here
[ "$(head -c 6 arm.html)" = before ] || { echo "a file was written over"; failed=1; }
printf '<!DOCTYPE html>\n<!-- A model of mbsrank and a run of it -->' >arm.html
ends 0 'the page is arm.html' view "$models/arm.urdf"
cd "$here" || exit 1
ends 2 'no run, no --inputs' view --live "$models/arm.urdf" a.csv
printf 'live<!--data-->' >"$work/live.html"
export MBSRANK_LIVE="$work/live.html"
ends 0 '^live<script.*"name": ".*arm.urdf", "options": {"floating": true, "limits": false' view --live --floating --no-limits "$models/arm.urdf" -o -
ends 0 '"set": {"bodies.fore.mass": 2}},' view --live --set bodies.fore.mass=2 "$models/arm.urdf" -o -
ends 0 '"files": {".*arm.urdf": "[z-][A-Za-z0-9+/=]*"}}' view --live "$models/arm.urdf" -o -
export MBSRANK_LIVE="$work/none.html"
ends 4 'no page that runs models' view --live "$models/arm.urdf" -o -
unset MBSRANK_LIVE
ends 2 'second one' view "$models/arm.urdf" a.csv b.csv
ends 0 'before<script.*"title": "arm"' view "$models/arm.urdf" -o -
ends 0 '"report": {"rows": 1.*}$' view "$models/arm.urdf" -o -
ends 4 'page.html cannot be written' view "$models/arm.urdf" -o "$work/none/page.html"
printf '<mujoco><worldbody><body name="a"><joint name="x"/><joint name="y" pos="0 0 1"/><geom size="1"/></body></worldbody></mujoco>' \
    >"$work/between.xml"
ends 0 '"name": "a/x", "parent": -1, "massless": true, "mass": 0,' view "$work/between.xml" -o -
ends 0 '"name": "a", "parent": 0, "massless": false, "mass": 4188.7' view "$work/between.xml" -o -
printf 't,tyre,damper\n0,0,0\n' >"$work/part.csv"
ends 3 "part.csv has no column 'rubber'" view "$models/quarter_car.xml" "$work/part.csv" -o -
printf 't,tyre,damper,rubber\n0,0,0,0\n' >"$work/all.csv"
ends 0 '"reactions": null' view "$models/quarter_car.xml" "$work/all.csv" -o -
ends 0 'the run has no rates' view "$models/quarter_car.xml" "$work/all.csv" -o -
printf 't,tyre,damper,rubber\n' >"$work/empty.csv"
ends 3 'no lines of numbers' view "$models/quarter_car.xml" "$work/empty.csv" -o -
printf '<robot name="&lt;/script>"><link name="a"><visual><geometry><mesh filename="m.stl"/></geometry></visual></link></robot>' \
    >"$work/mesh.urdf"
ends 0 "mesh 'm.stl' cannot be read (No such file or directory)" view "$work/mesh.urdf" -o "$work/page.html"
mkdir "$work/within"
sed 's|m.stl|../m.stl|' "$work/mesh.urdf" >"$work/within/mesh.urdf"
printf 'solid\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 -1 0\nendsolid\n' >"$work/m.stl"
ends 0 "cannot be read (it is elsewhere than the model: --folder" view "$work/within/mesh.urdf" -o -
ends 0 '/m.stl": {"vertices": 3' view "$work/within/mesh.urdf" --folder "$work" -o -
rm "$work/m.stl"
mkdir "$work/meshes"
printf 'solid\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 -1 0\nendsolid\n' >"$work/meshes/m.stl"
sed 's|m.stl|package://arm/m.stl|' "$work/mesh.urdf" >"$work/package.urdf"
ends 0 '"package://arm/m.stl"' view "$work/package.urdf" -o -
ends 0 '/meshes/m.stl": {"vertices": 3, "triangles": 1, "low": \[0, -1, 0\], "high": \[2, 0, 0\], "surface": "' \
    view "$work/package.urdf" --package "arm=$work/meshes" -o -
printf 'solid\nendsolid\n' >"$work/m.stl"
ends 0 "mesh 'm.stl': .*no triangles: its body is drawn without" view "$work/mesh.urdf" -o -
printf '<?xml version="1.0"?><COLLADA/>' >"$work/m.stl"
ends 0 '"m.stl": {"collada": "' view "$work/mesh.urdf" -o -
ends 2 'not NAME=DIR' view "$work/package.urdf" --package=arm -o -
[ "$(grep -c '</script>' "$work/page.html")" = 1 ] || { echo "a name ends the script of the page"; failed=1; }
# Pictures, by gnuplot where it is.
printf 't,a,"b, c",d.x,d.y\n0,0,1,2,3\n1,1,2,3,5\n' >"$work/run.csv"
ends 0 'usage: mbsrank plot' plot --help
ends 2 'there is no file' plot
ends 2 '-o is missing' plot "$work/run.csv"
ends 2 'neither .png nor .svg' plot "$work/run.csv" -o "$work/a.pdf"
ends 2 'no option --fast' plot "$work/run.csv" --fast
ends 2 "no column 'e'" plot "$work/run.csv" -o "$work/a.svg" --columns e
ends 3 'none.csv cannot be read: No such file or directory' plot "$work/none.csv" -o "$work/a.svg"
ends 3 'no lines of numbers' plot "$work/empty.csv" -o "$work/a.svg"
if command -v gnuplot >/dev/null; then
    "$program" plot "$work/run.csv" -o "$work/a.svg" --columns 'a:d' --title "it's" || failed=1
    for text in '>a<' '>d.x<' '>d.y<' "it's"; do
        grep -q "$text" "$work/a.svg" || { echo "the picture has no $text"; failed=1; }
    done
    ! grep -q 'b, c' "$work/a.svg" || { echo "the picture has a column that was not chosen"; failed=1; }
    "$program" plot "$work/run.csv" -o "$work/a.png" || failed=1
    printf 't,kinetic,potential\n0,1,2\n1,2,1\n' >"$work/energy.csv"
    "$program" plot "$work/energy.csv" -o "$work/a.png" --columns energy || failed=1
    head -c 4 "$work/a.png" | grep -q PNG || { echo "a.png is no PNG"; failed=1; }
    ends 4 'has not drawn' plot "$work/run.csv" -o "$work/none/a.svg"
else
    echo "gnuplot is missing: pictures are not tested"
fi
mkdir "$work/bin"
ln -s "$(command -v sh)" "$work/bin/sh"
was=$PATH PATH=$work/bin
"$program" plot "$work/run.csv" -o "$work/a.svg" 2>"$work/err"
got=$?
PATH=$was
[ $got -eq 4 ] && grep -q 'gnuplot is missing' "$work/err" ||
    { echo "without gnuplot: ended with $got"; cat "$work/err"; failed=1; }

MBSRANK_VIEWER=$work/none
ends 4 'has no viewer' view "$models/arm.urdf" -o -
unset MBSRANK_VIEWER

# An arm of 1 kg falls on its limit at 0.5 rad, a stop of 1000 N m/rad: it comes to rest at 0.5 + 4.905 cos(0.5043) / 1000.
printf '<robot name="r"><link name="base"/><link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>' >"$work/limit.urdf"
printf '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>' >>"$work/limit.urdf"
printf '<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>' >>"$work/limit.urdf"
printf '<limit lower="-1" upper="0.5" effort="1" velocity="1"/></joint></robot>\n' >>"$work/limit.urdf"
ends 2 "'-3' is not a positive number" info "$work/limit.urdf" --stop-stiffness -3
ends 2 "slip needs a value" info "$work/limit.urdf" --slip
if [ "$with_run" = 1 ]; then
    ends 0 'limits of 1 joints are stops of .*--no-limits' run "$work/limit.urdf" --t-end 1 --step 1
    "$program" run "$work/limit.urdf" --t-end 1 --step 1 --no-limits 2>&1 | grep -q 'are stops' &&
        { echo "--no-limits leaves limits"; failed=1; }
    ends 0 '^5,0.504294' run "$work/limit.urdf" --t-end 5 --step 5 --stop-stiffness 1000 --stop-damping 30
    cat >"$work/sensed.xml" <<'END'
<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody><site name="fixed" pos="7 0 0"/>
<body name="b"><joint name="j" axis="0 0 1"/><geom size=".1" pos="2 0 0"/><site name="s" pos="0 3 0"/></body></worldbody>
<sensor><jointpos name="angle" joint="j"/><jointvel name="speed" joint="j"/><framepos name="tip" objtype="site" objname="s"/>
<framepos name="mass" objtype="body" objname="b"/><framepos name="post" objtype="site" objname="fixed"/>
<accelerometer name="shake" site="s"/></sensor><keyframe><key name="k" qvel="0.5"/></keyframe></mujoco>
END
    ends 0 '^t,angle,speed,tip.x,tip.y,tip.z,mass.x,mass.y,mass.z,post.x' run "$work/sensed.xml" --t-end 1 --step 1 --start k \
        --output angle,speed,tip,mass,post
    ends 0 '^0,0,0.5,0,3,0,2,0,0,7,0,0' run "$work/sensed.xml" --t-end 1 --step 1 --start k --output angle,speed,tip,mass,post
    ends 0 '^t,shake.x,shake.y,shake.z' run "$work/sensed.xml" --t-end 1 --step 1 --start k --output shake
    ends 0 '^1,-*[0-9.e-]*,-0.75[0-9]*,' run "$work/sensed.xml" --t-end 1 --step 1 --start k --output shake
    ends 2 "no joint 'shaken'" run "$work/sensed.xml" --t-end 1 --output shaken
    ends 2 't-end' run "$models/arm.urdf"
    ends 2 'makes more than 1e+08 lines' run "$models/arm.urdf" --t-end 1e9 --step 1e-9
    ends 2 'needs -o FILE' run "$models/arm.urdf" --t-end 1 --json
    ends 2 'not a positive number' run "$models/arm.urdf" --t-end=-1
    ends 2 "no joint 'nose'" run "$models/arm.urdf" --t-end 1 --output nose
    ends 0 '^t,elbow,hand.pos.x,hand.pos.y' run "$models/arm.urdf" --t-end 0.1 --output elbow,hand.pos
    "$program" run "$models/quarter_car.xml" --t-end 1 --start pushed --quiet -o "$work/car.csv" ||
        { echo "the quarter car does not run"; failed=1; }
    [ "$(wc -l <"$work/car.csv")" -eq 102 ] || { echo "not 101 states"; failed=1; }
    # in the end the tyre carries 336 kg, 10 mm higher than without: 0.019 - 336 * 9.81 / 180000 + 0.01 m
    printf 't,road\n0,0\n0.5,0.01\n' >"$work/road.csv"
    "$program" run "$models/quarter_car.xml" --t-end 8 --inputs "$work/road.csv" --quiet \
        --output tyre,damper,rubber --step 0.5 --rtol 1e-8 --atol 1e-10 >"$work/lifted.csv"
    awk -F, 'END { if (!($2 > 0.010687 && $2 < 0.010689)) { print "the tyre ends at", $2; exit 1 } }' \
        "$work/lifted.csv" || failed=1
    printf 't,road\n1,0\n1,0\n' >"$work/bad.csv"
    ends 3 'bad.csv:3: times must ascend' run "$models/quarter_car.xml" --t-end 1 --inputs "$work/bad.csv"
    printf 't,rocket\n' >"$work/bad.csv"
    ends 3 "no actuator 'rocket'" run "$models/quarter_car.xml" --t-end 1 --inputs "$work/bad.csv"
fi
if "$program" --help | grep -q '^  fmu'; then
    ends 2 'UNIT is missing' fmu "$models/arm.urdf"
    ends 2 'neither cs nor me nor both' fmu "$models/arm.urdf" -o "$work/arm.fmu" --kind all
    ends 4 'no model exchange: it has closures' fmu "$models/arm.urdf" -o "$work/arm.fmu" --kind me
    ends 0 'co-simulation alone' fmu "$models/arm.urdf" -o "$work/arm.fmu" --fmi 2
    ends 4 'cannot be written' fmu "$models/arm.urdf" -o "$work/none/arm.fmu"
    [ "$(head -c 2 "$work/arm.fmu")" = PK ] || { echo "an FMU that is no archive"; failed=1; }
fi
if [ "$with_run" = 1 ]; then
    printf '%s' '<mujoco><worldbody><geom type="plane" size="0 0 1"/><body pos="0 0 .5"><freejoint/>' \
        '<geom type="sphere" size=".1"/></body></worldbody></mujoco>' >"$work/ball.xml"
    if "$program" --help | grep -q '^  fmu'; then
        ends 0 '2 shapes touch' fmu "$work/ball.xml" -o "$work/ball.fmu"
        "$program" fmu --no-contacts "$work/ball.xml" -o "$work/ball.fmu" 2>&1 | grep -q . && { echo 'fmu --no-contacts speaks'; failed=1; }
    fi
    "$program" run --no-contacts "$work/ball.xml" --t-end 0.5 --output state -o "$work/ball.csv" 2>"$work/err" || failed=1
    grep -q 'touch' "$work/err" && { echo 'run --no-contacts speaks of what touches'; failed=1; }
    tail -n 1 "$work/ball.csv" | awk -F, '{ exit !($8 < -0.7) }' || { echo 'a ball does not fall without contacts'; failed=1; }
    "$program" run "$work/ball.xml" --t-end 2 --output state -o "$work/ball.csv" 2>"$work/err" || failed=1
    if grep -q '2 shapes touch' "$work/err"; then
        tail -n 1 "$work/ball.csv" | awk -F, '{ exit !($8 > 0.09 && $8 < 0.1) }' ||
            { echo 'a ball does not lie on the floor:'; tail -n 1 "$work/ball.csv"; failed=1; }
        if "$program" --help | grep -q '^  modes'; then # where it lies is where it rests
            last=$(tail -n 1 "$work/ball.csv" | cut -d, -f8)
            "$program" static "$work/ball.xml" 2>"$work/err" | awk -v z="$last" 'NR == 2 { exit !($NF - z < 1e-6 && z - $NF < 1e-6) }' ||
                { echo "a ball rests elsewhere than at $last:"; "$program" static "$work/ball.xml"; failed=1; }
            ends 0 'energy in contacts 1 1.00' modes "$work/ball.xml"
            ends 4 'no equilibrium was found' static --no-contacts "$work/ball.xml"
            ends 0 '^  FR foot  *0.00' static "$models/quadruped.xml"
        fi
        "$program" run "$work/ball.xml" --t-end 2 --output contacts,body:world.contact -o "$work/ball.csv" 2>"$work/err"
        grep -q "there is no body 'body'" "$work/err" || { echo 'contact of a body that is none'; failed=1; }
        sed 's/<body /<body name="b" /' "$work/ball.xml" >"$work/named.xml"
        "$program" run "$work/named.xml" --t-end 2 --output contacts,b:world.contact,b.pos -o "$work/ball.csv" 2>"$work/err" || failed=1
        [ "$(head -n 1 "$work/ball.csv" | cut -d, -f1-8)" = \
            t,b.contact.x,b.contact.y,b.contact.z,b.contact.px,b.contact.py,b.contact.pz,b:world.contact.x ] || failed=1
        # in the air where the body is; at rest its weight, 9.81 of 4/3 pi 0.1^3 1000 kg
        sed -n 2p "$work/ball.csv" | awk -F, '{ exit !($4 == 0 && $7 == 0.5 && $10 == 0) }' || { echo 'contact in the air'; failed=1; }
        tail -n 1 "$work/ball.csv" | awk -F, '{ w = 41.0917; exit !($4 > w - 1e-3 && $4 < w + 1e-3 && $10 == $4 && $7 < 0) }' ||
            { echo 'the floor does not carry a ball:'; tail -n 1 "$work/ball.csv"; failed=1; }
        # fingers drawn in one place, whose forces cancel each other, are drawn into each other
        finger='<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><box size=".03 .01 .01"/></geometry></collision></link>'
        slide='<parent link="palm"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
        printf '%s' '<robot name="r"><link name="palm"/><link name="a">' "$finger" '<link name="b">' "$finger" '<joint name="a" type="prismatic">' \
            "$slide" '<child link="a"/></joint><joint name="b" type="prismatic">' "$slide" '<child link="b"/></joint></robot>' >"$work/fingers.urdf"
        ends 0 'shapes of 1 pairs of bodies are drawn into each other' run "$work/fingers.urdf" --t-end 0.1
        sed 's/"1"/"1e-4"/g' "$work/fingers.urdf" >"$work/light.urdf" # however light
        ends 0 'shapes of 1 pairs of bodies are drawn into each other' run "$work/light.urdf" --t-end 0.1
        ends 2 'nothing touches' run "$work/ball.xml" --t-end 1 --no-contacts --output contacts
        # massless fingers lift a box, which creeps by m g / (2 mu F) of the slip, 1e-3 m/s
        "$program" run "$models/gripper.xml" --t-end 3 --step 0.5 --inputs "$models/grip.csv" --output box,box.rate \
            -o "$work/grip.csv" 2>"$work/err" || { cat "$work/err"; failed=1; }
        tail -n 1 "$work/grip.csv" | awk -F, '{ exit !($8 > 0.196 && $8 < 0.198 && $14 < -1.22e-4 && $14 > -1.25e-4) }' ||
            { echo 'the gripper lost its box:'; tail -n 1 "$work/grip.csv"; failed=1; }
        for options in '' '--no-contacts'; do # the rods of the wishbones begin within their tubes
            # shellcheck disable=SC2086
            "$program" run $options "$models/suspension.xml" --t-end $seconds --inputs "$models/steer.csv" \
                --output state -o "$work/run$options.csv" 2>"$work/err$options" || { cat "$work/err$options"; failed=1; }
        done
        grep -q '^5 pairs of shapes of the ground .* never touch' "$work/err" || { cat "$work/err"; failed=1; }
        paste -d, "$work/run.csv" "$work/run--no-contacts.csv" | awk -F, 'NR > 1 { for (k = 1; k <= NF / 2; ++k) {
            d = $k - $(k + NF / 2); if (d > 1e-4 || d < -1e-4) { print "contacts change the suspension:", $0; exit 1 } } }' || failed=1
    else
        grep -q 'without the component contact' "$work/err" || { cat "$work/err"; failed=1; }
    fi
fi
exit $failed
