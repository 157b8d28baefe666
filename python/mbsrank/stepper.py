# SPDX-License-Identifier: BSD-3-Clause
"""Steps of fixed size and bounded work, for simulators, games and learning."""
from __future__ import annotations

import numpy as np

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, fail, given, plain, view
from .model import Data, Model, _create


class Stepper(Owner):
    """Steps of h s from a consistent state near q (nq; None: all coordinates zero) and u (nu;
    None: at rest). `q` and `u` are views that follow the steps. options: fields of
    mbsr_stepper_opt."""

    def __init__(self, model: Model, q: np.ndarray | None = None, u: np.ndarray | None = None,
                 t: float = 0.0, h: float = 1e-3, **options):
        self.data, self.model = Data(model), model
        define = _values.options("mbsr_stepper_opt", {"h": h, **options}, (keep := []),
                                 "Stepper")
        made = _create("mbsr_stepper", lib.mbsr_stepper_create, model._get(), self.data._get(),
                       define)
        self._handle = Handle(made, lib.mbsr_stepper_destroy, self.data._handle)
        self._state = ffi.new("double[]", 1 + model.nq + model.nu)
        self.restart(q, u, t)

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_stepper_error(self._get()))

    def _read(self, status: int) -> None:
        self._check(status)
        t = self._state
        self._check(lib.mbsr_stepper_motion(self._get(), t, t + 1, t + 1 + self.model.nq))

    def restart(self, q: np.ndarray | None = None, u: np.ndarray | None = None,
                t: float = 0.0) -> "Stepper":
        """Begins again from another state."""
        q = self.model.start() if q is None else q
        u = np.zeros(self.model.nu) if u is None else u
        self._read(lib.mbsr_stepper_start(self._get(), t, given(q, (self.model.nq,), "q"),
                                          given(u, (self.model.nu,), "u")))
        return self

    def step(self) -> "Stepper":
        """One step of h; where it fails the state is as it was before."""
        self._read(lib.mbsr_stepper_step(self._get()))
        return self

    def to(self, t: float) -> "Stepper":
        """Steps to a time."""
        self._read(lib.mbsr_stepper_to(self._get(), t))
        return self

    @property
    def t(self) -> float:
        """Time, s."""
        self._get()
        return self._state[0]

    @property
    def q(self) -> np.ndarray:
        """Joint position coordinates (nq)."""
        self._get()
        return view(self._state, self._state + 1, (self.model.nq,))

    @property
    def u(self) -> np.ndarray:
        """Joint rates (nu)."""
        self._get()
        return view(self._state, self._state + 1 + self.model.nq, (self.model.nu,))

    @property
    def info(self) -> Record:
        """The work of the last step, the most so far, and the bound."""
        out = ffi.new("mbsr_stepper_info *")
        self._check(lib.mbsr_stepper_get_info(self._get(), out))
        return plain(out)
