# SPDX-License-Identifier: BSD-3-Clause
"""How the motion of a run changes with parameters of its model."""
from __future__ import annotations

from typing import Iterable, Sequence

import numpy as np

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, fail, given, taken
from .model import Model, _create
from .parameters import Parameters


class Sensitivity(Owner):
    """Derivatives of a run in the parameters of these names, such as "bodies.rod.mass": forward for
    each, or of one number in all of them at once. options: fields of mbsr_ida_opt, such as rtol
    and atol. Values are those of the model; for others `Parameters.model` makes one."""

    def __init__(self, model: Model, parameters: Sequence[str], **options):
        if isinstance(parameters, str):
            raise TypeError("parameters: expected names, got one text")
        model.finish()
        listed, keep = Parameters(model), []
        self.parameters = tuple(parameters)
        which = [listed.find(name) for name in self.parameters]
        define = _values.options("mbsr_sensitivity_opt",
                                 {"ida": options, "parameters": len(which), "which": which,
                                  "list": listed._get()}, keep, "Sensitivity")
        made = _create("mbsr_sensitivity", lib.mbsr_sensitivity_create, model._get(), define)
        self._handle = Handle(made, lib.mbsr_sensitivity_destroy, model._handle, *keep)
        self._sizes, self._times = (model.nq, model.nu), 0

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_sensitivity_error(self._get()))

    def run(self, times: Iterable[float], q: np.ndarray | None = None, u: np.ndarray | None = None,
            t: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Runs from a consistent state near q (nq; None: all coordinates zero) and u (nu; None: at
        rest) at time t; returns q (times x nq) and u (times x nu) at these times, which increase.
        Its steps are kept for the derivatives."""
        at = np.fromiter(times, dtype="f8")
        outs = [np.empty((at.size, size)) for size in self._sizes]
        first = [ffi.NULL if one is None else given(one, (size,), name)
                 for one, size, name in zip((q, u), self._sizes, "qu")]
        self._times = 0
        self._check(lib.mbsr_sensitivity_run(self._get(), t, *first, at.size,
                                             given(at, at.shape, "times"),
                                             *(taken(one, one.shape, "out") for one in outs)))
        self._times = at.size
        return outs[0], outs[1]

    def forward(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of q (parameters x times x nq) and of u (parameters x times x nu), where q
        and u of the start are held."""
        outs = [np.empty((len(self.parameters), self._times, size)) for size in self._sizes]
        self._check(lib.mbsr_sensitivity_forward(
            self._get(), *(taken(one, one.shape, "out") for one in outs)))
        return outs[0], outs[1]

    def adjoint(self, w_q: np.ndarray | None = None, w_u: np.ndarray | None = None) -> np.ndarray:
        """The gradient (parameters) of a function of these states, whose derivatives in them are
        w_q (times x nq) and w_u (times x nu); None: zero. It costs the same for any number of
        parameters."""
        out = np.empty(len(self.parameters))
        weights = [ffi.NULL if one is None else given(one, (self._times, size), name)
                   for one, size, name in zip((w_q, w_u), self._sizes, ("w_q", "w_u"))]
        self._check(lib.mbsr_sensitivity_adjoint(self._get(), *weights,
                                                 taken(out, out.shape, "out")))
        return out

    @property
    def steps(self) -> int:
        """Steps of the run that are kept."""
        return lib.mbsr_sensitivity_steps(self._get())

    def __repr__(self):
        return "<Sensitivity, closed>" if self.closed else f"<Sensitivity: {self.parameters}>"
