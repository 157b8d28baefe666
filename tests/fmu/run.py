"""Whole runs of units by the importer in Python: run.py FOLDER, where write_units has written them.
SPDX-License-Identifier: BSD-3-Clause"""
import ctypes as c
import math
import pathlib
import re
import sys

from importer import DISCARD, ERROR, OK, Instance, Refused, Unit, doubles

checks = 0


def need(good, text):
    global checks
    checks += 1
    if not good:
        raise AssertionError(text)


def distance(a, b):
    return max((abs(x - y) / (1.0 + abs(x)) for x, y in zip(a, b)), default=0.0)


def refused(call, text, status=ERROR):
    try:
        call()
    except Refused as reason:
        need(reason.status == status, f"{text}: status {reason.status}")
        return
    need(False, f"{text}: was not refused")


# ---- runs ----

def co_simulate(unit, t_end, h, **how):
    one = Instance(unit, False, **how)
    need(one.handle, f"no instance: {one.log}")
    one.initialize()
    t = 0.0
    for k in range(round(t_end / h)):
        t, _ = one.step(k * h, h)
    need(abs(t - t_end) < 1e-9, "the end is not reached")
    return one


def exchange(unit, t_end, h):
    """Runge and Kutta's steps of order 4."""
    one = Instance(unit, True)
    need(one.handle, f"no instance: {one.log}")
    one.initialize()
    need(one.update_states() is None, "an event that is not there")
    one.call("EnterContinuousTimeMode")
    n = len(unit.description.states)
    x = one.numbers("GetContinuousStates", n)
    need(one.numbers("GetNominalsOfContinuousStates", n) == [1.0] * n, "nominals")
    need(x == one.get(unit.description.states), "states that are not the variables")
    for k in range(round(t_end / h)):
        t = k * h
        a = one.derivatives(t, x)
        b = one.derivatives(t + h / 2, [p + h / 2 * r for p, r in zip(x, a)])
        d = one.derivatives(t + h / 2, [p + h / 2 * r for p, r in zip(x, b)])
        e = one.derivatives(t + h, [p + h * r for p, r in zip(x, d)])
        x = [p + h / 6 * (ra + 2 * rb + 2 * rd + re)
             for p, ra, rb, rd, re in zip(x, a, b, d, e)]
    one.derivatives(t_end, x)
    flags = c.c_int(), c.c_int()
    one.call("CompletedIntegratorStep", 1 if one.two else c.c_bool(True), c.byref(flags[0]),
             c.byref(flags[1]))
    one.numbers("GetEventIndicators", unit.description.indicators)
    return one


def both_ways_agree(unit, t_end, h, error):
    d = unit.description
    a, b = co_simulate(unit, t_end, 0.01), exchange(unit, t_end, h)
    need(distance(a.get(d.outputs), b.get(d.outputs)) < error,
         f"outputs differ by {distance(a.get(d.outputs), b.get(d.outputs))}")
    slopes = b.get(d.derivatives)
    again = b.derivatives(t_end, b.numbers("GetContinuousStates", len(slopes)))
    need(distance(slopes, again) < 1e-9, "derivatives as variables")
    a.free()
    b.free()


def starts_are_found_anew(unit):
    """Values that are set after others have been asked for, in initialization mode."""
    one = Instance(unit, True)
    n, q = len(unit.description.states), unit.description.by_name["joints.upper.q"]

    def ask(instance):
        first = instance.numbers("GetContinuousStates", n)
        instance.set([q], [0.4])
        second = instance.numbers("GetContinuousStates", n)
        need(abs(second[0] - first[0] - 0.4) < 1e-12, f"states {first}, then {second}")
        need(abs(instance.get([q])[0] - 0.4) < 1e-12, "a coordinate that was set")

    one.initialize(before=ask)
    need(abs(one.numbers("GetContinuousStates", n)[0] - 0.4) < 1e-12, "the start")
    one.free()


# ---- states ----

