# SPDX-License-Identifier: BSD-3-Clause
"""Inertias of bodies: any symmetric positive semi-definite mass matrix; zero means zero. kg, m, kg
m^2; tensors are (xx, yy, zz, xy, xz, yz) about the centre of mass."""
from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _values
from ._c import ffi, lib
from ._values import Inertia

globals().update(_values.constructors("mbsr_inertia"))


def matrix(M: ArrayLike) -> Inertia:
    """A constant mass matrix M (d x d), symmetric and positive semi-definite, conjugate to the
    body's velocity."""
    values = np.ascontiguousarray(M, dtype="f8")
    if values.ndim != 2 or values.shape[0] != values.shape[1]:
        raise ValueError(f"M: expected a square matrix, got shape {values.shape}")
    given = ffi.new("double[]", values.reshape(-1).tolist())
    return Inertia(lib.mbsr_inertia_matrix(len(values), given), [given])


__all__ = sorted(_values.constructors("mbsr_inertia"))
