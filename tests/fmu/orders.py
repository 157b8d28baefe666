"""Every function of the standard in every state of its calling sequence: those that it allows there succeed, all others return
an error with a message, and the instance can be reset and run. orders.py FOLDER. SPDX-License-Identifier: BSD-3-Clause

States: I instantiated, N initialization, E event, C continuous time, S step, T terminated. What an FMU may leave out
(variables of other types with none asked for succeed; derivatives of inputs, clocks, scheduled execution) has no states."""
import ctypes as c
import sys

from importer import ERROR, OK, Instance, Unit

D, Z, P = c.c_double, c.c_size_t, c.c_void_p
ALL, ASKED, SETS = "INECST", "NECST", "INECS"


def room(kind=c.c_double, count=64):
    return (kind * count)()


def bools(n, two):
    return [c.byref(c.c_int() if two else c.c_bool()) for _ in range(n)]


# name: states of model exchange, states of co-simulation, arguments of an instance
def functions2(n, ni, vr):
    none = lambda i: (None, Z(0), None)
    return {
        "SetDebugLogging": (ALL, ALL, lambda i: (1, Z(0), None)),
        "SetupExperiment": ("I", "I", lambda i: (0, D(0), D(0), 0, D(1))),
        "EnterInitializationMode": ("I", "I", lambda i: ()),
        "ExitInitializationMode": ("N", "N", lambda i: ()),
        "Terminate": ("EC", "S", lambda i: ()),
        "Reset": (ALL, ALL, lambda i: ()),
        "GetReal": (ASKED, ASKED, lambda i: ((c.c_uint * 1)(0), Z(1), room())),
        "SetReal": (SETS, SETS, none),
        **{f"Get{t}": (ALL, ALL, none) for t in ("Integer", "Boolean", "String")},
        **{f"Set{t}": (SETS, SETS, none) for t in ("Integer", "Boolean", "String")},
        "GetDirectionalDerivative":
            ("NEC", "NS", lambda i: (None, Z(0), None, Z(0), room(), room())),
        "EnterEventMode": ("C", "", lambda i: ()),
        "NewDiscreteStates": ("E", "", lambda i: (room(),)),
        "EnterContinuousTimeMode": ("E", "", lambda i: ()),
        "CompletedIntegratorStep": ("C", "", lambda i: (1, *bools(2, True))),
        "SetTime": ("EC", "", lambda i: (D(0),)),
        "SetContinuousStates": ("C", "", lambda i: (room(), Z(n))),
        "GetDerivatives": ("NECT", "", lambda i: (room(), Z(n))),
        "GetEventIndicators": ("NECT", "", lambda i: (room(), Z(ni))),
        "GetContinuousStates": ("NECT", "", lambda i: (room(), Z(n))),
        "GetNominalsOfContinuousStates": ("INECT", "", lambda i: (room(), Z(n))),
        "SetRealInputDerivatives": ("", "", lambda i: (None, Z(0), None, None)),
        "GetRealOutputDerivatives": ("", "", lambda i: (None, Z(0), None, None)),
        "DoStep": ("", "S", lambda i: (D(0), D(1e-3), 1)),
        "CancelStep": ("", "", lambda i: ()),
        "GetStatus": ("", "ST", lambda i: (0, room())),
        "GetRealStatus": ("", "ST", lambda i: (2, room())),
        "GetBooleanStatus": ("", "ST", lambda i: (3, room())),
    }


