# SPDX-License-Identifier: BSD-3-Clause
"""Runs: the same from C and Python to the last bit, events, exceptions, solvers of one's own."""
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

import mbsrank as mb
from common import chain, pendulum

HERE = Path(__file__).resolve().parent


class Runs(unittest.TestCase):
    def test_c_and_python_agree_to_the_last_bit(self):
        includes = [f"-I{one}" for one in os.environ["MBSRANK_INCLUDE"].split(os.pathsep)]
        libraries = os.environ["MBSRANK_LIBRARIES"].split(os.pathsep)
        where = [f"{flag}{one}" for one in libraries for flag in ("-L", "-Wl,-rpath,")]
        with tempfile.TemporaryDirectory() as folder:
            program = f"{folder}/twin"
            subprocess.run([*os.environ.get("CC", "cc").split(), "-o", program, HERE / "twin.c",
                            *includes, *where, "-lmbsrank_ida", "-lmbsrank"], check=True)
            run = subprocess.run([program], check=True, capture_output=True, text=True)
        theirs = run.stdout.split()
        sim = mb.Simulation(chain(push=lambda t: 3.0 * t * t), np.array([0.3, 0.2, -0.1, 0.4]))
        mine = []
        for state in sim.states(0.1 * k for k in range(1, 21)):
            for three in zip(state.q, state.u, state.udot):
                mine += [float(x).hex() for x in three]
        self.assertEqual(len(theirs), 20 * 12 + 1)
        self.assertEqual([float.fromhex(one).hex() for one in theirs[:-1]], mine)
        self.assertEqual(int(theirs[-1]), sim.stats.steps)

    def test_a_pendulum_keeps_its_energy(self):
        sim = mb.Simulation(pendulum(), np.array([1.0]), rtol=1e-10, atol=1e-10)
        run = sim.run(np.linspace(0.0, 5.0, 51))
        energy = 0.25 * run.u[:, 0] ** 2 - 9.81 * np.cos(run.q[:, 0])
        self.assertLess(np.ptp(energy), 1e-6)
        self.assertLess(abs(sim.drift.energy_change), 1e-6)
        self.assertEqual(list(run.columns), ["t", "q rod", "u rod"])
        self.assertEqual(len(run), 51)
        try:
            frame = run.to_pandas()
        except ImportError:
            return
        np.testing.assert_array_equal(frame["q rod"], run.q[:, 0])

    def test_events(self):
        sim = mb.Simulation(pendulum(), np.array([0.1]), rtol=1e-10, atol=1e-10,
                            events=lambda t, y, yp: y[0])
        states = list(sim.states([2.0]))
        times = [one.t for one in states if one.event]
        half = np.pi * np.sqrt(0.5 / 9.81) * (1 + 0.1 ** 2 / 16)
        np.testing.assert_allclose(np.diff(times), half, rtol=1e-5)
        self.assertEqual([one.event for one in states], [[-1], [1], [-1], None])

    def test_exceptions_reach_the_caller(self):
        class Mine(Exception):
            pass

        def late(t):
            if t > 0.5:
                raise Mine("at half a second")
            return 0.0

        def event(t, y, yp):
            raise Mine("event")

        def interrupt(now):
            if now.steps > 3:
                raise KeyboardInterrupt

        sim = mb.Simulation(chain(push=late), np.array([0.3, 0.2, -0.1, 0.4]))
        with self.assertRaisesRegex(Mine, "half a second"):
            sim.to(1.0)
        self.assertLess(sim.t, 0.5)
        self.assertEqual(sim.restart().to(0.2).t, 0.2)
        with self.assertRaisesRegex(ValueError, "expected 1 numbers, got 2"):
            mb.Simulation(chain(push=lambda t: (1.0, 2.0)))
        with self.assertRaisesRegex(TypeError, "returned None"):
            mb.Simulation(chain(push=lambda t: None))
        with self.assertRaisesRegex(Mine, "event"):
            mb.Simulation(pendulum(), events=event).to(1.0)
        with self.assertRaises(KeyboardInterrupt):
            mb.Simulation(pendulum(), np.array([1.0]), progress=interrupt).to(10.0)

    def test_views(self):
        sim = mb.Simulation(pendulum(), np.array([1.0]))
        q = sim.q
        sim.to(0.3)
        state = sim.state()
        self.assertEqual(state.q[0], q[0])
        self.assertLess(q[0], 1.0)
        with self.assertRaises(ValueError):
            q[0] = 1.0
        sim.to(0.4)
        self.assertNotEqual(state.q[0], q[0])
        del sim
        self.assertTrue(np.isfinite(q).all())

    def test_steps_of_fixed_size(self):
        q0 = np.array([0.3, 0.2, -0.1, 0.4])
        sim = mb.Simulation(chain(), q0, rtol=1e-9, atol=1e-9)
        stepper = mb.Stepper(chain(), q0, h=1e-3)
        q = stepper.q
        for _ in range(500):
            stepper.step()
        np.testing.assert_allclose(q, sim.to(0.5).q, atol=1e-5)
        self.assertAlmostEqual(stepper.t, 0.5, 12)
        self.assertEqual((stepper.info.steps, stepper.info.refused), (500, 0))
        with self.assertRaises(mb.UseError):
            stepper.to(0.1)
        with self.assertRaises(ValueError):
            q[0] = 0.0
        stepper.close()
        self.assertTrue(np.isfinite(q).all())

    def test_samples_with_held_forces(self):
        held = [0.0]
        model = pendulum()
        model.add_force(mb.force.joint_applied(0, lambda t: held[0]))
        sim = mb.Simulation(model)
        for k in range(1, 151):
            held[0] = 20.0 * (0.5 - sim.q[0]) - 4.0 * sim.u[0] + 9.81 * np.sin(sim.q[0])
            sim.sample(0.02 * k)
        self.assertAlmostEqual(sim.q[0], 0.5, 3)


