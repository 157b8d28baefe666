# SPDX-License-Identifier: BSD-3-Clause
"""Joints: what a body may do relative to its predecessor. Frames A stand in the predecessor,
frames B in the body (None: its own); directions have any length but zero; m and rad. Functions of
time may be tables."""
from __future__ import annotations

from typing import Any, Callable, Mapping, Sequence


from . import _values
from ._c import ffi, lib
from ._values import FrameLike, Joint, Table

globals().update(_values.constructors("mbsr_joint"))

#: Coordinates of joints in the plane.
X, Y, ANGLE = lib.MBSR_X, lib.MBSR_Y, lib.MBSR_ANGLE


def compound(A: FrameLike = None, B: FrameLike = None, axes: Sequence[Mapping[str, Any]] = (),
             motion: Callable[[float], Any] | Table | None = None) -> Joint:
    """Several axes in one body, up to 6: from A, each moves what follows it.

    axes: mappings with kind ("rotation", "translation", "screw"), direction (3), pitch (m/rad) and
    driven (True: it follows `motion`, a function of t that returns values, first and second
    derivatives)."""
    keep: list = []
    given = ffi.new("mbsr_axis[]", max(len(axes), 1))
    for to, one in zip(given, axes):
        fields = dict(one)
        to.kind = getattr(lib, f"MBSR_AXIS_{fields.pop('kind').upper()}")
        to.driven = int(fields.pop("driven", False))
        _values.fill(ffi.addressof(to), fields, keep, "axes")
    function, user = _values.callback("mbsr_motion_fn", motion, keep)
    frames = [_values.to_c("const mbsr_frame *", name, frame, keep)
              for name, frame in (("A", A), ("B", B))]
    return Joint(lib.mbsr_joint_compound(*frames, len(axes), given, function, user), keep)


__all__ = sorted([*_values.constructors("mbsr_joint"), "X", "Y", "ANGLE"])
