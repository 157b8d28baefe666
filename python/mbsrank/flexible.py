# SPDX-License-Identifier: BSD-3-Clause
"""Flexible bodies: modal data of beams, of finite elements and of SID files (component fe)."""
from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, encoded, fail, needs, plain

_NULL = ffi.NULL


def _matrix(M: Any, name: str, keep: list):
    """A symmetric matrix of scipy.sparse, or what numpy makes of it."""
    given = M.tocoo() if hasattr(M, "tocoo") else None
    if given is None:
        dense = np.asarray(M, dtype="f8")
        if dense.ndim != 2 or dense.shape[0] != dense.shape[1]:
            raise ValueError(f"{name}: expected a square matrix, got shape {dense.shape}")
        row, column = np.nonzero(dense)
        size, value = len(dense), dense[row, column]
    else:
        if given.shape[0] != given.shape[1]:
            raise ValueError(f"{name}: expected a square matrix, got shape {given.shape}")
        row, column, size, value = given.row, given.col, given.shape[0], given.data
    arrays = [np.ascontiguousarray(row, dtype="i4"), np.ascontiguousarray(column, dtype="i4"),
              np.ascontiguousarray(value, dtype="f8")]
    keep.extend(arrays)
    return {"rows": size, "entries": len(arrays[2]), "start": _NULL, "whole": 1,
            "row": ffi.from_buffer("int[]", arrays[0]),
            "column": ffi.from_buffer("int[]", arrays[1]),
            "value": ffi.from_buffer("double[]", arrays[2])}


def _markers(markers: Mapping[str, int | Sequence[int]], loaded: Sequence[str], keep: list):
    made = ffi.new("mbsr_fe_marker[]", len(markers))
    for unknown in set(loaded) - set(markers):
        raise ValueError(f"loaded: there is no marker '{unknown}'")
    for to, (name, nodes) in zip(made, markers.items()):
        ids = ffi.new("int[]", np.atleast_1d(nodes).tolist())
        keep.extend((ids, ffi.new("char[]", encoded(name, "markers"))))
        to.name, to.node, to.nodes, to.loaded = keep[-1], ids, len(ids), name in loaded
    keep.append(made)
    return made


