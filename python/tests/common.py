# SPDX-License-Identifier: BSD-3-Clause
"""Models of the tests."""
import numpy as np

import mbsrank as mb

Y = (0.0, 1.0, 0.0)


def pendulum(damping=0.0):
    """A mass of 2 kg at 0.5 m below a hinge."""
    model = mb.Model()
    model.add_body("rod", mb.joint.revolute(axis=Y), mb.inertia.point_mass(2.0, (0, 0, -0.5)))
    model.add_force(mb.force.gravity(0, 0, -9.81))
    if damping:
        model.add_force(mb.force.joint_spring(0, 0, 0.0, damping, 0.0))
    return model


def chain(count=4, push=None, massless=3):
    """Rods below each other on springs and dampers, as in twin.c; the last has no mass."""
    model = mb.Model()
    body = mb.GROUND
    for k in range(count):
        rod = (mb.inertia.zero() if k == massless
               else mb.inertia.rod(1.0 + k, (0, 0, 0), (0, 0, -1)))
        frame = (0, 0, -1) if k else None
        body = model.add_body(None, mb.joint.revolute(frame, None, Y), rod, body)
        model.add_force(mb.force.joint_spring(body, 0, 20.0, 0.5, 0.1))
    model.add_force(mb.force.gravity(0, 0, -9.81))
    if push:
        model.add_force(mb.force.joint_applied(body, push))
    return model


def start(model, seed=1):
    """A state."""
    model.finish()
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, model.nq), rng.uniform(-1, 1, model.nu)
