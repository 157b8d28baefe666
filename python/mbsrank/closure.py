# SPDX-License-Identifier: BSD-3-Clause
"""Closures of loops: what holds two bodies together that the tree does not connect."""
from __future__ import annotations

from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _values
from ._c import ffi, lib
from ._values import Closure

globals().update(_values.constructors("mbsr_closure_def"))


def coupling(body: Sequence[int], coordinate: Sequence[int], coefficient: Sequence[float],
             offset: float = 0.0) -> Closure:
    """Sum of coefficient[k] q[coordinate[k]] of body[k] = offset, for up to 8 joint coordinates:
    gears, rack and pinion, mimicking joints."""
    if not len(body) == len(coordinate) == len(coefficient):
        raise ValueError("coupling: body, coordinate and coefficient have different lengths")
    given = (ffi.new("int[]", list(body)), ffi.new("int[]", list(coordinate)),
             ffi.new("double[]", list(coefficient)))
    return Closure(lib.mbsr_closure_coupling(len(body), *given, offset), given)


def _directions(make, a, point_a, b, point_b, directions) -> Closure:
    rows = np.atleast_2d(np.ascontiguousarray(directions, dtype="f8"))
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise ValueError(f"directions: expected shape (k, 3), got {rows.shape}")
    keep: list = []
    points = [_values.to_c("const double[3]", name, point, keep)
              for name, point in (("point_a", point_a), ("point_b", point_b))]
    given = ffi.new("double[]", rows.reshape(-1).tolist())
    return Closure(make(a, points[0], b, points[1], len(rows), given), [*keep, given])


def rows(a: int, point_a: ArrayLike | None, b: int, point_b: ArrayLike | None,
         directions: ArrayLike) -> Closure:
    """The vector from point b to point a has no component along `directions` (k x 3), fixed in the
    root: a point in a plane or on a line."""
    return _directions(lib.mbsr_closure_rows, a, point_a, b, point_b, directions)


def body_rows(a: int, point_a: ArrayLike | None, b: int, point_b: ArrayLike | None,
              directions: ArrayLike) -> Closure:
    """The same with directions (k x 3) that are fixed in body b: a point in a slot or on a face of
    it."""
    return _directions(lib.mbsr_closure_body_rows, a, point_a, b, point_b, directions)


__all__ = sorted(_values.constructors("mbsr_closure_def"))
