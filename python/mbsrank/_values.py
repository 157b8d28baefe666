# SPDX-License-Identifier: BSD-3-Clause
"""Values that models are built from: frames, joints, inertias, force elements, closures, tables;
and what makes their constructors from the headers."""
from __future__ import annotations

import inspect
import operator
from typing import Any, Callable, Mapping, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from ._core import F8, TRAMPOLINES, Handle, Owner, encoded, fail, numbers, text
from ._c import ffi, lib
from ._interface import FUNCTIONS


class Frame:
    """A frame that stands in another: origin x (3, m) and rotation R (3 x 3, its columns are the
    axes).

    Frame(x=None, R=None, axis=None, angle=0.0, quaternion=None): shifted, and turned by R, or by
    an angle in rad about an axis, or by a quaternion (w, x, y, z)."""

    __slots__ = ("x", "R")

    def __init__(self, x: ArrayLike | None = None, R: ArrayLike | None = None,
                 axis: ArrayLike | None = None, angle: float = 0.0,
                 quaternion: ArrayLike | None = None):
        self.x = np.zeros(3) if x is None else numbers(x, 3, "x")
        self.R = np.eye(3) if R is None else np.array(R, dtype=F8).reshape(3, 3)
        if axis is not None:
            self.R = _rotation(lib.mbsr_frame_rotated(ffi.NULL, _doubles(axis, 3, "axis"), angle))
        elif quaternion is not None:
            four = _doubles(quaternion, 4, "quaternion")
            self.R = _rotation(lib.mbsr_frame_quaternion(ffi.NULL, four))

    def __matmul__(self, other: "Frame") -> "Frame":
        return Frame(self.x + self.R @ other.x, self.R @ other.R)

    def inverse(self) -> "Frame":
        """The frame that it stands in, seen from it."""
        return Frame(-self.R.T @ self.x, self.R.T)

    def __repr__(self):
        return f"Frame(x={self.x.tolist()}, R={self.R.tolist()})"

    def _struct(self):
        return {"x": self.x.tolist(), "R": self.R.T.reshape(-1).tolist()}


#: A frame, three numbers (shifted, axes parallel), or None: the body's own.
FrameLike = Union[Frame, ArrayLike, None]


def _rotation(struct) -> np.ndarray:
    return np.array(list(struct.R)).reshape(3, 3).T.copy()


def frame_of(struct) -> Frame:
    """Of a struct of the library's."""
    return Frame(list(struct.x), _rotation(struct))


def _frame(value: FrameLike) -> Frame:
    return value if isinstance(value, Frame) else Frame(value)


def _doubles(value, count, name):
    return ffi.new("double[]", numbers(value, count, name).tolist())


class Table(Owner):
    """A function of one number by points: x (n), value (n, or n x columns). kind: "linear",
    "monotone" (no overshoot) or "spline"; beyond its ends: "constant", "straight" or "refuse"."""

    def __init__(self, x: ArrayLike, value: ArrayLike, kind: str = "linear",
                 beyond: str = "constant"):
        at = np.ascontiguousarray(x, dtype=F8).reshape(-1)
        values = np.ascontiguousarray(value, dtype=F8)
        if values.ndim not in (1, 2) or values.shape[0] != at.size:
            raise ValueError(f"value: expected {at.size} rows as x, got shape {values.shape}")
        define = _box("mbsr_table_def", lib.mbsr_default_table_def())
        define.points, define.columns = at.size, 1 if values.ndim == 1 else values.shape[1]
        define.x, define.value = (ffi.from_buffer("double[]", one) for one in (at, values))
        define.kind = _choice("TABLE", kind)
        define.beyond = _choice("TABLE", beyond)
        self.columns, self._shape = define.columns, values.shape[1:]
        error, made = ffi.new("mbsr_error *"), ffi.new("mbsr_table **")
        status = lib.mbsr_table_create(ffi.addressof(define), made, error)
        if status:
            fail(status, error)
        self._handle = Handle(made[0], lib.mbsr_table_destroy)

    def __call__(self, x: float, derivative: int = 0) -> Any:
        """The value at x, its first or second derivative."""
        if derivative not in (0, 1, 2):
            raise ValueError(f"derivative: expected 0, 1 or 2, got {derivative}")
        outs = [ffi.new("double[]", self.columns) for _ in range(3)]
        status = lib.mbsr_table_value(self._get(), x, *outs)
        if status:
            fail(status)
        out = np.array(list(outs[derivative])).reshape(self._shape)
        return float(out) if out.ndim == 0 else out


def _box(kind: str, value):
    box = ffi.new(f"{kind} *", value)
    return box[0]


