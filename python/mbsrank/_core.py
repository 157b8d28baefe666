# SPDX-License-Identifier: BSD-3-Clause
"""What all parts share: the library, its failures, arrays, views, functions of the caller's."""
from __future__ import annotations

import threading
from typing import Any, Callable, Sequence

import numpy as np

from ._c import ffi, lib
from ._interface import COMPONENTS

F8 = np.dtype("f8")
I4 = np.dtype("i4")
_buffer, _from_handle = ffi.from_buffer, ffi.from_handle
_DOUBLES = ffi.typeof("double[]")
_INTS = ffi.typeof("int[]")
_NULL = ffi.NULL
_EXCEPTION = -32000  # what a function of the caller's returns to C when it raises


class Error(RuntimeError):
    """A call failed. `status` is its number, `name` that number's name, `text` what the library
    says; `body` and `force` are the ids concerned, None where there are none."""

    def __init__(self, status: int, text: str = "", body: int | None = None,
                 force: int | None = None):
        self.status, self.text, self.body, self.force = status, text, body, force
        self.name = ffi.string(lib.mbsr_status_name(status)).decode()
        meaning = ffi.string(lib.mbsr_status_text(status)).decode()
        super().__init__(f"{self.name}: {text or meaning}")


class StateError(Error):
    """Depends on the state (status above zero): a rank, a loop that does not close, a number that
    is not finite. The object stays usable."""


class UseError(Error, ValueError):
    """Wrong use (status below zero): the text names body, field and value."""


class ClosedError(RuntimeError):
    """The object has been closed."""


# ---- failures ----

_raised: dict[int, BaseException] = {}


def _keep_exception(_kind, value, _trace) -> None:
    _raised[threading.get_ident()] = value


def fail(status: int, error=None) -> None:
    """Raises what a status means; where a function of the caller's has raised, that."""
    own = _raised.pop(threading.get_ident(), None)
    if status == _EXCEPTION:
        if own is None and _raised:  # it was called from a thread of the library's
            own = _raised.popitem()[1]
            alive = {one.ident for one in threading.enumerate()}
            for stale in set(_raised) - alive:
                _raised.pop(stale, None)
        if own is not None:
            raise own
    kind = StateError if status > 0 else UseError
    if status == lib.MBSR_ERR_NO_MEMORY:
        raise MemoryError("mbsrank: an allocation failed")
    if error is None or error == ffi.NULL or error.status != status:
        raise kind(status) from own
    body, force = (None if at == lib.MBSR_NONE else at for at in (error.body, error.force))
    raise kind(status, ffi.string(error.text).decode(errors="replace"), body, force) from own


def needs(component: str) -> None:
    """Says so where the package was built without a component."""
    if component not in COMPONENTS:
        raise ImportError(f"mbsrank was built without the component {component} of libmbsrank")


# ---- handles ----

class Handle:
    """A thing of the library's, freed when nobody holds it any more: neither its object, nor a
    view, nor what was made from it. `keep` is what must live as long; handles there are freed
    later, in cycles of garbage too."""

    __slots__ = ("pointer", "keep", "_destroy", "_parents", "_children", "_dead", "__weakref__")

    def __init__(self, pointer, destroy: Callable | None, *keep: Any):
        self.pointer, self._destroy, self.keep = pointer, destroy, list(keep)
        self._parents = [one for one in keep if isinstance(one, Handle)]
        self._children, self._dead = 0, False
        for parent in self._parents:
            parent._children += 1

    def hold(self, other: Any) -> None:
        """Keeps something else as well."""
        self.keep.append(other)
        if isinstance(other, Handle):
            self._parents.append(other)
            other._children += 1

    def _free(self):
        if self._children or self._destroy is None:
            return
        self._destroy(self.pointer)
        self._destroy = None
        for parent in self._parents:
            parent._children -= 1
            if parent._dead:
                parent._free()

    def __del__(self):
        self._dead = True
        self._free()


class Owner:
    """An object with a handle; `close`, or leaving a `with`, gives it up, and later calls raise."""

    _handle: Handle | None = None

    def _get(self):
        handle = self._handle
        if handle is None:
            raise ClosedError(f"the {type(self).__name__} is closed")
        return handle.pointer

    @property
    def closed(self) -> bool:
        """Whether it has been closed."""
        return self._handle is None

    def __repr__(self):
        closed = "" if self._handle else "closed "
        return f"<{closed}{type(self).__name__} of {getattr(self, 'model', None)!r}>"

    def close(self) -> None:
        """Gives it up: later calls raise ClosedError. Memory is freed as soon as no view and
        nothing made from it is left."""
        self._handle = None

    def __enter__(self):
        self._get()
        return self

    def __exit__(self, *_):
        self.close()


# ---- arrays ----

