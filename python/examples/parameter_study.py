# SPDX-License-Identifier: BSD-3-Clause
"""Twenty thousand states of one model in a call, on one thread and on two; and runs of many models
in a table."""
import time

import numpy as np

import mbsrank as mb


def chain(count, length=1.0):
    """Bars on hinges, one below the other."""
    model, body = mb.Model(), mb.GROUND
    for k in range(count):
        joint = mb.joint.revolute((0, 0, -length) if k else None, None, (0, 1, 0))
        bar = mb.inertia.in_frame((0, 0, -length / 2), mb.inertia.box(100.0, (0.1, 0.1, length)))
        body = model.add_body(f"bar {k}", joint, bar, body)
    model.add_force(mb.force.gravity(0, 0, -9.81))
    return model


def main():
    """Compares calls by batch with single ones, and periods with theory."""
    model = chain(30).finish()
    rng = np.random.default_rng(1)
    q, u = rng.uniform(-1, 1, (2, 20_000, model.nu))
    results = {}
    for threads in (1, 2):
        batch = model.batch(threads)
        batch.forward_dynamics(q[:64], u[:64])
        began = time.perf_counter()
        results[threads] = batch.forward_dynamics(q, u)
        took = time.perf_counter() - began
        print(f"{threads} thread(s): {1e9 * took / q.size:.0f} ns a body")
    assert np.array_equal(results[1], results[2])
    data = model.data()
    assert np.allclose(results[1][7], data.forward_dynamics(q[7], u[7]), rtol=1e-9)

    print("length, m   period, s   theory, s")
    for length in (0.5, 1.0, 2.0):
        sim = mb.Simulation(chain(1, length), np.array([0.01]), rtol=1e-9, atol=1e-9,
                            events=lambda t, y, yp: y[0])
        events = [one.t for one in sim.states([10.0]) if one.event]
        period = 2 * (events[-1] - events[0]) / (len(events) - 1)
        lever = (length**2 / 3 + 0.1**2 / 12) / (length / 2)
        theory = 2 * np.pi * np.sqrt(lever / 9.81)
        print(f"{length:9g} {period:11.5f} {theory:11.5f}")
        assert abs(period - theory) < 1e-4 * theory


if __name__ == "__main__":
    main()
