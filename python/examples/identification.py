# SPDX-License-Identifier: BSD-3-Clause
"""Damping and mass of a pendulum from a motion that was measured, by scipy's least squares with the
derivatives of the run."""
import numpy as np
from scipy.optimize import least_squares

import mbsrank as mb

TIMES = np.linspace(0.0, 3.0, 61)
NAMES = ["forces.hinge.damping", "bodies.rod.mass"]
TRUE = np.array([0.6, 1.5])
START = np.array([1.0])


def pendulum():
    """Its parameters, whose values are a first guess. Mass, stiffness and damping act together by
    two ratios: the stiffness is known."""
    model = mb.Model()
    model.add_body("rod", mb.joint.revolute(axis=(0, 1, 0)),
                   mb.inertia.point_mass(1.0, (0, 0, -0.5)))
    model.add_force(mb.force.joint_spring(0, 0, 8.0, 0.2, 0.0), name="hinge")
    model.add_force(mb.force.gravity(0, 0, -9.81))
    return mb.Parameters(model)


def run(parameters, values):
    """A run with these values."""
    model = parameters.model(dict(zip(NAMES, values)))
    runs = mb.Sensitivity(model, NAMES, rtol=1e-8, atol=1e-8)
    return runs, runs.run(TIMES, START)[0][:, 0]


def main():
    """Finds what made the noisy motion."""
    parameters = pendulum()
    noise = 1e-3 * np.random.default_rng(5).standard_normal(TIMES.size)
    measured = run(parameters, TRUE)[1] + noise
    found = least_squares(lambda x: run(parameters, x)[1] - measured, x0=[0.2, 1.0],
                          jac=lambda x: run(parameters, x)[0].forward()[0][:, :, 0].T)
    print(f"damping {found.x[0]:.4f} N m s/rad, mass {found.x[1]:.4f} kg; true {TRUE}")
    print(f"error of the motion {np.sqrt(np.mean(found.fun**2)):.2e} rad, {found.nfev} runs, "
          f"{found.njev} with derivatives")
    assert np.allclose(found.x, TRUE, rtol=1e-2)


if __name__ == "__main__":
    main()