def refuse(array, shape: Sequence[int], name: str, kind=F8, write: bool = False):
    """Says why an array does not fit."""
    wanted = f"{name}: expected a C-contiguous {kind.name} array of shape {tuple(shape)}"
    if not isinstance(array, np.ndarray):
        raise TypeError(f"{wanted}, got {type(array).__name__}")
    if array.dtype != kind:
        other = " of the other byte order" if not array.dtype.isnative else ""
        raise TypeError(f"{wanted}, got {array.dtype.name}{other}")
    if array.shape != tuple(shape):
        raise ValueError(f"{wanted}, got shape {array.shape}")
    if write and not array.flags.writeable:
        raise ValueError(f"{wanted} that can be written")
    raise ValueError(f"{wanted}, got another order")


def given(array, shape: tuple, name: str):
    """A pointer to the numbers of an array that is read."""
    try:
        if array.dtype == F8 and array.shape == shape:
            return ffi.from_buffer(_DOUBLES, array)
    except (AttributeError, ValueError, BufferError):
        pass
    return refuse(array, shape, name)


def taken(array, shape: tuple, name: str):
    """The same of one that is written."""
    try:
        if array.dtype == F8 and array.shape == shape:
            return ffi.from_buffer(_DOUBLES, array, True)
    except (AttributeError, ValueError, BufferError):
        pass
    return refuse(array, shape, name, F8, True)


def evaluated(seen: list, first, shape: tuple, second, third, load, last: tuple, out, names: str):
    """Pointers to arrays that are read, of shape, third and last (load may be None), and to one
    that is written, of shape last: the way of calls that are made often. seen: the arrays of the
    call before with their pointers, which take longest to find. names: of the three."""
    try:
        if (first.dtype is F8 and second.dtype is F8 and out.dtype is F8 and first.shape == shape
                and second.shape == third and out.shape == last):
            if first is not seen[0]:
                seen[:2] = first, _buffer(_DOUBLES, first)
            if second is not seen[2]:
                seen[2:4] = second, _buffer(_DOUBLES, second)
            if out is not seen[6]:
                seen[6:] = out, _buffer(_DOUBLES, out, True)
            elif not out.flags.writeable:
                return refuse(out, last, "out", F8, True)
            if load is None:
                return seen[1], seen[3], _NULL, seen[7]
            if load.dtype is F8 and load.shape == last:
                if load is not seen[4]:
                    seen[4:6] = load, _buffer(_DOUBLES, load)
                return seen[1], seen[3], seen[5], seen[7]
    except (AttributeError, ValueError, BufferError):
        pass
    name, other, one = names.split()
    return (given(first, shape, name), given(second, third, other),
            _NULL if load is None else given(load, last, one), taken(out, last, "out"))


def given_ints(array, shape: tuple, name: str):
    """The same of whole numbers that are read."""
    try:
        if array.dtype == I4 and array.shape == shape:
            return ffi.from_buffer(_INTS, array)
    except (AttributeError, ValueError, BufferError):
        pass
    return refuse(array, shape, name, I4)


def numbers(value, count: int | None, name: str) -> np.ndarray:
    """A copy of a few numbers that need not be an array: directions, points."""
    array = np.array(value, dtype=F8).reshape(-1)
    if count is not None and array.size != count:
        raise ValueError(f"{name}: expected {count} numbers, got {array.size}")
    return array


class _Memory:
    """Memory of the library's as numpy sees it, with who owns it."""

    __slots__ = ("__array_interface__", "owner")

    def __init__(self, owner, pointer, shape, write, kind):
        self.owner = owner
        address = int(ffi.cast("uintptr_t", pointer))
        self.__array_interface__ = {"shape": shape, "typestr": kind, "version": 3,
                                    "data": (address, not write)}


def view(owner, pointer, shape: tuple, write: bool = False, kind: str = "<f8") -> np.ndarray:
    """An array on memory of the library's, without a copy; it keeps the owner alive."""
    if pointer == ffi.NULL or 0 in shape:
        return np.zeros(shape, dtype=kind)
    return np.asarray(_Memory(owner, pointer, shape, write, kind))


def lent(pointer, count: int) -> np.ndarray:
    """The same during a call of the caller's function alone."""
    if pointer == ffi.NULL:
        return np.zeros(0)
    return np.frombuffer(ffi.buffer(pointer, 8 * count), dtype=F8)


def text(pointer) -> str:
    """A text of the library's; "" where there is none."""
    return "" if pointer == ffi.NULL else ffi.string(pointer).decode(errors="replace")