def states_are_kept(unit):
    d = unit.description
    one = co_simulate(unit, 0.1, 0.01)
    state = one.save()
    one.step(0.1, 0.05)
    first = one.get(d.outputs)
    one.restore(state)
    one.step(0.1, 0.05)
    need(one.get(d.outputs) == first, "a step that is repeated differs")
    data = one.to_bytes(state)
    two = Instance(unit, False)
    other = two.from_bytes(data)
    two.restore(other)
    two.step(0.1, 0.05)
    need(two.get(d.outputs) == first, "a state of another instance goes on differently")
    refused(lambda: two.from_bytes(data[:-1]), "a state cut short")
    need(two.status("Reset") == OK, "no reset after an error")
    refused(lambda: two.from_bytes(b"x" + data[1:]), "a state of another unit")
    one.forget(state)
    two.forget(other)
    one.free()
    two.free()


# ---- parameters, inputs, derivatives ----

def parameters_count_before_the_start(unit):
    d = unit.description
    mass = d.by_name["bodies.upper.mass"]
    one, heavy = Instance(unit, False), Instance(unit, False)
    heavy.set([mass], [9.0])
    for instance in (one, heavy):
        instance.initialize()
        instance.step(0.0, 0.3)
    need(heavy.get([mass]) == [9.0], "a parameter that is not kept")
    q = d.by_name["joints.upper.q"]
    need(distance(one.get([q]), heavy.get([q])) > 1e-3, "the mass has no effect")
    refused(lambda: one.set([mass], [1.0]), "a parameter after the start")
    need(one.status("Reset") == OK, "reset")
    need(one.get([mass]) == [float(mass.start)], "a parameter after a reset")
    one.set([d.by_name["joints.upper.q"]], [0.25])
    one.initialize()
    need(abs(one.get([q])[0] - 0.25) < 1e-12, "a start that is set")
    one.free()
    heavy.free()
    wrong = Instance(unit, False)
    wrong.set([mass], [-1.0])
    refused(wrong.initialize, "a negative mass")
    need(any("mass" in text for _, _, text in wrong.log), f"its message {wrong.log}")
    refused(wrong.save, "a state of no model")
    refused(lambda: wrong.get([q]), "a value of no model")
    need(wrong.status("Reset") == OK, "a reset after a wrong parameter")
    wrong.initialize()
    wrong.free()


def inputs_act(unit):
    d = unit.description
    motor, a = d.by_name["inputs.motor"], d.by_name["joints.'lower arm'.a"]
    one = co_simulate(unit, 0.1, 0.01)
    before = one.get([a])[0]
    slope = one.sensitivity([a], [motor], [1.0])[0]
    one.set([motor], [2.0])
    need(abs(one.get([a])[0] - before - 2.0 * slope) < 1e-5 * abs(slope), "force and derivative")
    one.step(0.1, 0.1)
    refused(lambda: one.set([a], [0.0]), "an output that is set")
    one.free()


def far(a, b):
    """The largest difference over the largest number."""
    return max(abs(x - y) for x, y in zip(a, b)) / (1e-9 + max(abs(x) for x in a))


def differences(ask, at, k, h):
    """Column k of the derivative of ask(at), of order 6."""
    column = None
    for steps, weight in ((1, 45.0 / 60.0), (2, -9.0 / 60.0), (3, 1.0 / 60.0)):
        for sign in (1.0, -1.0):
            value = ask([x + sign * steps * h * (k == l) for l, x in enumerate(at)])
            part = [sign * weight / h * y for y in value]
            column = part if column is None else [x + y for x, y in zip(column, part)]
    return column


