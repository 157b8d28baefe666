# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria, trim, linear equations of motion and modes (component linear)."""
from __future__ import annotations

from typing import Sequence

import numpy as np

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, fail, given, needs, plain, taken, view
from .model import Data, Model, _create
from .parameters import Parameters


def _solve(function, *arguments) -> None:
    """Calls a function whose last argument is the reason of a failure."""
    error = ffi.new("mbsr_error *")
    status = function(*arguments, error)
    if status:
        fail(status, error)


def equilibrium(model: Model, q: np.ndarray, t: float = 0.0,
                **options) -> tuple[np.ndarray, np.ndarray, Record]:
    """Positions (nq) near q at which the model rests, the forces of its loops (rows) there, and
    what it took. options: fields of mbsr_equilibrium_opt. StateError: none is found; the text names
    the joint whose forces are farthest from balance."""
    needs("linear")
    data, info, keep = Data(model), ffi.new("mbsr_equilibrium_info *"), []
    rest, forces = np.empty(model.nq), np.empty(model.rows)
    _solve(lib.mbsr_equilibrium, model._get(), data._get(), t, given(q, (model.nq,), "q"),
           _values.options("mbsr_equilibrium_opt", options, keep, "equilibrium"),
           taken(rest, rest.shape, "out"), taken(forces, forces.shape, "out"), info)
    return rest, forces, plain(info)


def trim(parameters: Parameters, q: np.ndarray, free: Sequence[str] = (),
         hold: Sequence[int] | str = (), t: float = 0.0,
         **options) -> tuple[np.ndarray, dict[str, float], Record]:
    """Positions (nq) near q and values of the parameters `free` (names) at which the model of
    `parameters` rests; along the joint rates `hold` (places in u, or "all") positions stay.
    options: fields of mbsr_trim_opt."""
    needs("linear")
    info, keep = ffi.new("mbsr_trim_info *"), []
    chosen = {"held": -1} if hold == "all" else {"held": len(hold), "hold": list(hold)}
    which = ffi.new("int[]", [parameters.find(name) for name in free] or 1)
    rest, values = np.array(q), np.empty(len(free))
    _solve(lib.mbsr_trim, parameters._get(), t, given(q, q.shape, "q"), len(free), which,
           _values.options("mbsr_trim_opt", {**chosen, **options}, keep, "trim"),
           taken(rest, rest.shape, "out"), taken(values, values.shape, "out"), info)
    return rest, dict(zip(free, values.tolist())), plain(info)


def _signals(model: Model, parameters: Parameters | None, names: Sequence[int | str]):
    """mbsr_signal[]: places in u, and names of mbsr_signal_find."""
    made = ffi.new("mbsr_signal[]", len(names) or 1)
    listed = parameters._get() if parameters is not None else ffi.NULL
    for k, name in enumerate(names):
        if isinstance(name, str):
            _solve(lib.mbsr_signal_find, model._get(), listed, name.encode(), made + k)
        else:
            made[k].kind, made[k].id = lib.MBSR_SIGNAL_JOINT, int(name)
    return made


def _part(name: str, form: str) -> property:
    return property(lambda self: self._matrix(getattr(lib, f"MBSR_LINEAR_{name}")),
                    doc=f"Of the {form}.")