def encoded(value, name: str) -> bytes:
    """A text for the library."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected a text, got {type(value).__name__}")
    if "\0" in value:
        raise ValueError(f"{name}: it contains a NUL")
    return value.encode()


# ---- records ----

class Record:
    """Results with names: fields of a struct, as numbers, texts, arrays and records."""

    _kind = "record"

    def __init__(self, kind: str, fields: dict[str, Any]):
        self.__dict__.update(fields)
        self._kind = kind

    def _fields(self):
        return {name: value for name, value in self.__dict__.items() if name[0] != "_"}

    def __repr__(self):
        lines = []
        for name, value in self._fields().items():
            lines.append(f"{name}={value!r}")
        return f"{self._kind}({', '.join(lines)})"

    def __str__(self):
        fields = self._fields()
        wide = max(map(len, fields), default=0)
        return "\n".join(f"{name:{wide}}  {value}" for name, value in fields.items())

    def __eq__(self, other):
        return isinstance(other, Record) and repr(self) == repr(other)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{self._kind} has no {name}")

    __hash__ = None  # type: ignore[assignment]


def plain(struct, skip: Sequence[str] = ()) -> Record:
    """Copies a struct: numbers, texts, arrays, structs in it; pointers are left out."""
    kind = ffi.typeof(struct)
    if kind.kind == "pointer":
        kind, struct = kind.item, struct[0]
    fields = {}
    for name, one in kind.fields:
        if name in skip or name == "cookie":
            continue
        value = getattr(struct, name)
        if one.type.kind == "primitive":
            fields[name] = value
        elif one.type.kind == "enum":
            fields[name] = int(value)
        elif one.type.kind == "array" and one.type.item.kind == "primitive":
            fields[name] = (ffi.string(value).decode() if one.type.item.cname == "char"
                            else np.array(list(value)))
        elif one.type.kind == "struct":
            fields[name] = plain(value)
        elif one.type.kind == "pointer" and one.type.item.cname == "char":
            fields[name] = text(value)
    return Record(kind.cname.removeprefix("mbsr_"), fields)


# ---- functions of the caller's ----

def _extern(name: str):
    return ffi.def_extern(name=f"mbsrank_{name}", error=_EXCEPTION, onerror=_keep_exception)


def _put(pointer, value, count: int | None, what: str) -> None:
    """Writes what a function has returned."""
    if value is None:
        raise TypeError(f"{what}: it returned None")
    array = np.atleast_1d(np.asarray(value, dtype=F8)).reshape(-1)
    if count is not None and array.size != count:
        raise ValueError(f"{what}: expected {count} numbers, got {array.size}")
    for k, x in enumerate(array.tolist()):
        pointer[k] = x


@_extern("mbsr_force_fn")
def _force(user, t, n, value):
    result = _from_handle(user)(t)
    if n == 1 and type(result) is float:
        value[0] = result
    else:
        _put(value, result, n, "a function of time")
    return 0


@_extern("mbsr_motion_fn")
def _motion(user, t, s, sdot, sddot):
    sizes = {s: 0}
    three = ffi.from_handle(user)(t)
    if len(three) != 3:
        raise ValueError("a motion: expected value, first and second derivative")
    for pointer, value, what in zip((s, sdot, sddot), three, ("value", "first", "second")):
        _put(pointer, value, sizes.get("n"), f"a motion, {what}")
        sizes["n"] = np.size(value)
    return 0


@_extern("mbsr_spring_fn")
def _spring(user, x, v, force, energy, power):
    result = np.atleast_1d(np.asarray(ffi.from_handle(user)(x, v), dtype=F8)).tolist()
    for pointer, value in zip((force, energy, power), result):
        if pointer != ffi.NULL:
            pointer[0] = value
    return 0


@_extern("mbsr_event_fn")
def _event(user, t, y, yp, value):
    size, count, function = ffi.from_handle(user)
    _put(value, function(t, lent(y, size), lent(yp, size)), count, "events")
    return 0


@_extern("mbsr_ida_progress_fn")
def _progress(user, now):
    return 1 if ffi.from_handle(user)(plain(now)) else 0


@_extern("mbsr_file_load_fn")
def _load(user, path, content, size):
    return ffi.from_handle(user)(path, content, size)


class ForceBody:
    """One body as a force element of the caller's sees it: id, and arrays that are valid during
    the call alone. p: pose; V: velocity; q, u: of its joint; add to f (conjugate to V) and tau (to
    u)."""

    __slots__ = ("id", "space", "p", "V", "q", "u", "f", "tau")

    def __init__(self, b):
        self.id, self.space = b.id, int(b.space)
        self.p, self.V, self.q = lent(b.p, b.np), lent(b.V, b.d), lent(b.q, b.nq)
        self.u, self.f, self.tau = lent(b.u, b.n), lent(b.f, b.d), lent(b.tau, b.n)


@ffi.def_extern(name="mbsrank_force_evaluate", error=_EXCEPTION, onerror=_keep_exception)
def _evaluate(args):
    evaluate, _ = ffi.from_handle(args.force.user)
    evaluate(args.t, [ForceBody(args.body[k]) for k in range(args.bodies)])
    return 0


@ffi.def_extern(name="mbsrank_force_energy", error=_EXCEPTION, onerror=_keep_exception)
def _energy(args, energy):
    _, function = ffi.from_handle(args.force.user)
    energy[0] = function(args.t, [ForceBody(args.body[k]) for k in range(args.bodies)])
    return 0


TRAMPOLINES = {
    "mbsr_force_fn": lib.mbsrank_mbsr_force_fn,
    "mbsr_motion_fn": lib.mbsrank_mbsr_motion_fn,
    "mbsr_spring_fn": lib.mbsrank_mbsr_spring_fn,
    "mbsr_event_fn": lib.mbsrank_mbsr_event_fn,
    "mbsr_ida_progress_fn": lib.mbsrank_mbsr_ida_progress_fn,
    "mbsr_file_load_fn": lib.mbsrank_mbsr_file_load_fn,
}