def derivatives_are_right(unit, inputs, outputs, error, h=2.0 ** -7):
    """Of model exchange, in states and inputs: products along and against are transposes of each
    other, and agree with differences of values."""
    d = unit.description
    one = Instance(unit, True)
    one.initialize()
    one.update_states()
    one.call("EnterContinuousTimeMode")
    knowns = d.states + [d.by_name[name] for name in inputs]
    unknowns = d.derivatives + [v for v in d.outputs if v.name.startswith(outputs)]
    n = len(d.states)
    start = one.numbers("GetContinuousStates", n)
    at = [x + 0.2 * math.sin(1.0 + 3.0 * k) for k, x in enumerate(start)] + [0.3] * len(inputs)

    def ask(values):
        one.call("SetContinuousStates", doubles(values[:n]), c.c_size_t(n))
        one.set(knowns[n:], values[n:])
        return one.get(unknowns)

    ask(at)
    columns = [one.sensitivity(unknowns, knowns, [float(k == l) for l in range(len(knowns))])
               for k in range(len(knowns))]
    for k, column in enumerate(columns):
        right = differences(ask, at, k, h * (1.0 + abs(at[k])))
        need(far(right, column) < error,
             f"derivatives in {knowns[k].name}: {far(right, column)}")
    ask(at)
    seed = [math.sin(1.0 + k) for k in range(len(unknowns))]
    if not one.two:
        adjoint = one.sensitivity(unknowns, knowns, seed, adjoint=True)
        right = [sum(s * x for s, x in zip(seed, column)) for column in columns]
        need(far(right, adjoint) < 1e-11, f"adjoint derivatives: {far(right, adjoint)}")
    one.free()


def parameters_have_derivatives(unit, exchange, names, outputs, error):
    """At the start, whose q and u (of model exchange: q and p) stay, against instances with other
    parameters."""
    d = unit.description
    parameters = [d.by_name[name] for name in names]
    unknowns = d.derivatives * exchange + [v for v in d.outputs if v.name.startswith(outputs)]
    at = [float(v.start) for v in parameters]
    kept = []

    def begin(values):
        one = Instance(unit, exchange)
        one.set(parameters, values)
        one.initialize()
        if exchange:
            one.update_states()
            one.call("EnterContinuousTimeMode")
            kept.append(one.numbers("GetContinuousStates", len(d.states)))
            one.call("SetContinuousStates", doubles(kept[0]), c.c_size_t(len(d.states)))
        return one

    def ask(values):
        one = begin(values)
        values = one.get(unknowns)
        one.free()
        return values

    one = begin(at)
    before = one.get(unknowns)
    columns = []
    for k in range(len(at)):
        columns.append(one.sensitivity(unknowns, parameters, [float(k == l) for l in range(len(at))]))
        right = differences(ask, at, k, 2.0 ** -9 * (abs(at[k]) or 1e-2))
        need(far(right, columns[k]) < error,
             f"derivatives in {names[k]}: {far(right, columns[k])}")
    mixed = d.inputs[:1] + parameters
    seed = [math.sin(2.0 + k) for k in range(len(mixed))]
    right = one.sensitivity(unknowns, d.inputs[:1], seed[:len(mixed) - len(at)])
    for s, column in zip(seed[len(mixed) - len(at):], columns):
        right = [x + s * y for x, y in zip(right, column)]
    need(far(right, one.sensitivity(unknowns, mixed, seed)) < 1e-7, "inputs and parameters")
    if not one.two:
        seed = [math.sin(1.0 + k) for k in range(len(unknowns))]
        adjoint = one.sensitivity(unknowns, parameters, seed, adjoint=True)
        right = [sum(s * x for s, x in zip(seed, column)) for column in columns]
        need(far(right, adjoint) < 1e-10, f"adjoint derivatives: {far(right, adjoint)}")
    need(one.get(unknowns) == before and one.get(parameters) == at, "values after derivatives")
    one.free()


def borders_are_kept(unit):
    """An armature of 0 may only grow; with one the flap is no longer without mass."""
    d = unit.description
    a = d.by_name["joints.upper.a"]

    def begin(values):
        one = Instance(unit, True)
        one.set([d.by_name["bodies.upper.armature"]], values)
        one.initialize()
        return one

    def ask(values):
        one = begin(values)
        value = one.get([a])
        one.free()
        return value

    one = begin([0.0])
    slope = one.sensitivity([a], [d.by_name["bodies.upper.armature"]], [1.0])
    right = [(4.0 * y - z - 3.0 * x) / 2e-4
             for x, y, z in zip(ask([0.0]), ask([1e-4]), ask([2e-4]))]
    need(far(right, slope) < 1e-3, f"a derivative at a border: {slope}, {right}")
    refused(lambda: one.sensitivity([d.by_name["joints.flap.u"]],
                                    [d.by_name["bodies.flap.armature"]], [1.0]), "a rank that changes")
    need("no derivative" in one.log[-1][2] and "flap" in one.log[-1][2], f"its message {one.log[-1:]}")
    one.free()


