# SPDX-License-Identifier: BSD-3-Clause
"""Functional Mock-up Units (component fmu)."""
from __future__ import annotations

import os
from pathlib import Path

from . import _values
from ._c import ffi, lib
from ._core import fail, needs, text
from .files import File
from .model import Model


def export_fmu(model: Model, path: str | os.PathLike, file: File | None = None,
               **options) -> str:
    """Writes an FMU of a model to a path; file: what it was read from, for names of joints, sites
    and actuators. options: fields of mbsr_fmu_opt, such as version, kinds, fixed_step, sources.
    Returns why it offers no model exchange, "" where it does or was not asked to."""
    needs("fmu")
    keep: list = []
    model.finish()
    define = _values.options("mbsr_fmu_opt", options, keep, "export_fmu")
    if file is not None:
        define.file = file._get()
    error, made = ffi.new("mbsr_error *"), ffi.new("mbsr_fmu **")
    status = lib.mbsr_fmu_export(model._get(), define, made, error)
    if status:
        fail(status, error)
    try:
        Path(path).write_bytes(bytes(ffi.buffer(made[0].data, made[0].size)))
        return text(made[0].text)
    finally:
        lib.mbsr_fmu_destroy(made[0])
