# SPDX-License-Identifier: BSD-3-Clause
"""Forward and inverse dynamics as functions of CasADi, with their derivatives."""
from __future__ import annotations

from typing import Any

import numpy as np

from .derivatives import Derivatives
from .model import Data, Model


class Slopes:
    """What the functions below compute, with arrays: result(q, u, load) and its derivatives, in q
    itself where quaternions have four numbers for three rates."""

    def __init__(self, model: Model, what: str, t: float):
        if what not in ("forward", "inverse"):
            raise ValueError(f"what '{what}': expected forward or inverse")
        self.sizes, self._t = (model.finish().nq, model.nu, model.nu), t
        self._derivatives, self._data = Derivatives(model), Data(model)
        self._linearise = getattr(self._derivatives, what)
        self._evaluate = getattr(self._data, f"{what}_dynamics")
        pairs = [model.coordinates(body) for body in range(model.bodies)]
        self._turns = [(q, u) for q, u in pairs if q.stop - q.start != u.stop - u.start]
        self._plain = [(q, u) for q, u in pairs if q.stop - q.start == u.stop - u.start]

    def value(self, q: np.ndarray, u: np.ndarray, load: np.ndarray) -> np.ndarray:
        """The result (nu)."""
        return self._evaluate(q, u, load, self._t)

    def _rates(self, q):
        """For each joint with quaternions the rates (n) of changes of its q."""
        found = []
        columns: list[np.ndarray] = []
        for place, rates in self._turns:
            for k in range(len(columns), rates.stop - rates.start):
                unit = np.zeros(self.sizes[1])
                unit[[u.start + k for _, u in self._turns if u.start + k < u.stop]] = 1.0
                columns.append(self._data.coordinate_rates(q, unit, self._t))
            G = np.stack([one[place] for one in columns[:rates.stop - rates.start]], axis=1)
            found.append((place, rates, np.linalg.pinv(G)))
        return found

    def tangent(self, q: np.ndarray, u: np.ndarray, load: np.ndarray, dq: np.ndarray,
                du: np.ndarray, dload: np.ndarray) -> np.ndarray:
        """The change of the result (nu) along dq (nq), du and dload (nu each)."""
        along = np.zeros(self.sizes[1])
        for place, rates in self._plain:
            along[rates] = dq[place]
        for place, rates, inverse in self._rates(q):
            along[rates] = inverse @ dq[place]
        self._linearise(q, u, load, self._t)
        return self._derivatives.tangent(along, du, dload)

    def adjoint(self, q: np.ndarray, u: np.ndarray, load: np.ndarray,
                w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The gradient of w (nu) times the result by q (nq), u and the load (nu each)."""
        turned = self._rates(q)
        self._linearise(q, u, load, self._t)
        by_rates, by_u, by_load = self._derivatives.adjoint(w)
        by_q = np.zeros(self.sizes[0])
        for place, rates in self._plain:
            by_q[place] = by_rates[rates]
        for place, rates, inverse in turned:
            by_q[place] = by_rates[rates] @ inverse
        return by_q, by_u, by_load

    def jacobians(self, q: np.ndarray, u: np.ndarray,
                  load: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of the result by q (nu x nq), u and the load (nu x nu each)."""
        turned = self._rates(q)
        self._linearise(q, u, load, self._t)
        by_rates, by_u, by_load = self._derivatives.jacobians()
        by_q = np.zeros((self.sizes[1], self.sizes[0]))
        for place, rates in self._plain:
            by_q[:, place] = by_rates[:, rates]
        for place, rates, inverse in turned:
            by_q[:, place] = by_rates[:, rates] @ inverse
        return by_q, by_u, by_load


def callback(model: Model, what: str = "forward", name: str | None = None, t: float = 0.0,
             **options) -> Any:
    """A casadi.Callback (q, u, load) -> result: "forward", udot of tau, or "inverse", tau of udot,
    with columns of nq, nu, nu and nu numbers. It has its Jacobian, and tangents and adjoints in
    O(N) a direction. options: those of casadi.Function. Needs CasADi 3.6 or later. Whoever uses it
    in an expression keeps it."""
    import casadi  # type: ignore[import]

    slopes = Slopes(model, what, t)
    in_, out = list(slopes.sizes), [model.nu]
    nominal = [*in_, *out]

    class Numbers(casadi.Callback):
        """A function of columns, computed by one of numpy arrays."""

        def __init__(self, name, inputs, outputs, function, options):
            casadi.Callback.__init__(self)
            self._inputs, self._outputs, self._function = inputs, outputs, function
            self._made = []
            self.construct(name, options)

        def get_n_in(self):
            return len(self._inputs)

        def get_n_out(self):
            return len(self._outputs)

        def get_sparsity_in(self, k):
            return casadi.Sparsity.dense(self._inputs[k], 1)

        def get_sparsity_out(self, k):
            return casadi.Sparsity.dense(*self._outputs[k])

        def eval(self, given):
            found = self._function(*(np.array(one, dtype="f8").reshape(-1) for one in given))
            found = found if isinstance(found, tuple) else (found,)
            return [casadi.DM(one.reshape(shape)) for one, shape in zip(found, self._outputs)]

        def _make(self, *definition):
            self._made.append(Numbers(*definition))  # CasADi does not keep it
            return self._made[-1]

    class Dynamics(Numbers):
        """The same with its derivatives; CasADi gives these the result too."""

        def has_jacobian(self):
            return True

        def get_jacobian(self, name, inames, onames, options):
            return self._make(name, nominal, [(model.nu, size) for size in in_],
                              lambda q, u, load, _: slopes.jacobians(q, u, load), options)

        def has_forward(self, count):
            return count == 1

        def get_forward(self, count, name, inames, onames, options):
            return self._make(name, nominal + in_, [(model.nu, 1)],
                              lambda q, u, load, _, *along: slopes.tangent(q, u, load, *along),
                              options)

        def has_reverse(self, count):
            return count == 1

        def get_reverse(self, count, name, inames, onames, options):
            return self._make(name, nominal + out, [(size, 1) for size in in_],
                              lambda q, u, load, _, w: slopes.adjoint(q, u, load, w), options)

    return Dynamics(name or f"{what}_dynamics", in_, [(model.nu, 1)], slopes.value, options)