def functions3(n, ni, vr):
    none = lambda i: (None, Z(0), None, Z(0))
    clock = lambda i: (None, Z(0), None, None, None)
    types = ("Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
             "Boolean", "String")
    return {
        "SetDebugLogging": (ALL, ALL, lambda i: (c.c_bool(True), Z(0), None)),
        "EnterInitializationMode":
            ("I", "I", lambda i: (c.c_bool(False), D(0), D(0), c.c_bool(False), D(0))),
        "ExitInitializationMode": ("N", "N", lambda i: ()),
        "EnterEventMode": ("C", "", lambda i: ()),
        "Terminate": ("EC", "S", lambda i: ()),
        "Reset": (ALL, ALL, lambda i: ()),
        "GetFloat64": (ALL, ALL, lambda i: ((c.c_uint * 1)(0), Z(1), room(), Z(1))),
        "SetFloat64": (SETS, SETS, none),
        **{f"Get{t}": (ALL, ALL, none) for t in types},
        **{f"Set{t}": (SETS, SETS, none) for t in types},
        "GetBinary": (ALL, ALL, lambda i: (None, Z(0), None, None, Z(0))),
        "SetBinary": (SETS, SETS, lambda i: (None, Z(0), None, None, Z(0))),
        **{f"{g}Clock": (SETS, SETS, clock) for g in ("Get", "Set")},
        **{f"{g}{what}": (SETS, SETS, clock) for g in ("Get", "Set") for what in
           ("IntervalDecimal", "IntervalFraction", "ShiftDecimal", "ShiftFraction")},
        "GetNumberOfVariableDependencies": ("", "", lambda i: (c.c_uint(vr), room())),
        "GetVariableDependencies":
            ("", "", lambda i: (c.c_uint(vr), room(), room(), room(), room(), Z(1))),
        "GetDirectionalDerivative":
            ("NEC", "NS", lambda i: (None, Z(0), None, Z(0), room(), Z(0), room(), Z(0))),
        "GetAdjointDerivative":
            ("NEC", "NS", lambda i: (None, Z(0), None, Z(0), room(), Z(0), room(), Z(0))),
        "EnterConfigurationMode": ("", "", lambda i: ()),
        "ExitConfigurationMode": ("", "", lambda i: ()),
        "EvaluateDiscreteStates": ("NE", "N", lambda i: ()),
        "UpdateDiscreteStates": ("E", "", lambda i: (*bools(5, False), room())),
        "EnterContinuousTimeMode": ("E", "", lambda i: ()),
        "CompletedIntegratorStep": ("C", "", lambda i: (c.c_bool(True), *bools(2, False))),
        "SetTime": ("EC", "", lambda i: (D(0),)),
        "SetContinuousStates": ("C", "", lambda i: (room(), Z(n))),
        "GetContinuousStateDerivatives": ("NECT", "", lambda i: (room(), Z(n))),
        "GetEventIndicators": ("NECT", "", lambda i: (room(), Z(ni))),
        "GetContinuousStates": ("NECT", "", lambda i: (room(), Z(n))),
        "GetNominalsOfContinuousStates": ("INECT", "", lambda i: (room(), Z(n))),
        "GetNumberOfEventIndicators": ("INECT", "", lambda i: (room(),)),
        "GetNumberOfContinuousStates": ("INECT", "", lambda i: (room(),)),
        "EnterStepMode": ("", "", lambda i: ()),
        "GetOutputDerivatives": ("", "", lambda i: (None, Z(0), None, None, Z(0))),
        "DoStep": ("", "S",
                   lambda i: (D(0), D(1e-3), c.c_bool(True), *bools(3, False), room())),
        "ActivateModelPartition": ("", "", lambda i: (c.c_uint(0), D(0))),
    }


def states_in(unit, i):
    """The functions of states: with a state of the instance as it is."""
    word = "FMUstate" if i.two else "FMUState"
    state = c.c_void_p()
    assert i.status(f"Get{word}", c.byref(state)) == OK and state.value
    data, size = room(c.c_char, 1 << 16), c.c_size_t()
    assert i.status(f"Serialized{word}Size", state, c.byref(size)) == OK
    assert i.status(f"Serialize{word}", state, data, size) == OK
    other = c.c_void_p()
    name = "DeSerializeFMUstate" if i.two else "DeserializeFMUState"
    assert i.status(name, data, size, c.byref(other)) == OK
    assert i.status(f"Set{word}", other) == OK
    for held in (state, other):
        assert i.status(f"Free{word}", c.byref(held)) == OK and not held.value
    for name, arguments in ((f"Set{word}", (None,)), (f"Get{word}", (None,)),
                            (f"Serialize{word}", (None, None, Z(0)))):
        bad = Instance(unit, i.exchange)
        assert bad.status(name, *arguments) == ERROR and bad.log, name
        bad.free()


def bring(i, mode):
    if mode == "I":
        return
    if i.two:
        i.call("EnterInitializationMode")
    else:
        i.call("EnterInitializationMode", c.c_bool(False), D(0), D(0), c.c_bool(False), D(0))
    if mode == "N":
        return
    i.call("ExitInitializationMode")
    if mode == "C":
        i.call("EnterContinuousTimeMode")
    if mode == "T":
        i.call("Terminate")


def check(unit):
    d = unit.description
    table = (functions2 if d.two else functions3)(len(d.states), d.indicators,
                                                  d.outputs[0].reference)
    calls = 0
    for exchange in (True, False):
        for mode in "INECT" if exchange else "INST":
            for name, (with_exchange, with_steps, arguments) in table.items():
                allowed = mode in (with_exchange if exchange else with_steps)
                i = Instance(unit, exchange)
                bring(i, mode)
                i.log.clear()
                status = i.status(name, *arguments(i))
                where = f"{i.prefix}{name} in {mode}, exchange {exchange}: {status}, {i.log}"
                assert (status == OK) == allowed or (name == "GetReal" and mode == "I"), where
                assert status == OK or (i.log and i.log[-1][0] == status), where
                if not allowed:
                    assert i.status("Reset") == OK, where
                    bring(i, "E" if exchange else "S")
                i.free()
                calls += 1
            i = Instance(unit, exchange)
            bring(i, mode)
            states_in(unit, i)
            i.free()
    missing = [n for n in table if not hasattr(unit.library, ("fmi2" if d.two else "fmi3") + n)]
    assert not missing, missing
    return calls


for version in (2, 3):
    body = Unit(f"{sys.argv[1]}/body{version}.fmu")
    print(f"FMI {version}: {check(body)} calls")
    body.close()
