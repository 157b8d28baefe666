"""An importer of FMUs, written from the standard alone: unpacks a unit, reads its description, and calls the functions of the
shared object by ctypes. SPDX-License-Identifier: BSD-3-Clause"""
import ctypes as c
import os
import pathlib
import tempfile
import zipfile

from description import Description

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
LOG2 = c.CFUNCTYPE(None, c.c_void_p, c.c_char_p, c.c_int, c.c_char_p, c.c_char_p, c.c_char_p)
LOG3 = c.CFUNCTYPE(None, c.c_void_p, c.c_int, c.c_char_p, c.c_char_p)
UPDATE = c.CFUNCTYPE(None, c.c_void_p, c.c_double, c.c_bool, c.c_bool, c.c_bool, c.c_bool,
                     c.POINTER(c.c_bool), c.POINTER(c.c_double))


class Callbacks2(c.Structure):
    _fields_ = [("logger", LOG2), ("allocate", c.c_void_p), ("free", c.c_void_p),
                ("finished", c.c_void_p), ("environment", c.c_void_p)]


class EventInfo2(c.Structure):
    _fields_ = [(name, c.c_int) for name in ("more", "terminate", "nominals", "values", "defined")]
    _fields_ += [("time", c.c_double)]


class Refused(Exception):
    def __init__(self, function, status, log):
        super().__init__(f"{function}: status {status}: {log[-1:]}")
        self.status = status


def doubles(values):
    return (c.c_double * len(values))(*values)


def references(variables):
    return (c.c_uint * len(variables))(*[v.reference for v in variables])


class Unit:
    """An FMU but for its sources in a folder of its own, with a space in its path, that cannot be written to."""

    def __init__(self, path):
        self.name, self.folder = pathlib.Path(path).stem, tempfile.TemporaryDirectory(prefix="unit with space ")
        with zipfile.ZipFile(path) as archive:
            assert archive.testzip() is None
            archive.extractall(self.folder.name, [name for name in archive.namelist() if not name.startswith("sources/")])
        where = pathlib.Path(self.folder.name)
        self.description = d = Description((where / "modelDescription.xml").read_text())
        identifier = next(iter(d.kinds.values())).get("modelIdentifier")
        platform = "linux64" if d.two else os.uname().machine + "-linux"
        self.library = c.CDLL(str(where / "binaries" / platform / (identifier + ".so")),
                              mode=os.RTLD_NOW | os.RTLD_LOCAL)
        resources = where / "resources"
        self.resources = resources.as_uri() if d.two else str(resources) + os.sep
        for folder, _, files in os.walk(where):
            for name in files:
                os.chmod(os.path.join(folder, name), 0o444)
            os.chmod(folder, 0o555)

    def close(self):
        for folder, _, _ in os.walk(self.folder.name):
            os.chmod(folder, 0o755)
        self.folder.cleanup()