class Flex(Owner):
    """Modal data of a flexible body, for Model.add_flexible. `report` tells of what was reduced or
    read; None for beams."""

    report: Record | None = None

    @classmethod
    def _made(cls, status: int, made, error, report=None, destroy=None) -> "Flex":
        if status:
            fail(status, error)
        flex = cls.__new__(cls)
        flex._handle = Handle(made[0], lib.mbsr_flex_destroy)
        if report is not None:
            flex.report = plain(report[0])
            destroy(report[0])
        return flex

    @classmethod
    def beam(cls, **fields) -> "Flex":
        """A straight uniform beam along x, held at x = 0. fields: of mbsr_beam_def, such as length
        (m), density (kg/m), EA, EI_y, EI_z, GJ, modes, loaded and node, damping."""
        keep: list = []
        define = _values.options("mbsr_beam_def", fields, keep, "beam")
        error, made = ffi.new("mbsr_error *"), ffi.new("mbsr_flex **")
        return cls._made(lib.mbsr_flex_beam(define, made, error), made, error)

    @classmethod
    def elements(cls, K: Any, M: Any, nodes: ArrayLike,
                 markers: Mapping[str, int | Sequence[int]], loaded: Sequence[str] = (),
                 D: Any = None, **fields) -> "Flex":
        """From finite elements: symmetric stiffness K (n x n, N/m), mass M (kg) and damping D of
        scipy.sparse or numpy, nodes (count x 3, m). markers: a node or several, averaged, by name,
        the root first; those named in loaded get static modes. fields: others of mbsr_fe_def, such
        as modes, frequency, cutoff, damping, id, dof_node, dof_direction."""
        needs("fe")
        keep: list = []
        define = _values.options("mbsr_fe_def", {}, keep, "elements")
        places = np.ascontiguousarray(nodes, dtype="f8")
        if places.ndim != 2 or places.shape[1] != 3:
            raise ValueError(f"nodes: expected count x 3 numbers, got shape {places.shape}")
        for name, one in (("K", K), ("M", M), ("D", D)):
            if one is not None:
                setattr(define, name, _matrix(one, name, keep))
        define.nodes, define.x = len(places), ffi.from_buffer("double[]", places)
        define.markers, define.marker = len(markers), _markers(markers, loaded, keep)
        _values.fill(define, fields, keep, "elements")
        return cls._reduced(define)

    @classmethod
    def _reduced(cls, define) -> "Flex":
        error, made = ffi.new("mbsr_error *"), ffi.new("mbsr_flex **")
        report = ffi.new("mbsr_fe_report **")
        status = lib.mbsr_fe_reduce(define, made, report, error)
        return cls._made(status, made, error, report, lib.mbsr_fe_report_destroy)

    @classmethod
    def files(cls, K: str | os.PathLike, M: str | os.PathLike, nodes: str | os.PathLike,
              markers: str | os.PathLike, D: str | os.PathLike | None = None,
              dofs: str | os.PathLike | None = None, **fields) -> "Flex":
        """The same from files: K, M, D in Matrix Market's format, nodes, dofs and markers as
        mbsrank/fe.h has them; all markers but the root are loaded."""
        needs("fe")
        keep: list = []
        given = ffi.new("mbsr_fe_files *")
        paths = {"K": K, "M": M, "D": D, "nodes": nodes, "dofs": dofs, "markers": markers}
        for name, path in paths.items():
            if path is None:
                continue
            content = Path(path).read_bytes()
            keep.extend((ffi.new("char[]", content), ffi.new("char[]", encoded(str(path), name))))
            to = getattr(given, name)
            to.text, to.size, to.name = keep[-2], len(content), keep[-1]
        error, made = ffi.new("mbsr_error *"), ffi.new("mbsr_fe_input **")
        status = lib.mbsr_fe_read(given, _NULL, made, error)
        if status:
            fail(status, error)
        try:
            define = ffi.addressof(made[0][0], "def")
            _values.fill(define, fields, keep, "files")
            return cls._reduced(define)
        finally:
            lib.mbsr_fe_input_destroy(made[0])

    @classmethod
    def sid(cls, path: str | os.PathLike, **fields) -> "Flex":
        """From a SID_FEM file, as other programs of multibody dynamics read it. fields: of
        mbsr_sid_opt. Markers are its nodes."""
        needs("fe")
        keep: list = []
        define = _values.options("mbsr_sid_opt", fields, keep, "sid")
        content = Path(path).read_bytes()
        error, made = ffi.new("mbsr_error *"), ffi.new("mbsr_flex **")
        report = ffi.new("mbsr_sid_report **")
        status = lib.mbsr_sid_read(content, len(content), encoded(str(path), "path"),
                                   define, made, report, error)
        return cls._made(status, made, error, report, lib.mbsr_sid_report_destroy)

    def _data(self):
        struct = ffi.new("mbsr_flex_def *")
        status = lib.mbsr_flex_definition(self._get(), struct)
        if status:
            fail(status)
        return struct

    @property
    def modes(self) -> int:
        """How many modes there are."""
        return self._data().modes

    @property
    def markers(self) -> int:
        """How many markers there are."""
        return self._data().markers

    def mass_matrix(self, s: ArrayLike) -> np.ndarray:
        """M(s), (6 + modes) x (6 + modes), along the body's axes; s (modes)."""
        size = 6 + self.modes
        from_s = np.ascontiguousarray(s, dtype="f8").reshape(-1)
        if from_s.size != size - 6:
            raise ValueError(f"s: expected {size - 6} numbers, got {from_s.size}")
        out = np.empty((size, size))
        status = lib.mbsr_flex_mass_matrix(self._get(), ffi.from_buffer("double[]", from_s),
                                           ffi.from_buffer("double[]", out))
        if status:
            fail(status)
        return out

    def __repr__(self):
        if self.closed:
            return "<Flex, closed>"
        return f"<Flex: {self.modes} modes, {self.markers} markers>"
