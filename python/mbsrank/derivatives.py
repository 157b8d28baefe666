# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of forward and inverse dynamics, for optimisation and control."""
from __future__ import annotations

import numpy as np

from ._c import ffi, lib
from ._core import Handle, Owner, fail, given, taken
from .model import Model, _create


class Derivatives(Owner):
    """Forward dynamics udot(q, u, tau) or inverse dynamics tau(q, u, udot), linearised at a state,
    in O(N). Directions in q are joint rates (nu): where q' = u, changes of q itself; along a
    quaternion three rates."""

    def __init__(self, model: Model):
        model.finish()
        made = _create("mbsr_derivatives", lib.mbsr_derivatives_create, model._get())
        self._handle = Handle(made, lib.mbsr_derivatives_destroy, model._handle)
        self._nq, self._nu = (model.nq,), (model.nu,)

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_derivatives_error(self._get()))

    def forward(self, q: np.ndarray, u: np.ndarray, tau: np.ndarray | None = None,
                t: float = 0.0) -> np.ndarray:
        """Linearises forward dynamics and returns udot (nu)."""
        out = np.empty(self._nu)
        self._check(lib.mbsr_derivatives_forward(
            self._get(), t, given(q, self._nq, "q"), given(u, self._nu, "u"),
            ffi.NULL if tau is None else given(tau, self._nu, "tau"), taken(out, self._nu, "out"),
            ffi.NULL))
        return out

    def inverse(self, q: np.ndarray, u: np.ndarray, udot: np.ndarray, t: float = 0.0) -> np.ndarray:
        """Linearises inverse dynamics and returns tau (nu)."""
        out = np.empty(self._nu)
        self._check(lib.mbsr_derivatives_inverse(
            self._get(), t, given(q, self._nq, "q"), given(u, self._nu, "u"),
            given(udot, self._nu, "udot"), taken(out, self._nu, "out")))
        return out

    def tangent(self, dq: np.ndarray | None = None, du: np.ndarray | None = None,
                dload: np.ndarray | None = None) -> np.ndarray:
        """The change of the result (nu) along changes of q, u and of the load (tau, or udot), nu
        each; None: zero."""
        out = np.empty(self._nu)
        three = [ffi.NULL if one is None else given(one, self._nu, name)
                 for one, name in ((dq, "dq"), (du, "du"), (dload, "dload"))]
        self._check(lib.mbsr_derivatives_tangent(self._get(), *three, taken(out, self._nu, "out"),
                                                 ffi.NULL))
        return out

    def adjoint(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The gradient of w (nu) times the result by q, u and the load, nu each."""
        three = np.empty(self._nu), np.empty(self._nu), np.empty(self._nu)
        self._check(lib.mbsr_derivatives_adjoint(
            self._get(), given(w, self._nu, "w"), ffi.NULL,
            *(taken(one, self._nu, "out") for one in three)))
        return three

    def jacobians(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The Jacobians of the result by q, u and the load (nu x nu each)."""
        three = [np.empty(self._nu * 2) for _ in range(3)]
        self._check(lib.mbsr_derivatives_matrices(
            self._get(), *(taken(one, self._nu * 2, "out") for one in three)))
        by_q, by_u, by_load = (one.T for one in three)
        return by_q, by_u, by_load