class Solvers(unittest.TestCase):
    def test_newton_solves_with_the_derivative_of_the_residual(self):
        dae = mb.Dae(chain())
        y, yp, info = dae.consistent(np.array([0.3, 0.2, -0.1, 0.4]), np.zeros(4))
        self.assertEqual(info.null_directions, 1)
        self.assertLess(np.abs(dae.residual(0.0, y, yp)).max(), 1e-9)
        self.assertEqual(dae.differential.tolist(), [True] * 8 + [False] * 4)
        c, h = 50.0, 1e-6
        newton = dae.newton(products=1).factor(0.0, y, yp, c)
        matrix = np.empty((dae.size, dae.size))
        for k in range(dae.size):
            d = np.zeros(dae.size)
            d[k] = h
            matrix[:, k] = (dae.residual(0.0, y + d, yp + c * d)
                            - dae.residual(0.0, y - d, yp - c * d)) / (2 * h)
        r = np.linspace(1.0, 2.0, dae.size)
        delta = newton.solve(r)
        np.testing.assert_allclose(matrix @ delta, r, rtol=1e-5, atol=1e-5)
        back = newton.linearise(0.0, y, yp, c).multiply(delta)
        np.testing.assert_allclose(back, r, atol=1e-8)
        self.assertEqual(newton.info.exact, 1)

    def test_explicit_equations_agree_with_the_driver(self):
        model = chain()
        sim = mb.Simulation(model, np.array([0.3, 0.2, -0.1, 0.4]), rtol=1e-9, atol=1e-9)
        ode = mb.Ode(model, sim.q, sim.u)
        x, h = ode.pack(sim.q, sim.u), 1e-3
        for k in range(500):
            t = k * h
            k1 = ode(t, x)
            k2 = ode(t + h / 2, x + h / 2 * k1)
            k3 = ode(t + h / 2, x + h / 2 * k2)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + ode(t + h, x + h * k3))
        sim.to(0.5)
        np.testing.assert_allclose(x[:4], sim.q, atol=1e-6)
        np.testing.assert_allclose(ode.velocities(0.5, x), sim.u, atol=1e-5)


if __name__ == "__main__":
    unittest.main()
