# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion for solvers of your own: residuals F(t, y, y') = 0, consistent starts,
Newton systems, and the explicit right-hand side of the reduced equations."""
from __future__ import annotations

import numpy as np

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, evaluated, fail, given, plain, taken
from .model import Data, Model, _create

_residual = lib.mbsr_dae_residual

FORMS = {"momentum": lib.MBSR_DAE_MOMENTUM, "recursive": lib.MBSR_DAE_RECURSIVE,
         "inverse_dynamics": lib.MBSR_DAE_INVERSE_DYNAMICS, "index1": lib.MBSR_DAE_INDEX1}


def form_of(name: str) -> int:
    """The number of a form of the equations."""
    if name not in FORMS:
        raise ValueError(f"form '{name}': expected one of {', '.join(FORMS)}")
    return FORMS[name]


class Dae(Owner):
    """F(t, y, y') = 0 with y (size) = (q, p, u) in the form "momentum", with the multipliers of
    closures behind; (q, u) in "recursive" and "inverse_dynamics", (q, v) in "index1"."""

    def __init__(self, model: Model, form: str = "momentum"):
        self.form = form_of(form)
        self.data = Data(model)
        self.model = model
        self._model = model._get()
        self._handle = self.data._handle
        self.size = lib.mbsr_dae_size(self._model, self.form)
        if self.size < 0:
            fail(lib.MBSR_ERR_CLOSURES)
        self._shape = (self.size,)
        self._seen: list = [None] * 8

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_data_error(self._get()))

    @property
    def differential(self) -> np.ndarray:
        """Which variables are differential (size, bool); the others are algebraic."""
        out = np.empty(self._shape)
        self._check(lib.mbsr_dae_id(self._model, self._get(), self.form,
                                    taken(out, self._shape, "out")))
        return out != 0.0

    def pack(self, q: np.ndarray, u: np.ndarray, t: float = 0.0) -> np.ndarray:
        """y (size) of a state q (nq), u (nu)."""
        y = np.empty(self._shape)
        self._check(lib.mbsr_dae_pack(
            self._model, self._get(), self.form, t, given(q, (self.model.nq,), "q"),
            given(u, (self.model.nu,), "u"), taken(y, self._shape, "y")))
        return y

    def unpack(self, y: np.ndarray, t: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q (nq) and u (nu) of y."""
        q, u = np.empty(self.model.nq), np.empty(self.model.nu)
        self._check(lib.mbsr_dae_unpack(
            self._model, self._get(), self.form, t, given(y, self._shape, "y"),
            taken(q, q.shape, "q"), taken(u, u.shape, "u")))
        return q, u

    def residual(self, t: float, y: np.ndarray, yp: np.ndarray,
                 out: np.ndarray | None = None) -> np.ndarray:
        """F (size) at t, y, y'."""
        shape = self._shape
        if out is None:
            out = np.empty(shape)
        at_y, at_yp, _, to = evaluated(self._seen, y, shape, yp, shape, None, shape, out, "y yp -")
        status = _residual(self._model, (self._handle or self._get()).pointer, self.form, t, at_y,
                           at_yp, to)
        if status:
            self._check(status)
        return out

    def consistent(self, q: np.ndarray, u: np.ndarray, t: float = 0.0, **options
                   ) -> tuple[np.ndarray, np.ndarray, Record]:
        """Consistent y and y' (size each) near a state, and what was found and changed. options:
        fields of mbsr_consistent_opt."""
        y, yp = self.pack(q, u, t), np.empty(self._shape)
        keep: list = []
        define = _values.options("mbsr_consistent_opt", options, keep, "consistent")
        info = ffi.new("mbsr_consistent_info *")
        self._check(lib.mbsr_dae_consistent(
            self._model, self._get(), self.form, t, taken(y, self._shape, "y"),
            taken(yp, self._shape, "yp"), define, info))
        return y, yp, plain(info)

    def newton(self, **options) -> "Newton":
        """A solver of its Newton systems; options: fields of mbsr_newton_opt."""
        return Newton(self, **options)


class Newton(Owner):
    """Solves (dF/dy + c dF/dy') delta = r of the momentum form along the tree, in O(N)."""

    def __init__(self, dae: Dae, **options):
        define = _values.options("mbsr_newton_opt", options, (keep := []), "newton")
        made = _create("mbsr_newton", lib.mbsr_newton_create, dae._model, dae.form,
                       define)
        self._handle = Handle(made, lib.mbsr_newton_destroy, dae._handle)
        self.dae = dae
        self._shape = (dae.size,)

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_newton_error(self._get()))

    def factor(self, t: float, y: np.ndarray, yp: np.ndarray, c: float) -> "Newton":
        """Linearises at (t, y, y') and eliminates; c = dy'/dy of the integrator's formula, 1/s."""
        self._check(lib.mbsr_newton_factor(self._get(), self.dae._get(), t,
                                           given(y, self._shape, "y"),
                                           given(yp, self._shape, "yp"), c))
        return self

    def solve(self, r: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """delta (size) from r (size); both may be one array."""
        if out is None:
            out = np.empty(self._shape)
        self._check(lib.mbsr_newton_solve(self._get(), given(r, self._shape, "r"),
                                          taken(out, self._shape, "out")))
        return out

    def linearise(self, t: float, y: np.ndarray, yp: np.ndarray, c: float) -> "Newton":
        """Keeps the derivatives at (t, y, y') for `multiply`; asks for products=1."""
        self._check(lib.mbsr_newton_linearise(self._get(), self.dae._get(), t,
                                              given(y, self._shape, "y"),
                                              given(yp, self._shape, "yp"), c))
        return self

    def multiply(self, delta: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """r (size) = (dF/dy + c dF/dy') delta."""
        if out is None:
            out = np.empty(self._shape)
        self._check(lib.mbsr_newton_multiply(self._get(), given(delta, self._shape, "delta"),
                                             taken(out, self._shape, "out")))
        return out

    @property
    def info(self) -> Record:
        """How the systems are solved, and what that has cost."""
        out = ffi.new("mbsr_newton_info *")
        self._check(lib.mbsr_newton_get_info(self._get(), out))
        return plain(out)


class Ode(Owner):
    """The reduced equations x' = f(t, x), x (size) = (q, p), for explicit solvers such as scipy's:
    velocities without mass are found by Newton's method, which dampers determine."""

    def __init__(self, model: Model, q: np.ndarray, u: np.ndarray, t: float = 0.0):
        self.data = Data(model)
        made = ffi.new("mbsr_ode **")
        self.data._check(lib.mbsr_ode_create(
            model._get(), self.data._get(), t, given(q, (model.nq,), "q"),
            given(u, (model.nu,), "u"), made))
        self._handle = Handle(made[0], lib.mbsr_ode_destroy, self.data._handle)
        self.model = model
        self.size = lib.mbsr_ode_size(made[0])

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_data_error(self.data._get()))

    def pack(self, q: np.ndarray, u: np.ndarray, t: float = 0.0) -> np.ndarray:
        """x (size) of a state."""
        x = np.empty(self.size)
        self._check(lib.mbsr_ode_pack(self._get(), t, given(q, (self.model.nq,), "q"),
                                      given(u, (self.model.nu,), "u"), taken(x, x.shape, "x")))
        return x

    def velocities(self, t: float, x: np.ndarray) -> np.ndarray:
        """u (nu) at x."""
        u = np.zeros(self.model.nu)
        self._check(lib.mbsr_ode_velocities(self._get(), t, given(x, (self.size,), "x"),
                                            taken(u, u.shape, "u")))
        return u

    def __call__(self, t: float, x: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """x' (size)."""
        if out is None:
            out = np.empty(self.size)
        self._check(lib.mbsr_ode_rhs(self._get(), t, given(x, (self.size,), "x"),
                                     taken(out, (self.size,), "out")))
        return out
