# SPDX-License-Identifier: BSD-3-Clause
"""The numbers of a model by name, and models in which some of them are others."""
from __future__ import annotations

from typing import Iterator, Mapping

from ._c import ffi, lib
from ._core import Handle, Owner, Record, encoded, plain
from .model import Data, Model, _create


class Parameters(Owner):
    """The parameters of a model as it is now, such as "bodies.rod.mass" and
    "forces.tip.stiffness". Iterating gives a record (name, unit, description, value, ...) for
    each; `parameters[name]` is a value."""

    def __init__(self, model: Model):
        model.finish()
        made = _create("mbsr_parameters", lib.mbsr_parameters_create, model._get())
        self._handle = Handle(made, lib.mbsr_parameters_destroy, model._handle)

    def find(self, name: str) -> int:
        """The number of a parameter; KeyError: there is none of that name."""
        found = lib.mbsr_parameters_find(self._get(), encoded(name, "name"))
        if found < 0:
            raise KeyError(f"there is no parameter '{name}'")
        return found

    def record(self, parameter: int) -> Record:
        """What is known of a parameter, by its number."""
        to = ffi.new("mbsr_parameter *")
        status = lib.mbsr_parameter_get(self._get(), parameter, to)
        if status:
            raise IndexError(f"there is no parameter {parameter}")
        return plain(to)

    def __len__(self) -> int:
        return lib.mbsr_parameters_count(self._get())

    def __iter__(self) -> Iterator[Record]:
        return (self.record(k) for k in range(len(self)))

    def __contains__(self, name: str) -> bool:
        return lib.mbsr_parameters_find(self._get(), encoded(name, "name")) >= 0

    def __getitem__(self, name: str) -> float:
        return self.record(self.find(name)).value

    def _chosen(self, values: Mapping[str, float]):
        which = ffi.new("int[]", [self.find(name) for name in values])
        return len(values), which, ffi.new("double[]", [float(x) for x in values.values()])

    def model(self, values: Mapping[str, float]) -> Model:
        """A finished model with these values by name; ids and places in q and u are the same."""
        made = _create("mbsr_model", lib.mbsr_parameters_model, self._get(), *self._chosen(values))
        return Model._of(made, self._handle)._is_finished()

    def data(self, values: Mapping[str, float]) -> Data:
        """Data of such a model."""
        return Data(self.model(values))

    def __repr__(self):
        return "<Parameters, closed>" if self.closed else f"<Parameters: {len(self)} of a model>"