class Linear(Owner):
    """A model linearised at (t, q, u; u None: at rest). inputs: names, "bodies.rod.tau" or one of
    the parameters, or places in u of joint rates along which w are joint forces; outputs: names,
    "bodies.rod.q", "bodies.rod.x", "forces.spring.f", or places along which y are displacements.

        E x' = A x + B w,   x = (dq, dp, du, dlambda)         descriptor form
        z' = Ar z + Br w,   y = Cr z + Dr w                   least number of states

    E, A, B, Ar, Br, Cr and Dr are views (rows x columns) that keep the object alive."""

    def __init__(self, model: Model, q: np.ndarray, u: np.ndarray | None = None, t: float = 0.0,
                 inputs: Sequence[int | str] = (), outputs: Sequence[int | str] = (),
                 parameters: Parameters | None = None):
        needs("linear")
        data = Data(model)
        if parameters is None and any(isinstance(name, str) for name in inputs):
            parameters = Parameters(model)
        listed = parameters._get() if parameters is not None else ffi.NULL
        signals = _signals(model, parameters, inputs), _signals(model, parameters, outputs)
        chosen = {"inputs": len(inputs), "input": signals[0], "outputs": len(outputs),
                  "output": signals[1], "list": listed}
        options = _values.options("mbsr_linear_opt", chosen, (keep := []), "Linear")
        made = _create("mbsr_linear", lib.mbsr_linear_create, model._get(), data._get(), t,
                       given(q, (model.nq,), "q"),
                       ffi.NULL if u is None else given(u, (model.nu,), "u"), options)
        self._handle = Handle(made, lib.mbsr_linear_destroy)
        self._nu, self._ports = model.nu, (len(outputs), len(inputs))
        info = ffi.new("mbsr_linear_info *")
        lib.mbsr_linear_get_info(made, info)
        self.info = plain(info)

    def _matrix(self, part: int) -> np.ndarray:
        shape = ffi.new("int[2]")
        pointer = lib.mbsr_linear_matrix(self._get(), part, shape, shape + 1)
        return view(self._handle, pointer, (shape[1], shape[0])).T

    E = _part("E", "descriptor form")
    A = _part("A", "descriptor form")
    B = _part("B", "descriptor form")
    Ar = _part("AR", "form with the least number of states")
    Br = _part("BR", "form with the least number of states")
    Cr = _part("CR", "form with the least number of states")
    Dr = _part("DR", "form with the least number of states")

    def modes(self) -> list[Record]:
        """Modes exp(s t) in the order of |s|: real, imaginary (1/s), frequency (Hz), damping, and
        shape (nu, complex; the largest is 1)."""
        room, count = ffi.new("mbsr_mode[]", self.info.states + 1), ffi.new("int *")
        status = lib.mbsr_linear_modes(self._get(), room, count)
        if status:
            fail(status)
        found = []
        for k in range(count[0]):
            re, im = np.empty(self._nu), np.empty(self._nu)
            status = lib.mbsr_linear_shape(self._get(), k, taken(re, re.shape, "out"),
                                           taken(im, im.shape, "out"))
            if status:
                fail(status)
            found.append(_mode(room + k, re + 1j * im))
        return found

    def response(self, frequency: float) -> np.ndarray:
        """Outputs over inputs (complex) at a frequency in Hz."""
        re, im = np.empty(self._ports[::-1]), np.empty(self._ports[::-1])
        status = lib.mbsr_linear_response(self._get(), frequency, taken(re, re.shape, "out"),
                                          taken(im, im.shape, "out"))
        if status:
            fail(status)
        return (re + 1j * im).T

    def __repr__(self):
        return "<Linear, closed>" if self.closed else f"<Linear: {self.info.states} states>"


def _mode(struct, shape: np.ndarray) -> Record:
    one = plain(struct)
    vars(one)["shape"] = shape
    return one


def modes_near(model: Model, q: np.ndarray, count: int = 20, shift: float = 0.0, t: float = 0.0,
               **options) -> list[Record]:
    """A few modes of a large model about rest at (t, q), nearest to shift (1/s; 0: the slowest), as
    Linear.modes has them; without matrices, in O(N). options: fields of mbsr_near_opt."""
    needs("linear")
    data, found, room, keep = Data(model), ffi.new("int *"), ffi.new("mbsr_mode[]", count), []
    re, im = (np.empty((count, model.nu)) for _ in range(2))
    chosen = {"count": count, "shift": shift, **options}
    _solve(lib.mbsr_modes_near, model._get(), data._get(), t, given(q, (model.nq,), "q"),
           _values.options("mbsr_near_opt", chosen, keep, "modes_near"), room, found,
           taken(re, re.shape, "out"), taken(im, im.shape, "out"))
    return [_mode(room + k, re[k] + 1j * im[k]) for k in range(found[0])]


def participation(model: Model, q: np.ndarray, mode: Record,
                  t: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the energy of a mode about rest at (t, q) is: shares of bodies in the kinetic energy,
    of force elements in the potential energy and in what is dissipated."""
    needs("linear")
    data = Data(model)
    struct = ffi.new("mbsr_mode *", {name: getattr(mode, name) for name in
                                     ("real", "imaginary", "frequency", "damping")})
    re, im = (np.ascontiguousarray(part) for part in (mode.shape.real, mode.shape.imag))
    outs = np.zeros(model.bodies), np.zeros(model.forces), np.zeros(model.forces)
    _solve(lib.mbsr_mode_participation, model._get(), data._get(), t, given(q, (model.nq,), "q"),
           struct, given(re, (model.nu,), "mode.shape"), given(im, (model.nu,), "mode.shape"),
           *(taken(one, one.shape, "out") for one in outs))
    return outs