# ---- events, updates, messages ----

def stops_are_events(unit):
    d = unit.description
    q = d.by_name["joints.upper.q"]
    one = Instance(unit, False, events=True, early=True)
    one.set([q], [0.5])
    one.initialize()
    one.update_states()
    one.call("EnterStepMode")
    t, found = 0.0, 0
    while t < 0.5 - 1e-9:
        t, event = one.step(t, min(0.05, 0.5 - t))
        if not event:
            continue
        found += 1
        need(abs(one.get([q])[0] - 0.6) < 1e-5, f"the stop is hit at {one.get([q])}")
        one.call("EnterEventMode")
        one.update_states()
        one.call("EnterStepMode")
    need(found >= 1, "no stop is hit")
    plain = Instance(unit, False)
    plain.set([q], [0.5])
    plain.initialize()
    plain.step(0.0, 0.5)
    need(distance(plain.get([q]), one.get([q])) < 1e-4, "events change the motion")
    plain.free()
    one.free()


def updates_come_between(unit):
    times = []
    d = unit.description
    holder = []

    def update(_, time, can_set, can_get, finished, can_return, early, wanted):
        times.append((time, holder[0].get(d.outputs[:2])))
        if time > 0.2:
            early[0], wanted[0] = True, time

    one = Instance(unit, False, update=update, early=True)
    holder.append(one)
    one.initialize()
    t, _ = one.step(0.0, 0.4)
    need(0.2 < t < 0.4, f"an early return at {t}")
    need(len(times) > 3 and [a for a, _ in times] == sorted(a for a, _ in times), "their times")
    times.clear()
    one.step(t, 0.4 - t)
    one.free()


def no_instance_is_refused(unit, version):
    """Each function of the header that returns a status."""
    source = pathlib.Path(__file__).resolve().parents[2] / "src" / "fmu" / f"fmi{version}_functions.h"
    names = re.findall(rf"\(fmi{version}Status\)\s*(fmi{version}\w+)\(", source.read_text())
    need(len(names) == {2: 40, 3: 70}[version], f"functions of FMI {version}: {len(names)}")
    for name in names:
        nothing = [c.c_void_p(None)] * 12  # more than any of them takes
        need(getattr(unit.library, name)(*nothing) == ERROR, f"{name} of no instance")


def messages_have_categories(unit):
    one = Instance(unit, False)
    one.log.clear()
    count = c.c_size_t(1)
    off = 0 if one.two else c.c_bool(False)
    one.call("SetDebugLogging", off, count, (c.c_char_p * 1)(b"logEvents"))
    one.initialize()
    need(not one.log, f"messages that were not wanted {one.log}")
    need(one.status("SetDebugLogging", off, count, (c.c_char_p * 1)(b"nonsense")) == ERROR, "log")
    need(one.log and one.log[0][1] == "logStatusError", "an error without a message")
    one.free()


def wrong_tokens_are_refused(unit):
    one = Instance(unit, False, token="0" * 32)
    need(not one.handle and "token" in one.log[0][2], f"a wrong token: {one.log}")
    two = Instance(unit, False, resources=unit.resources + "nowhere")
    need(not two.handle and "read" in two.log[0][2], f"a wrong folder: {two.log}")


# ---- two halves of a vehicle ----

def halves_approach_the_whole(folder, version):
    units = [Unit(f"{folder}/{name}{version}.fmu") for name in ("vehicle", "body", "wheel")]
    whole = co_simulate(units[0], 0.5, 0.01)
    right = whole.get([units[0].description.by_name["joints.body.q"]])[0]
    errors = []
    for h in (4e-3, 2e-3, 1e-3):
        body, wheel = Instance(units[1], False), Instance(units[2], False)
        b, w = units[1].description.by_name, units[2].description.by_name
        motion = [w[f"motions.carrier.{part}"] for part in "sva"]
        state = [b[f"joints.body.{part}"] for part in "qua"]
        body.initialize()
        wheel.initialize()
        for k in range(round(0.5 / h)):
            wheel.set(motion, body.get(state))
            body.set([b["inputs.strut"]], [wheel.get([w["forces.strut.f[6]"]])[0]])
            body.step(k * h, h)
            wheel.step(k * h, h)
        errors.append(abs(body.get(state)[0] - right))
        body.free()
        wheel.free()
    need(errors[0] > 1.6 * errors[1] > 2.5 * errors[2] and errors[2] < 1e-3,
         f"errors of the halves {errors}")
    print(f"FMI {version}: halves with steps of 4, 2, 1 ms: errors",
          ", ".join(f"{e:.2e}" for e in errors))
    whole.free()
    for unit in units:
        unit.close()


