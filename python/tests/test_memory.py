# SPDX-License-Identifier: BSD-3-Clause
"""Memory does not grow where objects come and go."""
import gc
import os
import unittest
import weakref

import numpy as np

import mbsrank as mb
from common import chain, pendulum

COUNT = 100_000 if os.environ.get("MBSR_TEST_LONG") else 4_000


def resident():
    """Memory of this process, in bytes."""
    with open("/proc/self/statm", encoding="ascii") as stream:
        return int(stream.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Memory(unittest.TestCase):
    def growth(self, one, count):
        """By how many bytes memory grows, after the first tenth."""
        for _ in range(count // 10):
            one()
        gc.collect()
        before = resident()
        for _ in range(count):
            one()
        gc.collect()
        return resident() - before

    def test_models_and_data(self):
        q = np.zeros(1)

        def one():
            model = pendulum(damping=0.1)
            model.add_force(mb.force.joint_applied(0, lambda t: 1.0))
            model.data().forward_dynamics(q, q)

        self.assertLess(self.growth(one, COUNT), 500_000)

    def test_runs(self):
        model, q = chain(), np.array([0.3, 0.2, -0.1, 0.4])

        def one():
            with mb.Simulation(model, q, events=lambda t, y, yp: y[0] - 9.0) as sim:
                sim.to(1e-4)

        self.assertLess(self.growth(one, COUNT // 10), 500_000)

    def test_failures(self):
        def one():
            with self.assertRaises(mb.UseError):
                mb.Model().add_body("x", mb.joint.revolute())

        self.assertLess(self.growth(one, COUNT), 500_000)

    def test_cycles_are_freed_in_order(self):
        model, made = pendulum(), []
        for _ in range(50):
            box = []
            sim = mb.Simulation(model, events=lambda t, y, yp, box=box: 1.0 + len(box))
            box.append(sim)
            made.append(weakref.ref(sim._handle))
        del sim, box
        gc.collect()
        self.assertEqual([one() for one in made], [None] * 50)


if __name__ == "__main__":
    unittest.main()
