# SPDX-License-Identifier: BSD-3-Clause
"""Shapes that find each other (component contact)."""
from __future__ import annotations

from typing import Mapping

import numpy as np
from numpy.typing import ArrayLike

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, fail, given, needs, plain
from ._values import Force, FrameLike
from .files import File
from .model import GROUND, Data, Model, _create


class Contacts(Owner):
    """All shapes of a model. They become one force element, `force`, which acts where two of them
    touch:

        contacts = Contacts()
        contacts.add("plane", law={"stiffness": 1e5})
        contacts.add("sphere", 0.1, ball, law={"stiffness": 1e5})
        id = model.add_force(contacts.force())
        Contacts.report(data, id)
    """

    def __init__(self):
        needs("contact")
        made = _create("mbsr_contacts", lib.mbsr_contacts_create)
        self._handle = Handle(made, lib.mbsr_contacts_destroy)

    def _call(self, function, *arguments):
        error = ffi.new("mbsr_error *")
        status = function(self._get(), *arguments, error)
        if status:
            fail(status, error)

    def add(self, kind: str, size: ArrayLike = (), body: int = GROUND, frame: FrameLike = None,
            law: Mapping[str, float] | None = None, **fields) -> int:
        """Adds a shape to a body and returns its id. kind: "box", "sphere", "cylinder", "capsule",
        "ellipsoid", "plane" or "mesh"; size (m) as spatial.h has it; law: numbers of
        mbsr_contact_law; fields: others of mbsr_shape."""
        keep: list = []
        define = _values._box("mbsr_shape", lib.mbsr_default_shape())
        shape = ffi.addressof(define)
        define.kind = _values._choice("SHAPE", kind)
        given = {"frame": frame, "law": law}
        _values.fill(shape, {"size": size, "body": body, **fields,
                             **{name: one for name, one in given.items() if one is not None}},
                     keep, "add")
        made = ffi.new("int *")
        self._call(lib.mbsr_contacts_add, shape, made)
        return made[0]

    def add_file(self, file: File, stiffness: float = 0.0) -> Record:
        """Adds the shapes for contact of a file, whose model is finished; tells how many were
        added and left out, and their stiffness (N/m; 0: by the masses)."""
        told = ffi.new("mbsr_contacts_of_file *")
        self._call(lib.mbsr_contacts_add_file, file._get(), file.model._get(), stiffness, told)
        return plain(told)

    def exclude(self, body_a: int, body_b: int) -> None:
        """Shapes of these two bodies never touch."""
        self._call(lib.mbsr_contacts_exclude, body_a, body_b)

    def pair(self, shape_a: int, shape_b: int, law: Mapping[str, float] | None = None) -> None:
        """Two shapes touch by a law of their own, or (None) never."""
        one = ffi.NULL
        if law is not None:
            one = ffi.new("mbsr_contact_law *", lib.mbsr_default_shape().law)
            _values.fill(one, law, [], "pair")
        self._call(lib.mbsr_contacts_pair, shape_a, shape_b, one)

    def force(self, max_pairs: int = 0) -> Force:
        """The element of all shapes, to be added to a model; no shape can be added then."""
        define = ffi.new("mbsr_force_def *")
        self._call(lib.mbsr_contacts_force, max_pairs, define)
        return Force(define[0], [self._handle])

    @staticmethod
    def report(data: Data, force: int) -> list[Record]:
        """The points at which shapes touch, at a state of the data at which velocities are known:
        place, normal, depth, forces."""
        needs("contact")
        model, count = data.model._get(), ffi.new("int *")
        data._check(lib.mbsr_contact_report(model, data._get(), force, 0, ffi.NULL, count))
        points = ffi.new("mbsr_contact_point[]", max(1, count[0]))
        data._check(lib.mbsr_contact_report(model, data._get(), force, count[0], points, count))
        return [plain(points + k) for k in range(count[0])]


def touching(file: File, stiffness: float = 0.0, q: ArrayLike | None = None) -> tuple[Model, int]:
    """A copy of the model of a file whose shapes for contact touch as in runs of the program, and
    the id of the element; -1 where there are no such shapes. What is drawn into each other at q
    (None: as the file is drawn) never touches."""
    needs("contact")
    file.model.finish()
    made, error = ffi.new("mbsr_touching *"), ffi.new("mbsr_error *")
    start = given(file.q0 if q is None else np.asarray(q, dtype="f8"), (file.model.nq,), "q")
    status = lib.mbsr_contacts_attach(file._get(), ffi.NULL, file.model._get(), start, stiffness,
                                      made, error)
    if status:
        fail(status, error)
    if not made.model:
        return file.model.copy().finish(), -1
    contacts = Handle(made.contacts, lib.mbsr_contacts_destroy)
    return Model._of(made.model, contacts, file.model._handle)._is_finished(), made.force