def _choice(group: str, name: str) -> int:
    try:
        return getattr(lib, f"MBSR_{group}_{name.upper()}")
    except AttributeError:
        raise ValueError(f"there is no {group.lower()} '{name}'") from None


# ---- values ----

class Value:
    """A struct by value, with what it refers to; its fields can be read and set."""

    _kind = ""

    def __init__(self, struct, keep: Sequence[Any] = ()):
        object.__setattr__(self, "_box", ffi.new(f"{self._kind} *", struct))
        object.__setattr__(self, "_keep", list(keep))

    def __getattr__(self, name):
        if name[0] == "_":
            raise AttributeError(name)
        value = getattr(self._box, name)
        if isinstance(value, ffi.CData):
            kind = ffi.typeof(value)
            if kind.kind == "array":
                return np.array(list(value))
            if kind.kind == "pointer" and kind.item.cname == "char":
                return text(value) or None
        return value

    def __setattr__(self, name, value):
        if name not in {field for field, _ in ffi.typeof(self._kind).fields}:
            raise AttributeError(f"{type(self).__name__} has no {name}")
        fill(self._box, {name: value}, self._keep, name)

    def __repr__(self):
        table = getattr(self._box, "table", ffi.NULL)
        what = f" '{text(table.name)}'" if table != ffi.NULL else ""
        return f"<{type(self).__name__}{what}>"


class Joint(Value):
    """A joint between a body and its predecessor (module joint makes them)."""

    _kind = "mbsr_joint"


class Inertia(Value):
    """The inertia of a body, zero included (module inertia makes them)."""

    _kind = "mbsr_inertia"


class Force(Value):
    """A force element (module force makes them); `name`, `as_closure` and others can be set."""

    _kind = "mbsr_force_def"


class Closure(Value):
    """A closure of a loop (module closure makes them); `name`, `stiffness`, `damping`, `motion`
    can be set."""

    _kind = "mbsr_closure_def"


VALUES = {kind._kind: kind for kind in (Joint, Inertia, Force, Closure)}


# ---- from Python to C ----

def callback(kind: str, value, keep: list):
    """A function of the caller's, or a table, as a function of C and what it is called with."""
    if value is None:
        return ffi.NULL, ffi.NULL
    if isinstance(value, Table):
        keep.append(value._handle)
        by = {"mbsr_force_fn": "mbsr_table_force", "mbsr_motion_fn": "mbsr_table_motion"}
        if kind not in by:
            raise TypeError("a table does not serve here")
        return ffi.addressof(lib, by[kind]), value._get()
    if not callable(value):
        raise TypeError(f"expected a function, got {type(value).__name__}")
    if kind not in TRAMPOLINES:
        raise TypeError(f"functions of type {kind} cannot be written in Python")
    handle = ffi.new_handle(value)
    keep.extend((handle, value))
    return TRAMPOLINES[kind], handle


def _user_of(field: str, names) -> str:
    """Which field goes to a function as its first argument."""
    return f"{field}_user" if f"{field}_user" in names else "user"


def options(kind: str, values: Mapping[str, Any], keep: list, what: str):
    """A pointer to the library's defaults with these fields set."""
    made = ffi.new(f"{kind} *", getattr(lib, kind.replace("mbsr_", "mbsr_default_"))())
    fill(made, values, keep, what)
    return made


def fill(struct, values: Mapping[str, Any], keep: list, what: str) -> None:
    """Sets fields of a struct by name."""
    kind = ffi.typeof(struct)
    fields = dict((kind.item if kind.kind == "pointer" else kind).fields)
    for name, value in values.items():
        if name not in fields or name == "cookie":
            known = ", ".join(one for one in fields if one not in ("cookie", "user"))
            raise TypeError(f"{what}: there is no '{name}', but {known}")
        _set(struct, name, fields[name].type, value, keep, fields)


def _set(struct, name, kind, value, keep, fields):
    if kind.kind == "function":
        function, user = callback(_function_type(kind, name), value, keep)
        setattr(struct, name, function)
        setattr(struct, _user_of(name, fields), user)
    elif kind.kind == "pointer" and kind.item.cname == "char":
        keep.append(ffi.new("char[]", encoded(value, name)) if value is not None else ffi.NULL)
        setattr(struct, name, keep[-1])
    elif kind.kind == "pointer" and isinstance(value, Table):
        keep.append(value._handle)
        setattr(struct, name, value._get())
    elif kind.kind == "pointer" and kind.item.cname in ("double", "int") and value is not None \
            and not isinstance(value, ffi.CData):
        keep.append(ffi.new(f"{kind.item.cname}[]", np.asarray(value).reshape(-1).tolist()))
        setattr(struct, name, keep[-1])
    elif kind.kind == "array" and not isinstance(value, ffi.CData):
        items = np.atleast_1d(np.asarray(value)).reshape(-1).tolist()
        if len(items) > kind.length:
            raise ValueError(f"{name}: expected {kind.length} numbers at most, got {len(items)}")
        for k, item in enumerate(items):
            getattr(struct, name)[k] = item
    elif kind.kind == "struct" and isinstance(value, Mapping):
        fill(ffi.addressof(getattr(struct, name)), value, keep, name)
    elif kind is ffi.typeof("mbsr_frame") and not isinstance(value, ffi.CData):
        setattr(struct, name, _frame(value)._struct())
    else:
        setattr(struct, name, ffi.NULL if value is None else value)


