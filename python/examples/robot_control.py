# SPDX-License-Identifier: BSD-3-Clause
"""A robot arm follows a path under computed torques, at 1 kHz: the model of the controller is the
robot's own file."""
from pathlib import Path

import numpy as np

import mbsrank as mb

ARM = Path(__file__).resolve().parents[2] / "examples" / "models" / "arm.urdf"
PERIOD, KP, KD = 1e-3, 400.0, 40.0


def path(t, n):
    """Where the joints shall be: positions, rates, accelerations."""
    w, size = np.linspace(1.0, 2.0, n), 0.3
    return size * (1 - np.cos(w * t)), size * w * np.sin(w * t), size * w**2 * np.cos(w * t)


def main():
    """Drives the arm for one second."""
    file = mb.read(ARM, closures=0)
    robot, joints = file.model, [one for one in file.joints if one.kind != "fixed"]
    n = len(joints)
    torque = np.zeros(n)
    for k, joint in enumerate(joints):
        robot.add_force(mb.force.joint_applied(joint.body, lambda t, k=k: torque[k]))
    sim = mb.Simulation(robot, file.q0)
    control = mb.read(ARM, closures=0).model.data()
    worst = 0.0
    for k in range(1000):
        q, u, udot = path(sim.t, n)
        wish = udot + KP * (q - sim.q) + KD * (u - sim.u)
        torque[:] = control.inverse_dynamics(sim.q, sim.u, wish)
        sim.sample((k + 1) * PERIOD)
        worst = max(worst, np.abs(path(sim.t, n)[0] - sim.q).max())
    print(f"{n} joints, 1000 samples, {sim.stats.steps} steps, "
          f"largest error {1e3 * worst:.3f} mrad")
    assert worst < 5e-3


if __name__ == "__main__":
    main()
