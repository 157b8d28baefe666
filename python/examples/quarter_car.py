# SPDX-License-Identifier: BSD-3-Clause
"""A quarter of a car drives over a bump: wheel carrier and spring seat have no mass (as
examples/10_quarter_car.c)."""
import numpy as np

import mbsrank as mb

UP = (0.0, 0.0, 1.0)


def road(t):
    """5 cm high, from 0.2 s to 0.4 s: height, rate and acceleration."""
    if not 0.2 <= t <= 0.4:
        return 0.0, 0.0, 0.0
    w = np.pi / 0.2
    s, c = np.sin(w * (t - 0.2)), np.cos(w * (t - 0.2))
    return 0.05 * s**4, 0.2 * w * s**3 * c, 0.05 * w**2 * (12 * s**2 * c**2 - 4 * s**4)


def car(small):
    """road -- tyre -- carrier -- coil and damper -- spring seat -- rubber mount -- body"""
    model = mb.Model()
    driven = {"kind": "translation", "direction": UP, "driven": True}
    body = model.add_body("road", mb.joint.compound(axes=[driven], motion=road))
    parts = [("carrier", small, 2e5, 50.0), ("seat", small, 2e4, 1500.0),
             ("body", 400.0, 1e6, 50.0)]
    for name, mass, stiffness, damping in parts:
        body = model.add_body(name, mb.joint.prismatic(axis=UP), mb.inertia.particle(mass), body)
        model.add_force(mb.force.joint_spring(body, 0, stiffness, damping, 0.0))
    return model


def main():
    """What invented masses cost."""
    times = np.linspace(0.0, 2.0, 201)
    print("mass of carrier and seat, kg   steps   largest rise of the body, cm")
    rises = {}
    for small in (0.0, 1e-3, 1.0):
        model = car(small)
        sim = mb.Simulation(model, max_step=0.02)
        run = sim.run(times)
        rises[small] = run.q.sum(axis=1).max()
        print(f"{small:28g} {sim.stats.steps:7d} {100 * rises[small]:10.4f}")
    print(car(0.0).index_report(np.zeros(3), np.zeros(3)))
    assert abs(rises[0.0] - rises[1e-3]) < 1e-4
    assert 0.0 < rises[0.0] < 0.1


if __name__ == "__main__":
    main()