class Instance:
    """One instance. Calls that do not return OK raise Refused; messages are in `log`."""

    def __init__(self, unit, exchange, token=None, resources=None, events=False, update=None,
                 early=False):
        self.unit, self.exchange, self.log = unit, exchange, []
        self.two = unit.description.two
        self.prefix = "fmi2" if self.two else "fmi3"
        token = (token or unit.description.token).encode()
        resources = (resources or unit.resources).encode()
        if self.two:
            def logger(_, name, status, category, text, argument):
                self.log.append((status, category.decode(), (argument or text).decode()))
            self.keep = Callbacks2(LOG2(logger), None, None, None, None)
            make = self.function("Instantiate", c.c_void_p)
            self.handle = make(b"one", 0 if exchange else 1, token, resources, c.byref(self.keep),
                               0, 1)
        else:
            def logger(_, status, category, text):
                self.log.append((status, category.decode(), text.decode()))
            self.keep = [LOG3(logger), UPDATE(update or (lambda *a: None))]
            if exchange:
                make = self.function("InstantiateModelExchange", c.c_void_p)
                self.handle = make(b"one", token, resources, c.c_bool(False), c.c_bool(True), None,
                                   self.keep[0])
            else:
                make = self.function("InstantiateCoSimulation", c.c_void_p)
                self.handle = make(b"one", token, resources, c.c_bool(False), c.c_bool(True),
                                   c.c_bool(events), c.c_bool(early), None, c.c_size_t(0), None,
                                   self.keep[0], self.keep[1] if update else None)

    def function(self, name, result=c.c_int):
        made = getattr(self.unit.library, self.prefix + name)
        made.restype = result
        return made

    def status(self, name, *arguments):
        return self.function(name)(c.c_void_p(self.handle), *arguments)

    def call(self, name, *arguments):
        status = self.status(name, *arguments)
        if status != OK:
            raise Refused(name, status, self.log)

    def free(self):
        self.function("FreeInstance", None)(c.c_void_p(self.handle))
        self.handle = None

    # ---- values ----

    def get(self, variables):
        values = (c.c_double * len(variables))()
        count = c.c_size_t(len(variables))
        extra = () if self.two else (count,)
        self.call("GetReal" if self.two else "GetFloat64", references(variables), count, values,
                  *extra)
        return list(values)

    def set(self, variables, values):
        count = c.c_size_t(len(variables))
        extra = () if self.two else (count,)
        self.call("SetReal" if self.two else "SetFloat64", references(variables), count,
                  doubles(values), *extra)

    # ---- modes ----

    def initialize(self, start=0.0, tolerance=None, before=None):
        defined, tolerance = int(tolerance is not None), c.c_double(tolerance or 0.0)
        if self.two:
            self.call("SetupExperiment", defined, tolerance, c.c_double(start), 0, c.c_double(0.0))
            self.call("EnterInitializationMode")
        else:
            self.call("EnterInitializationMode", c.c_bool(bool(defined)), tolerance,
                      c.c_double(start), c.c_bool(False), c.c_double(0.0))
        if before:
            before(self)
        self.call("ExitInitializationMode")

    def step(self, t, h):
        """The time reached, and whether an event wants to be handled."""
        if self.two:
            self.call("DoStep", c.c_double(t), c.c_double(h), 1)
            return t + h, False
        event, end, early, last = c.c_bool(), c.c_bool(), c.c_bool(), c.c_double()
        self.call("DoStep", c.c_double(t), c.c_double(h), c.c_bool(True), c.byref(event),
                  c.byref(end), c.byref(early), c.byref(last))
        assert early.value == (last.value < t + h)
        return last.value, event.value

    # ---- model exchange ----

    def update_states(self):
        """The next time event, or None."""
        if self.two:
            info = EventInfo2()
            self.call("NewDiscreteStates", c.byref(info))
            return info.time if info.defined else None
        flags = [c.c_bool() for _ in range(5)]
        time = c.c_double()
        self.call("UpdateDiscreteStates", *[c.byref(f) for f in flags], c.byref(time))
        return time.value if flags[4].value else None

    def numbers(self, name, count):
        values = (c.c_double * count)()
        self.call(name, values, c.c_size_t(count))
        return list(values)

    def derivatives(self, t, x):
        self.call("SetTime", c.c_double(t))
        self.call("SetContinuousStates", doubles(x), c.c_size_t(len(x)))
        return self.numbers("GetDerivatives" if self.two else "GetContinuousStateDerivatives",
                            len(x))

    # ---- states ----

    def save(self):
        state = c.c_void_p()
        self.call("GetFMUstate" if self.two else "GetFMUState", c.byref(state))
        return state

    def restore(self, state):
        self.call("SetFMUstate" if self.two else "SetFMUState", state)

    def forget(self, state):
        self.call("FreeFMUstate" if self.two else "FreeFMUState", c.byref(state))
        assert not state.value

    def to_bytes(self, state):
        size = c.c_size_t()
        word = "FMUstate" if self.two else "FMUState"
        self.call(f"Serialized{word}Size", state, c.byref(size))
        data = (c.c_char * size.value)()
        self.call(f"Serialize{word}", state, data, size)
        return bytes(data)

    def from_bytes(self, data):
        state = c.c_void_p()
        self.call("DeSerializeFMUstate" if self.two else "DeserializeFMUState", data,
                  c.c_size_t(len(data)), c.byref(state))
        return state

    def sensitivity(self, unknowns, knowns, seed, adjoint=False):
        result = (c.c_double * len(knowns if adjoint else unknowns))()
        first = (references(unknowns), c.c_size_t(len(unknowns)), references(knowns),
                 c.c_size_t(len(knowns)), doubles(seed))
        if self.two:
            self.call("GetDirectionalDerivative", *first, result)
        else:
            self.call("GetAdjointDerivative" if adjoint else "GetDirectionalDerivative", *first,
                      c.c_size_t(len(seed)), result, c.c_size_t(len(result)))
        return list(result)
