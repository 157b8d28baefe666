# SPDX-License-Identifier: BSD-3-Clause
"""Reports on small masses: which of them may be zero, and what error that makes."""
from __future__ import annotations

from typing import Iterator

import numpy as np

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, fail, given, plain, text
from .model import Model, _create


class SmallMasses(Owner):
    """Looks at the small masses of a model at a state (t, q, u), for a run of `duration` s: what a
    zero in the place of each would do. Iterating gives a record for each; printed it is the table
    of the library.

    options: fields of mbsr_small_masses_opt, such as tolerance, ratio, time_scale."""

    def __init__(self, model: Model, q: np.ndarray, u: np.ndarray, duration: float, t: float = 0.0,
                 **options):
        model.finish()
        define = _values.options("mbsr_small_masses_opt", {"duration": duration, **options},
                                 (keep := []), "SmallMasses")
        made = _create("mbsr_small_masses", lib.mbsr_small_masses_create, model._get(),
                       define)
        self._handle = Handle(made, lib.mbsr_small_masses_destroy, model._handle)
        self._names = [name or f"body {k}" for k, name in enumerate(model.body_names)]
        self._check(lib.mbsr_small_masses_start(made, t, given(q, (model.nq,), "q"),
                                                given(u, (model.nu,), "u")))
        self._read()

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_small_masses_error(self._get()))

    def _read(self) -> None:
        report = ffi.new("mbsr_small_masses_report *")
        self._check(lib.mbsr_small_masses_get_report(self._get(), report))
        self.summary = plain(report, skip=("masses", "directions"))
        self.masses = [plain(ffi.addressof(report.mass[k])) for k in range(report.masses)]
        for one in self.masses:
            verdict = text(lib.mbsr_small_verdict_text(one.verdict))
            vars(one).update(name=self._names[one.body], verdict=verdict)

    def run(self, t_end: float) -> "SmallMasses":
        """Integrates the model without these masses to t_end and takes every step into the
        report."""
        error = ffi.new("mbsr_error *")
        status = lib.mbsr_small_masses_run(self._get(), ffi.NULL, t_end, ffi.NULL, error)
        if status:
            fail(status, error)
        self._read()
        return self

    def __iter__(self) -> Iterator[Record]:
        return iter(self.masses)

    def __len__(self) -> int:
        return len(self.masses)

    def __str__(self):
        return self.summary.text

    __repr__ = __str__
