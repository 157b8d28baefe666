# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of runs in parameters, and of dynamics in CasADi: against closed forms and
differences."""
import sys
import types
import unittest

import numpy as np

import mbsrank as mb
from common import Y, chain, pendulum, start

try:
    import casadi
except ImportError:
    casadi = None


class Sensitivity(unittest.TestCase):
    def swing(self):
        model = mb.Model()
        model.add_body("load", mb.joint.prismatic(axis=(1, 0, 0)), mb.inertia.point_mass(2.0))
        model.add_force(mb.force.joint_spring(0, 0, 8.0, 0.0, 0.0), name="spring")
        return model

    def test_an_oscillator_has_its_closed_form(self):
        # x = cos(w t), w^2 = k / m: dx = -t sin(w t) dw, dw = w / 2 (dk / k - dm / m)
        names = ["forces.spring.stiffness", "bodies.load.mass"]
        runs = mb.Sensitivity(self.swing(), names, rtol=1e-8, atol=1e-8)
        times = np.linspace(0.5, 2.0, 4)
        q, u = runs.run(times, np.ones(1))
        self.assertTrue(np.allclose(q[:, 0], np.cos(2 * times), atol=1e-6))
        dq, du = runs.forward()
        self.assertEqual((dq.shape, du.shape), ((2, 4, 1), (2, 4, 1)))
        for by_x, by_v, dw in zip(dq, du, (1 / 8.0, -1 / 2.0)):
            s, c = np.sin(2 * times), np.cos(2 * times)
            self.assertTrue(np.allclose(by_x[:, 0], -times * s * dw, atol=1e-5))
            self.assertTrue(np.allclose(by_v[:, 0], -(s + 2 * times * c) * dw, atol=1e-5))
        w = np.random.default_rng(3).standard_normal((2, 4, 1))
        by = runs.adjoint(*w)
        together = [np.sum(w[0] * x) + np.sum(w[1] * v) for x, v in zip(dq, du)]
        self.assertTrue(np.allclose(by, together, rtol=1e-10))
        self.assertTrue(np.array_equal(runs.adjoint(None, np.zeros((4, 1))), np.zeros(2)))
        self.assertGreater(runs.steps, 20)
        self.assertTrue(np.array_equal(u.shape, (4, 1)))

    def test_a_massless_chain_agrees_with_differences(self):
        model, name = chain(), "forces.force1.stiffness"
        q, _ = start(model)
        u, times, h = np.zeros(model.nu), [0.3, 0.6], 1e-3
        runs = mb.Sensitivity(model, [name], rtol=1e-7, atol=1e-7)
        runs.run(times, q, u)
        dq, _ = runs.forward()
        everything = mb.Parameters(model)
        ends = [mb.Simulation(everything.model({name: 20.0 + s}), q, u, rtol=1e-11,
                              atol=1e-11).run(times).q for s in (-h, h)]
        wanted = (ends[1] - ends[0]) / (2 * h)
        self.assertLess(np.abs(dq[0] - wanted).max(), 1e-5)
        self.assertGreater(np.abs(wanted).max(), 1e-3)

    def test_refused(self):
        model = self.swing()
        with self.assertRaises(KeyError):
            mb.Sensitivity(model, ["bodies.load.weight"])
        with self.assertRaisesRegex(TypeError, "expected names"):
            mb.Sensitivity(model, "bodies.load.mass")
        with self.assertRaises(mb.UseError):
            mb.Sensitivity(model, [])
        with self.assertRaisesRegex(TypeError, "there is no 'tolerance'"):
            mb.Sensitivity(model, ["bodies.load.mass"], tolerance=1.0)
        runs = mb.Sensitivity(model, ["bodies.load.mass"])
        with self.assertRaisesRegex(mb.UseError, "SEQUENCE"):
            runs.forward()
        with self.assertRaises(mb.UseError):
            runs.run([1.0, 0.5], np.ones(1))
        runs.run([1.0], np.ones(1))
        with self.assertRaisesRegex(ValueError, r"w_q: expected .* \(1, 1\)"):
            runs.adjoint(np.ones(1))
        with self.assertRaisesRegex(ValueError, "q: expected"):
            runs.run([1.0], np.ones(2))
        runs.close()
        with self.assertRaises(mb.ClosedError):
            runs.forward()


def stand_in():
    """A module with as much of CasADi as a callback meets: sizes are asked for and held against
    what it returns."""
    made = types.ModuleType("casadi")

    class Sparsity:
        @staticmethod
        def dense(rows, columns):
            return rows, columns

    class Callback:
        """With the checks of FunctionInternal::jacobian, forward and reverse of CasADi 3.7."""

        def construct(self, name, _options):
            self.name = name
            self.inputs = [self.get_sparsity_in(k) for k in range(self.get_n_in())]
            self.outputs = [self.get_sparsity_out(k) for k in range(self.get_n_out())]

        def __call__(self, *given):
            assert [np.shape(one) for one in given] == self.inputs
            found = self.eval([np.array(one) for one in given])
            assert type(found) is list and [one.shape for one in found] == self.outputs
            return found[0] if len(found) == 1 else found

        def _derivative(self, get, prefix, *seeds):
            names = [f"i{k}" for k in range(len(self.inputs))]
            nominal = names + [f"out_o{k}" for k in range(len(self.outputs))]
            made = get(f"{prefix}_{self.name}", nominal + seeds[0], seeds[1],
                       {"derivative_of": self})
            assert made.get_n_in() == len(nominal + seeds[0])
            assert made.get_n_out() == len(seeds[1])
            assert made.inputs[:len(nominal)] == self.inputs + self.outputs
            return made

        def jacobian(self):
            assert self.has_jacobian()
            pairs = [(out, one) for out in self.outputs for one in self.inputs]
            names = [f"j{k}" for k in range(len(pairs))]
            made = self._derivative(self.get_jacobian, "jac", [], names)
            assert made.outputs == [(out[0] * out[1], one[0] * one[1]) for out, one in pairs]
            return made

        def forward(self, count):
            assert self.has_forward(count)
            made = self._derivative(lambda *rest: self.get_forward(count, *rest), f"fwd{count}",
                              [f"f{k}" for k in range(len(self.inputs))],
                              [f"s{k}" for k in range(len(self.outputs))])
            along = made.inputs[len(self.inputs + self.outputs):]
            assert along == [(rows, count * columns) for rows, columns in self.inputs]
            assert made.outputs == [(rows, count * columns) for rows, columns in self.outputs]
            return made

        def reverse(self, count):
            assert self.has_reverse(count)
            made = self._derivative(lambda *rest: self.get_reverse(count, *rest), f"adj{count}",
                              [f"w{k}" for k in range(len(self.outputs))],
                              [f"g{k}" for k in range(len(self.inputs))])
            along = made.inputs[len(self.inputs + self.outputs):]
            assert along == [(rows, count * columns) for rows, columns in self.outputs]
            assert made.outputs == [(rows, count * columns) for rows, columns in self.inputs]
            return made

    made.Sparsity, made.Callback, made.DM = Sparsity, Callback, np.array
    return made


def tumbling():
    """A free body with a hinge: q has a quaternion."""
    model = mb.Model()
    base = model.add_body("base", mb.joint.free(), mb.inertia.box(500.0, (0.3, 0.2, 0.1)))
    model.add_body("arm", mb.joint.revolute((0, 0, 0.1), None, Y),
                   mb.inertia.point_mass(1.0, (0, 0, 0.4)), base)
    model.add_force(mb.force.gravity(0, 0, -9.81))
    return model


class Casadi(unittest.TestCase):
    def setUp(self):
        if casadi is None:
            sys.modules["casadi"] = stand_in()
            self.addCleanup(sys.modules.pop, "casadi")

    def state(self, model, load=2.0):
        q, u = start(model)
        return [np.reshape(one, (-1, 1)) for one in (q, u, np.full(model.nu, load))]

    def differences(self, f, point, h=1e-6):
        columns = []
        for k, one in enumerate(point):
            for i in range(len(one)):
                ends = []
                for s in (-h, h):
                    moved = [np.array(x) for x in point]
                    moved[k][i] += s
                    ends.append(np.array(f(*moved))[:, 0])
                columns.append((ends[1] - ends[0]) / (2 * h))
        return np.stack(columns, axis=1)

    def test_values_and_derivatives(self):
        for model in (chain(massless=None), pendulum(0.2), tumbling()):
            for what in ("forward", "inverse"):
                f, point = mb.casadi.callback(model, what), self.state(model)
                flat = [one[:, 0].copy() for one in point]
                result = f(*point)
                wanted = getattr(model.data(), f"{what}_dynamics")(*flat)
                self.assertTrue(np.array_equal(np.array(result)[:, 0], wanted))
                slopes = self.differences(f, point)
                size = np.abs(slopes).max()
                blocks = f.jacobian()(*point, result)
                whole = np.hstack([np.array(one) for one in blocks])
                self.assertLess(np.abs(whole - slopes).max(), 1e-6 * size)
                rng = np.random.default_rng(2)
                along = [rng.standard_normal(one.shape) for one in point]
                w = rng.standard_normal((model.nu, 1))
                tangent = np.array(f.forward(1)(*point, result, *along))
                self.assertTrue(np.allclose(tangent, whole @ np.vstack(along)))
                back = [np.array(one) for one in f.reverse(1)(*point, result, w)]
                self.assertTrue(np.allclose(np.vstack(back), whole.T @ w))

    @unittest.skipUnless(casadi, "without casadi")
    def test_in_an_expression(self):
        model = tumbling()
        f, point = mb.casadi.callback(model), self.state(model)
        x = [casadi.MX.sym(name, len(one)) for name, one in zip("qul", point)]
        cost = casadi.sumsqr(f(*x))
        gradient = casadi.Function("g", x, [casadi.gradient(cost, casadi.vertcat(*x))])
        slopes = self.differences(lambda *at: casadi.Function("c", x, [cost])(*at), point)
        self.assertTrue(np.allclose(np.array(gradient(*point)).T, slopes, rtol=1e-5, atol=1e-4))

    def test_refused(self):
        with self.assertRaisesRegex(ValueError, "expected forward or inverse"):
            mb.casadi.callback(pendulum(), "backward")


if __name__ == "__main__":
    unittest.main()
