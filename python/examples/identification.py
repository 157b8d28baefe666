# SPDX-License-Identifier: BSD-3-Clause
"""Stiffness, damping and mass of a pendulum from a motion that was measured, by scipy's least
squares."""
import numpy as np
from scipy.optimize import least_squares

import mbsrank as mb

TIMES = np.linspace(0.0, 3.0, 61)
TRUE = np.array([8.0, 0.6, 1.5])


def motion(parameters):
    """The angle at all times."""
    stiffness, damping, mass = parameters
    model = mb.Model()
    model.add_body("rod", mb.joint.revolute(axis=(0, 1, 0)),
                   mb.inertia.rod(mass, (0, 0, 0), (0, 0, -1)))
    model.add_force(mb.force.joint_spring(0, 0, stiffness, damping, 0.0))
    model.add_force(mb.force.gravity(0, 0, -9.81))
    return mb.Simulation(model, np.array([1.0]), rtol=1e-9, atol=1e-9).run(TIMES).q[:, 0]


def main():
    """Finds what made the noisy motion."""
    noise = 1e-3 * np.random.default_rng(5).standard_normal(TIMES.size)
    measured = motion(TRUE) + noise
    # mass, stiffness and damping act together by two ratios: the stiffness is known
    found = least_squares(lambda x: motion([TRUE[0], *x]) - measured, x0=[0.2, 1.0],
                          diff_step=1e-5, x_scale=[1.0, 1.0])
    print(f"damping {found.x[0]:.4f} N m s/rad, mass {found.x[1]:.4f} kg; true {TRUE[1:]}")
    print(f"error of the motion {np.sqrt(np.mean(found.fun**2)):.2e} rad, {found.nfev} runs")
    assert np.allclose(found.x, TRUE[1:], rtol=1e-2)


if __name__ == "__main__":
    main()
