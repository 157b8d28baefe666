# SPDX-License-Identifier: BSD-3-Clause
"""Force elements. Points and directions stand in the axes of their bodies, m (None: the origin);
laws of several numbers are mappings with the fields of their struct. Functions of time take t and
return numbers; they may be tables."""
from __future__ import annotations

from typing import Callable, Sequence

from . import _values
from ._c import ffi, lib
from ._core import ForceBody
from ._values import Force

globals().update(_values.constructors("mbsr_force_def"))


def custom(evaluate: Callable[[float, Sequence[ForceBody]], None], bodies: Sequence[int],
           energy: Callable[[float, Sequence[ForceBody]], float] | None = None,
           name: str = "force of Python") -> Force:
    """An element of your own: evaluate(t, bodies) adds to f and tau of the bodies (see ForceBody);
    energy(t, bodies) returns the potential energy in J, at velocities that are not there."""
    called = ffi.new("char[]", name.encode())
    table = ffi.new("mbsr_force_table *", {"version": lib.MBSR_FORCE_TABLE_VERSION, "name": called})
    table.evaluate = lib.mbsrank_force_evaluate
    if energy is not None:
        table.energy = lib.mbsrank_force_energy
    handle = ffi.new_handle((evaluate, energy))
    ids = ffi.new("int[]", list(bodies))
    element = lib.mbsr_force_custom(table, len(bodies), ids, handle)
    return Force(element, [called, table, handle, ids, evaluate, energy])


__all__ = sorted([*_values.constructors("mbsr_force_def"), "custom"])