_BY_TYPE = {ffi.typeof(function): name for name, function in TRAMPOLINES.items()
            if name != "mbsr_event_fn"}  # which needs sizes: Simulation gives it


def _function_type(kind, name: str) -> str:
    if kind not in _BY_TYPE:
        raise TypeError(f"functions of field {name} cannot be written in Python")
    return _BY_TYPE[kind]


def to_c(kind: str, name: str, value, keep: list):
    """An argument of a constructor."""
    if isinstance(value, ffi.CData):
        return value
    if kind in VALUES:
        if not isinstance(value, VALUES[kind]):
            raise TypeError(f"{name}: expected {VALUES[kind].__name__}, got {type(value).__name__}")
        keep.extend(value._keep)
        return value._box[0]
    if kind == "double":
        return float(value)
    if kind == "mbsr_planar_frame":
        return dict(zip(("x", "y", "angle"), numbers(() if value is None else value, None, name)))
    if kind.endswith("*") or kind.endswith("]"):
        return _pointer(kind, name, value, keep)
    return operator.index(value)


def _pointer(kind: str, name: str, value, keep: list):
    if isinstance(value, Table):
        keep.append(value._handle)
        return value._get()
    if kind == "const mbsr_frame *":
        made = ffi.NULL if value is None else ffi.new("mbsr_frame *", _frame(value)._struct())
    elif value is None:
        made = ffi.NULL
    elif kind == "const char *":
        made = ffi.new("char[]", encoded(value, name))
    elif "double" in kind:
        count = int(kind[kind.index("[") + 1:-1]) if "[" in kind else None
        made = _doubles(value, count, name)
    elif "int" in kind and "mbsr" not in kind:
        made = ffi.new("int[]", [operator.index(one) for one in np.atleast_1d(value).tolist()])
    else:
        made = ffi.new(f"{kind.removeprefix('const ')}")
        fill(made, value, keep, name)
    keep.append(made)
    return made


def constructor(name: str, python_name: str) -> Callable[..., Value]:
    """A constructor of values, from what the header says of it."""
    result, parameters, document = FUNCTIONS[name]
    function = getattr(lib, name)
    taken = [(kind, at) for kind, at in parameters if kind != "void *"]
    free = len(taken)
    while free and (taken[free - 1][0][-1] in "*]" or taken[free - 1][0].endswith("_fn")):
        free -= 1
    signature = inspect.Signature([
        inspect.Parameter(at, inspect.Parameter.POSITIONAL_OR_KEYWORD,
                          default=None if k >= free else inspect.Parameter.empty)
        for k, (_, at) in enumerate(taken)])

    def make(*arguments, **named):
        bound = signature.bind(*arguments, **named)
        bound.apply_defaults()
        keep, converted = [], []
        for kind, at in taken:
            if kind.endswith("_fn"):
                converted.extend(callback(kind, bound.arguments[at], keep))
            else:
                converted.append(to_c(kind, at, bound.arguments[at], keep))
        return VALUES[result](function(*converted), keep)

    make.__name__ = make.__qualname__ = python_name
    make.__doc__ = document
    make.__signature__ = signature  # type: ignore[attr-defined]
    return make


def _serves(parameters) -> bool:
    """Whether Python can give what it takes: tables of functions are for C, but for what
    force.custom makes."""
    return not any(kind.endswith("_table *") and kind != "mbsr_table *"
                   or kind.endswith("_fn") and kind not in TRAMPOLINES for kind, _ in parameters)


def constructors(result: str) -> dict[str, Callable[..., Value]]:
    """All that make one kind of values, by their names in Python."""
    prefix = {"mbsr_joint": "mbsr_joint_", "mbsr_inertia": "mbsr_inertia_",
              "mbsr_force_def": "mbsr_force_", "mbsr_closure_def": "mbsr_closure_"}[result]
    found = {}
    for name, (kind, _, _) in FUNCTIONS.items():
        if kind == result and "default" not in name and _serves(FUNCTIONS[name][1]):
            python_name = name[len(prefix):] if name.startswith(prefix) else name[len("mbsr_"):]
            found[python_name] = constructor(name, python_name)
    return found