def main(folder):
    for version in (2, 3):
        for name in ("arm", "linkage", "beam", "vehicle", "wheel", "balls", "heap"):
            unit = Unit(f"{folder}/{name}{version}.fmu")
            need(not unit.description.errors, f"{name}: {unit.description.errors}")
            states_are_kept(unit)
            unit.close()
        arm = Unit(f"{folder}/arm{version}.fmu")
        both_ways_agree(arm, 0.15, 1e-3, 1e-5)
        starts_are_found_anew(arm)
        parameters_count_before_the_start(arm)
        inputs_act(arm)
        derivatives_are_right(arm, ["inputs.motor"], ("joints.upper.u", "joints.flap.u"), 1e-10)
        flyer = Unit(f"{folder}/flyer{version}.fmu")
        derivatives_are_right(flyer, ["inputs.push[2]", "inputs.push[4]"], ("joints.",), 1e-9)
        flyer.close()
        wheel = Unit(f"{folder}/wheel{version}.fmu")
        derivatives_are_right(wheel, ["motions.carrier.v"], ("joints.wheel.u",), 1e-9)
        wheel.close()
        balls = Unit(f"{folder}/balls{version}.fmu")
        both_ways_agree(balls, 0.3, 5e-4, 1e-5)
        derivatives_are_right(balls, ["inputs.push[2]", "inputs.push[4]"], ("joints.",), 1e-9, 2.0 ** -9)
        derivatives_are_right(balls, [], ("contacts.",), 1e-7, 2.0 ** -9)
        for exchange in (True, False):
            parameters_have_derivatives(balls, exchange, ["bodies.ball.mass", "bodies.second.mass", "forces.weight.gz"],
                                        ("joints.", "contacts.", "energy."), 1e-8)
        balls.close()
        heap = Unit(f"{folder}/heap{version}.fmu")
        both_ways_agree(heap, 0.3, 2e-4, 1e-3)
        heap.close()
        names = ["bodies.upper.mass", "bodies.'lower arm'.com[1]", "bodies.'lower arm'.joint_offset[1]",
                 "forces.spring.stiffness", "forces.hold.damping", "forces.weight.gz"]
        parameters_have_derivatives(arm, True, names, ("joints.", "energy."), 1e-8)
        borders_are_kept(arm)
        messages_have_categories(arm)
        no_instance_is_refused(arm, version)
        wrong_tokens_are_refused(arm)
        if version == 3:
            stops_are_events(arm)
            updates_come_between(arm)
            parameters_have_derivatives(arm, False, names, ("joints.lower", "joints.upper.a"), 1e-9)
            linkage = Unit(f"{folder}/linkage3.fmu")
            parameters_have_derivatives(linkage, False, ["bodies.coupler.mass", "forces.spring.rest"],
                                        ("joints.rocker.a", "closures."), 1e-9)
            parameters_have_derivatives(linkage, False, ["forces.spring.stiffness"],
                                        ("joints.rocker.a", "forces.", "reactions."), 1e-7)
            linkage.close()
        arm.close()
        beam = Unit(f"{folder}/beam{version}.fmu")
        both_ways_agree(beam, 0.05, 2e-4, 1e-3)  # accelerations of stiff modes
        derivatives_are_right(beam, ["inputs.push[5]"], ("joints.beam.u",), 1e-8,
                              2.0 ** -8)
        beam.close()
        halves_approach_the_whole(folder, version)
    print(f"{checks} checks")


main(sys.argv[1])
