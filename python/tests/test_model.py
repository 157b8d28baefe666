# SPDX-License-Identifier: BSD-3-Clause
"""Evaluations against answers that are known, and what is refused."""
import gc
import threading
import unittest

import numpy as np

import mbsrank as mb
from common import Y, chain, pendulum, start


class Dynamics(unittest.TestCase):
    def test_pendulum(self):
        data = pendulum().data()
        q, u = np.array([0.3]), np.array([0.7])
        udot = data.forward_dynamics(q, u)
        self.assertAlmostEqual(udot[0], -9.81 / 0.5 * np.sin(0.3), 12)
        self.assertAlmostEqual(data.mass_matrix(q)[0, 0], 2 * 0.25, 14)
        self.assertAlmostEqual(data.inverse_dynamics(q, u, udot)[0], 0.0, 12)
        self.assertAlmostEqual(data.bias_forces(q, u)[0], 2 * 9.81 * 0.5 * np.sin(0.3), 12)
        kinetic, potential = data.velocities(q, u).energy()
        self.assertAlmostEqual(kinetic, 0.5 * 2 * 0.25 * 0.49, 13)
        self.assertAlmostEqual(potential, -2 * 9.81 * 0.5 * np.cos(0.3), 12)
        place, speed = data.point(0, (0, 0, -0.5))
        by_hand = np.array([-0.5 * np.sin(0.3), 0, -0.5 * np.cos(0.3)])
        np.testing.assert_allclose(place, by_hand, atol=1e-14)
        np.testing.assert_allclose(speed, 0.7 * np.array([by_hand[2], 0, -by_hand[0]]), atol=1e-14)
        np.testing.assert_allclose(data.frame(0).R @ [0, 0, -0.5], place, atol=1e-14)
        np.testing.assert_allclose(data.jacobian(0) @ u, data.twist(0), atol=1e-14)
        mass, centre, momentum = data.momentum()
        self.assertAlmostEqual(mass, 2.0, 14)
        np.testing.assert_allclose(momentum[3:], 2.0 * speed, atol=1e-13)
        np.testing.assert_allclose(centre, place, atol=1e-14)
        data.accelerations(q, u, udot)
        self.assertAlmostEqual(data.acceleration(0)[1], udot[0], 13)
        self.assertAlmostEqual(data.reaction(0)[1], 0.0, 12)

    def test_the_equations_of_motion_hold(self):
        model = chain(6, massless=-1)
        data = model.data()
        q, u = start(model)
        tau = np.linspace(-1, 1, model.nu)
        udot = data.forward_dynamics(q, u, tau)
        left = data.mass_matrix(q) @ udot + data.bias_forces(q, u)
        np.testing.assert_allclose(left, tau, atol=1e-10)
        np.testing.assert_allclose(data.inverse_dynamics(q, u, udot), tau, atol=1e-10)

    def test_derivatives_against_differences(self):
        model = chain(4, massless=-1)
        data, derivatives = model.data(), mb.Derivatives(model)
        q, u = start(model)
        tau, h = np.linspace(-1, 1, 4), 1e-6
        udot = derivatives.forward(q, u, tau)
        np.testing.assert_allclose(udot, data.forward_dynamics(q, u, tau), rtol=1e-12)
        three = [q, u, tau]
        for k, matrix in enumerate(derivatives.jacobians()):
            for column in range(4):
                at = [[one.copy() for one in three] for _ in range(2)]
                at[0][k][column] += h
                at[1][k][column] -= h
                plus, minus = (data.forward_dynamics(*one) for one in at)
                np.testing.assert_allclose(matrix[:, column], (plus - minus) / (2 * h), rtol=1e-5,
                                           atol=1e-5)
        change = derivatives.tangent(dq=u, dload=tau)
        by_q, _, by_tau = derivatives.jacobians()
        np.testing.assert_allclose(change, by_q @ u + by_tau @ tau, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(derivatives.inverse(q, u, udot), tau, atol=1e-9)
        np.testing.assert_allclose(derivatives.jacobians()[2], data.mass_matrix(q), atol=1e-10)

    def test_batches_are_single_states(self):
        model = chain(8, massless=-1).finish()
        q, u, tau = np.random.default_rng(2).uniform(-1, 1, (3, 37, model.nu))
        data = model.data()
        one = np.array([data.forward_dynamics(*three) for three in zip(q, u, tau)])
        both = [model.batch(threads).forward_dynamics(q, u, tau) for threads in (1, 2)]
        np.testing.assert_allclose(both[0], one, rtol=1e-10)
        np.testing.assert_array_equal(*both)
        np.testing.assert_allclose(model.batch().inverse_dynamics(q, u, one), tau, atol=1e-9)

    def test_states_that_fail_in_a_batch(self):
        model = mb.Model()
        model.add_body("a", mb.joint.spherical(), mb.inertia.sphere(1000.0, 0.1))
        model.finish()
        q, u = np.array([[1.0, 0, 0, 0], [0, 0, 0, 0]]), np.zeros((2, 3))
        status, batch = np.zeros(2, dtype="i4"), model.batch()
        with self.assertRaises(mb.StateError) as caught:
            batch.forward_dynamics(q, u)
        self.assertEqual(caught.exception.name, "MBSR_ZERO_QUATERNION")
        udot = batch.forward_dynamics(q, u, status=status)
        self.assertEqual(status.tolist(), [0, mb.lib.MBSR_ZERO_QUATERNION])
        self.assertTrue((udot[0] == 0).all() and np.isnan(udot[1]).all())

    def test_exceptions_in_threads_of_the_library(self):
        model = chain(6, push=lambda t: 1 / 0, massless=-1).finish()
        batch, q = model.batch(2), np.zeros((64, 6))
        for _ in range(3):
            with self.assertRaises(ZeroDivisionError):
                batch.forward_dynamics(q, q)
        with self.assertRaises(mb.UseError) as caught:
            mb.Model().add_body("x", mb.joint.revolute())
        self.assertIsNone(caught.exception.__cause__)

    def test_threads_go_on_during_a_batch(self):
        model = chain(40, massless=-1).finish()
        q, u = (np.zeros((20000, model.nu)) for _ in range(2))
        batch, counts, done = model.batch(), [], threading.Event()

        def count():
            k = 0
            while not done.wait(1e-4):
                k += 1
            counts.append(k)

        other = threading.Thread(target=count)
        other.start()
        batch.forward_dynamics(q, u)
        done.set()
        other.join()
        self.assertGreater(counts[0], 2)

    def test_index_report(self):
        model = chain().finish()
        report = model.index_report(np.zeros(model.nq), np.zeros(model.nu))
        self.assertEqual((report.index, report.damped, report.dynamic), (1, 1, 3))
        self.assertEqual(len(list(report)), 1)
        self.assertIn("damped", str(report))
        self.assertIn("<table>", report._repr_html_())

    def test_small_masses(self):
        model = mb.Model()
        slide = mb.joint.prismatic(axis=(1, 0, 0))
        light = model.add_body("light", slide, mb.inertia.particle(1e-6))
        model.add_force(mb.force.joint_spring(light, 0, 1e4, 100.0, 0.0))
        heavy = model.add_body("heavy", slide, mb.inertia.particle(1.0), light)
        model.add_force(mb.force.joint_spring(heavy, 0, 10.0, 1.0, 0.0))
        report = mb.SmallMasses(model, np.array([0.0, 1.0]), np.zeros(2), 3.0)
        self.assertEqual([one.name for one in report], ["light"])
        self.assertIn("may be zero", str(report))
        self.assertIn("light", str(report.run(3.0)))
        self.assertLess(report.masses[0].share, 1.0)
        with self.assertRaises(mb.UseError):
            mb.SmallMasses(model, np.zeros(2), np.zeros(2), -1.0)

    def test_a_force_of_ones_own(self):
        def evaluate(t, bodies):
            bodies[0].tau[0] -= 7.0 * bodies[0].q[0] + 0.2 * bodies[0].u[0] - t

        models = [pendulum(), pendulum()]
        models[0].add_force(mb.force.custom(evaluate, [0], lambda t, b: 3.5 * b[0].q[0] ** 2))
        models[1].add_force(mb.force.joint_spring(0, 0, 7.0, 0.2, 0.0))
        models[1].add_force(mb.force.joint_applied(0, lambda t: t))
        q, u = np.array([0.4]), np.array([-0.3])
        gc.collect()
        a, b = (one.data().forward_dynamics(q, u, t=1.5) for one in models)
        np.testing.assert_allclose(a, b, rtol=1e-14)
        energies = [one.data().velocities(q, u).energy() for one in models]
        np.testing.assert_allclose(*energies, rtol=1e-14)

    def test_laws_by_functions(self):
        """A spring, a servo and a closure whose laws are functions, against those of the
        library."""
        def two(spring, servo):
            model = pendulum()
            model.add_body("other", mb.joint.revolute((1, 0, 0), None, Y),
                           mb.inertia.point_mass(1.0, (0, 0, -0.5)))
            model.add_force(mb.force.spring(0, (0, 0, -0.5), 1, (0, 0, -0.5), spring))
            model.add_force(mb.force.joint_servo(1, 0, servo))
            return model.data()

        numbers = two({"stiffness": 40.0, "damping": 2.0, "free_length": 0.7},
                      {"kp": 30.0, "kd": 3.0, "table": mb.Table([0.0, 2.0], [0.0, 1.0])})
        functions = two({"function": lambda x, v: (40 * (x - 0.7) + 2 * v, 20 * (x - 0.7) ** 2,
                                                   2 * v * v)},
                        {"kp": 30.0, "kd": 3.0, "function": lambda t: (t / 2, 0.5)})
        gc.collect()
        q, u = np.array([0.3, -0.2]), np.array([0.5, 1.0])
        a, b = (one.forward_dynamics(q, u, t=0.8) for one in (numbers, functions))
        np.testing.assert_allclose(a, b, rtol=1e-13)
        energies = [one.velocities(q, u).energy() for one in (numbers, functions)]
        np.testing.assert_allclose(*energies, rtol=1e-13)
        powers = [one.velocities(q, u).dissipation() for one in (numbers, functions)]
        np.testing.assert_allclose(*powers, rtol=1e-13)
        model = pendulum()
        held = mb.closure.coupling([0], [0], [1.0], 0.25)
        held.motion = lambda t: (0.1 * t, 0.1, 0.0)
        model.add_closure(held, "driven")
        sim = mb.Simulation(model, np.array([0.25]))
        self.assertAlmostEqual(sim.to(1.0).q[0], 0.35, 6)

    def test_loops(self):
        model = mb.Model()
        cranks = [model.add_body(None, mb.joint.revolute((x, 0, 0), None, Y),
                                 mb.inertia.rod(1.0, (0, 0, 0), (0, 0, -1))) for x in (0.0, 1.0)]
        bar = model.add_body("bar", mb.joint.revolute((0, 0, -1), None, Y),
                             mb.inertia.rod(1.0, (0, 0, 0), (1, 0, 0)), cranks[0])
        model.add_closure(mb.closure.ball(bar, (1, 0, 0), cranks[1], (0, 0, -1)), "pin")
        data = model.data()
        q, info = data.assemble(np.array([0.3, 0.25, -0.2]))
        self.assertLess(np.abs(data.gaps(q)).max(), 1e-11)
        self.assertGreater(info.gap_before, 1e-3)
        sim = mb.Simulation(model, q)
        self.assertEqual(sim.to(0.1).loop_forces.shape, (model.rows,))
        at = [one.copy() for one in (sim.q, sim.u, sim.udot)]
        np.testing.assert_allclose(data.inverse_dynamics(*at, motors=[0]), 0.0, atol=1e-6)
        with self.assertRaises(mb.UseError):
            data.inverse_dynamics(*at, motors=[7])


class Refused(unittest.TestCase):
    def setUp(self):
        self.model = chain(massless=-1)
        self.data = self.model.data()
        self.q, self.u = np.zeros(4), np.zeros(4)

    def refused(self, kind, text, call, *arguments, **named):
        with self.assertRaisesRegex(kind, text):
            call(*arguments, **named)

    def test_arrays(self):
        call, q, u = self.data.forward_dynamics, self.q, self.u
        wanted = r"float64 array of shape \(4,\)"
        self.refused(ValueError, rf"q: .*{wanted}, got shape \(3,\)", call, np.zeros(3), u)
        self.refused(TypeError, rf"u: .*{wanted}, got float32", call, q, u.astype("f4"))
        self.refused(TypeError, rf"tau: .*{wanted}, got list", call, q, u, [0.0] * 4)
        self.refused(ValueError, rf"q: .*{wanted}, got another order", call, np.zeros((4, 2))[:, 0],
                     u)
        self.refused(ValueError, "q: .*got another order", call, np.zeros(4)[::-1], u)
        fixed = np.zeros(4)
        fixed.flags.writeable = False
        self.refused(ValueError, "out: .*can be written", call, q, u, out=fixed)
        self.refused(TypeError, "q: .*got complex128", call, q.astype(complex), u)
        self.refused(TypeError, "q: .*got float64 of the other byte order", call, q.astype(">f8"),
                     u)
        batch = self.model.batch()
        self.refused(ValueError, "q: .*another order", batch.forward_dynamics, np.zeros((4, 3)).T,
                     np.zeros((3, 4)))
        self.refused(ValueError, r"u: .*\(3, 4\), got shape \(2, 4\)", batch.forward_dynamics,
                     np.zeros((3, 4)), np.zeros((2, 4)))
        self.refused(ValueError, r"yp: .*\(12,\)", mb.Dae(self.model).residual, 0.0, np.zeros(12),
                     np.zeros(11))
        self.assertEqual(call(q, u).shape, (4,))  # still usable
        self.assertEqual(call(fixed, u).shape, (4,))

    def test_values(self):
        model = mb.Model()
        self.refused(mb.UseError, "finished", self.model.add_body, "x", mb.joint.weld())
        self.refused(ValueError, "axis: expected 3 numbers, got 2", mb.joint.revolute, axis=(1, 0))
        self.refused(mb.UseError, "axis", model.add_body, "x", mb.joint.revolute())
        self.refused(TypeError, "expected Joint, got Inertia", model.add_body, "x",
                     mb.inertia.zero())
        self.refused(TypeError, "there is no 'stifness'", mb.force.spring, 0, None, 1, None,
                     {"stifness": 1.0})
        self.refused(TypeError, "expected a function", mb.force.joint_applied, 0, 3.0)
        self.refused(TypeError, "no 'rtoll'", mb.Simulation, pendulum(), rtoll=1.0)
        self.refused(ValueError, "form 'moment'", mb.Dae, self.model, "moment")
        self.refused(KeyError, "nobody", self.model.find_body, "nobody")
        for call in (self.model.body_name, self.model.parent, self.data.pose, self.data.jacobian):
            self.refused(IndexError, "no body 99", call, 99)
        self.refused(ValueError, "name: it contains a NUL", model.add_body, "a\0b", mb.joint.weld())
        self.refused(TypeError, "name: expected a text, got int", model.add_body, 5,
                     mb.joint.weld())
        self.refused(TypeError, "no 'cookie'", mb.Simulation, pendulum(), cookie=1)
        self.refused(ValueError, "48 numbers at most", setattr, mb.joint.weld(), "param", range(99))
        self.refused(AttributeError, "no parm", setattr, mb.joint.weld(), "parm", 1)
        self.refused(mb.UseError, "from 1 to 256", self.model.batch, 0)
        self.refused(mb.UseError, "states is 0", self.model.batch().forward_dynamics,
                     np.zeros((0, 4)), np.zeros((0, 4)))
        with self.assertRaises(mb.UseError) as caught:
            model.add_force(mb.force.joint_spring(5, 0, 1.0, 0.0, 0.0))
            model.finish()
        self.assertEqual(caught.exception.name, "MBSR_ERR_ID")

    def test_a_state_without_an_answer(self):
        model = mb.Model()
        model.add_body("loose", mb.joint.prismatic(axis=(1, 0, 0)))
        with self.assertRaises(mb.StateError) as caught:
            model.data().forward_dynamics(np.zeros(1), np.zeros(1))
        self.assertEqual((caught.exception.name, caught.exception.body), ("MBSR_UNDETERMINED", 0))

    def test_arrays_that_come_again(self):
        q, u, out = self.q.copy(), self.u.copy(), np.zeros(self.model.nu)
        first = self.data.forward_dynamics(q, u, u, 0.0, out).copy()
        q[0] += 0.1
        changed = self.data.forward_dynamics(q, u, u, 0.0, out).copy()
        self.assertFalse(np.array_equal(first, changed))
        wanted = self.model.data().forward_dynamics(q.copy(), u.copy(), u.copy())
        self.assertTrue(np.array_equal(changed, wanted))
        out.flags.writeable = False
        self.refused(ValueError, "can be written", self.data.forward_dynamics, q, u, u, 0.0, out)
        q.shape = (1, q.size)
        self.refused(ValueError, "got shape", self.data.forward_dynamics, q, u)

    def test_what_is_closed(self):
        sim, batch = mb.Simulation(self.model, self.q), self.model.batch()
        newton = mb.Dae(self.model).newton()
        calls = [(self.data, lambda: self.data.forward_dynamics(self.q, self.u)),
                 (sim, lambda: sim.to(1.0)), (sim, lambda: sim.q), (batch, lambda: batch.lanes),
                 (newton, lambda: newton.info), (self.model, self.model.data)]
        for owner, call in calls:
            owner.close()
            self.assertTrue(owner.closed)
            self.assertRegex(repr(owner), "closed")
            self.refused(mb.ClosedError, "is closed", call)
        with pendulum() as model:
            self.refused(mb.UseError, "not finished", lambda: model.nq)
            self.assertEqual(model.finish().nq, 1)
        self.refused(mb.ClosedError, "is closed", lambda: model.bodies)


class Tables(unittest.TestCase):
    def test_values_and_motions(self):
        table = mb.Table([0.0, 1.0, 2.0], [0.0, 1.0, 0.0])
        self.assertEqual((table(0.5), table(0.5, 1), table(3.0)), (0.5, 1.0, 0.0))
        with self.assertRaisesRegex(ValueError, "3 rows"):
            mb.Table([0, 1, 2], [0, 1])
        with self.assertRaises(mb.UseError):
            mb.Table([0, 1, 1], [0, 1, 2])
        model = mb.Model()
        driven = {"kind": "translation", "direction": (0, 0, 1), "driven": True}
        smooth = mb.Table(np.linspace(0, 2, 9), np.linspace(0, 2, 9) ** 2, kind="spline")
        model.add_body("road", mb.joint.compound(axes=[driven], motion=smooth))
        by_hand = mb.joint.compound(axes=[driven], motion=lambda t: (t * t, 2 * t, 2.0))
        model.add_body("road too", by_hand)
        del smooth, by_hand
        gc.collect()
        data = model.data().velocities(np.zeros(0), np.zeros(0), t=1.5)
        for body in (0, 1):
            np.testing.assert_allclose(data.pose(body)[11], 2.25, rtol=1e-12)
            np.testing.assert_allclose(data.twist(body)[5], 3.0, rtol=1e-12)


if __name__ == "__main__":
    unittest.main()
