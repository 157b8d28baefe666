"""Shapes of files touch in a unit as in a run of the program: beside_run.py PROGRAM SOURCE_DIR.
SPDX-License-Identifier: BSD-3-Clause"""
import csv
import pathlib
import subprocess
import sys
import tempfile

from importer import Instance, Refused, Unit

program, source = sys.argv[1:3]
work = tempfile.TemporaryDirectory()
folder = pathlib.Path(work.name)

BOX = """<mujoco><worldbody><geom type="plane" size="5 5 1" friction=".4 .005 .0001"/>
<body name="box" pos="0 0 .3" euler="10 20 5"><freejoint name="free"/>
<geom type="box" size=".1 .15 .05" mass="2" friction=".4 .005 .0001"/></body></worldbody></mujoco>"""
GHOST = BOX.replace('mass="2"', 'mass="0"').replace("</worldbody>", '<body name="far"><freejoint/><geom size=".1"/></body></worldbody>')


def mbsrank(*arguments, code=0):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == code, f"{arguments}: {done.returncode}: {done.stderr}"
    return done.stderr


def last_line(model, t_end, outputs, columns, *options):
    """Numbers of these columns, the first of which is that behind the time."""
    to = folder / "run.csv"
    mbsrank("run", model, "--t-end", t_end, "--step", 0.01, "--output", outputs, "-o", to, *options)
    with open(to) as lines:
        line = [float(x) for x in list(csv.reader(lines))[-1][1:]]
    return [line[k] for k in columns]


def last_of_unit(unit, t_end, names, parameters=()):
    one, by_name = Instance(unit, False), unit.description.by_name
    for name, value in parameters:
        one.set([by_name[name]], [value])
    one.initialize()
    for k in range(round(t_end / 0.01)):
        one.step(k * 0.01, 0.01)
    values = one.get([by_name[name] for name in names])
    one.free()
    return values


def same(model, t_end, outputs, columns, names, error, *options, unit_options=(), parameters=()):
    """Numbers of the last line of a run, and the unit's values of that time, which are returned."""
    path = folder / "unit.fmu"
    said = mbsrank("fmu", model, "-o", path, *options, *unit_options)
    assert ("shapes touch" in said) == ("--no-contacts" not in options), said
    options += tuple(text for name, value in parameters for text in ("--set", f"{name}={value}"))
    unit = Unit(path)
    run, own = last_line(model, t_end, outputs, columns, *options), last_of_unit(unit, t_end, names, parameters)
    unit.close()
    assert len(run) == len(own) > 0
    for name, a, b in zip(names, run, own):
        assert abs(a - b) <= error * (1.0 + abs(a)), f"{model}, {name}: {a} in the run, {b} in the unit"
    return own


box, ghost, quadruped = folder / "box.xml", folder / "ghost.xml", pathlib.Path(source) / "examples/models/quadruped.xml"
box.write_text(BOX)
ghost.write_text(GHOST)
force, tight = [f"contacts.box.f[{k}]" for k in (4, 5, 6)], ("--rtol", "1e-8", "--atol", "1e-8")
height = "joints.free.q[7]"
for t_end in (0.3, 2.0):  # as it hits, and at rest
    weight = same(box, t_end, "box.contact", (0, 1, 2), force, 1e-7, *tight)
    same(box, t_end, "box.contact", (0, 1, 2), force, 1e-7, *tight, unit_options=("--fmi", "2"))
assert abs(weight[2] - 2.0 * 9.81) < 1e-6, weight
heavy = same(box, 2.0, "box.contact", (0, 1, 2), force, 1e-7, *tight, parameters=[("bodies.box.mass", 3.0)])
assert abs(heavy[2] - 3.0 * 9.81) < 1e-5, heavy
same(box, 2.0, "box.contact", (2,), force[2:], 1e-5, *tight, unit_options=("--fixed-step", "1e-3"))
assert same(box, 2.0, "state", (6,), [height], 1e-9, *tight, "--no-contacts")[0] < -19.0
feet = ("FL", "FR", "RL", "RR")
stand = same(quadruped, 1.0, ",".join(f"{foot} foot.contact" for foot in feet), (2, 8, 14, 20),
             [f"contacts.'{foot} foot'.f[6]" for foot in feet], 1e-6, "--start", "standing")
assert all(20.0 < f < 40.0 for f in stand), stand
assert "ghost.fmu" not in mbsrank("fmu", ghost, "-o", folder / "ghost.fmu")
assert "undetermined: body 0 'box'" in mbsrank("fmu", ghost, "-o", folder / "ghost.fmu", "--kind", "me", code=4)
unit = Unit(folder / "ghost.fmu")
one = Instance(unit, False)
try:
    one.initialize()
    raise AssertionError("a body that nothing determines has begun")
except Refused as reason:
    assert "'box' moves no mass" in str(reason), reason
unit.close()
work.cleanup()
