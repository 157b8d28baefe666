# SPDX-License-Identifier: BSD-3-Clause
"""What a call from Python takes more than the same call from C: medians of processor time,
interleaved in one run.

    python3 -P overhead.py [ROUNDS]     default 300; bench/results/python.csv is what it prints.
    -P: the package that is installed, not the sources beside it"""
import os
import platform
import sys
import time
import timeit

import numpy as np

import mbsrank as mb


def main():
    """Prints a table."""
    rounds, number = int(sys.argv[1]) if len(sys.argv) > 1 else 300, 1000
    model = mb.Model()
    body = mb.GROUND
    for k in range(7):
        joint = mb.joint.revolute((0, 0, -1) if k else None, None, (k % 2, 1 - k % 2, 0))
        body = model.add_body(None, joint, mb.inertia.box(1000.0, (0.1, 0.1, 1.0)), body)
    model.add_force(mb.force.gravity(0, 0, -9.81))
    data, dae = model.data(), mb.Dae(model)
    q, u, out = (np.zeros(7) for _ in range(3))
    y, yp, F = (np.zeros(dae.size) for _ in range(3))
    at = {name: mb.ffi.from_buffer("double[]", array) for name, array in
          (("q", q), ("u", u), ("out", out), ("y", y), ("yp", yp), ("F", F))}
    lib, null, one, of = mb.lib, mb.ffi.NULL, model._get(), data._get()
    own, form = dae._get(), dae.form
    pairs = {
        "Data.forward_dynamics": (
            lambda: data.forward_dynamics(q, u, None, 0.0, out),
            lambda: lib.mbsr_forward_dynamics(one, of, 0.0, at["q"], at["u"], null, at["out"])),
        "the same with tau and a new array": (
            lambda: data.forward_dynamics(q, u, u),
            lambda: lib.mbsr_forward_dynamics(one, of, 0.0, at["q"], at["u"], at["u"], at["out"])),
        "Data.inverse_dynamics": (
            lambda: data.inverse_dynamics(q, u, u, 0.0, out),
            lambda: lib.mbsr_inverse_dynamics(one, of, 0.0, at["q"], at["u"], at["u"], null,
                                              at["out"])),
        "Dae.residual": (
            lambda: dae.residual(0.0, y, yp, F),
            lambda: lib.mbsr_dae_residual(one, own, form, 0.0, at["y"], at["yp"], at["F"])),
    }
    print("# time of calls from Python and from C, 7 bodies, microseconds of processor time")
    print(f"# date: {time.strftime('%Y-%m-%d %H:%M', time.gmtime())} UTC")
    print(f"# load average at start: {os.getloadavg()[0]:.2f}; {rounds} rounds, interleaved")
    versions = platform.python_version(), np.__version__, mb.__version__
    print("# Python {}, numpy {}, libmbsrank {}".format(*versions))
    print("call,python_us,bare_us,more_us")
    for name, both in pairs.items():
        times = [[timeit.timeit(call, timer=time.thread_time, number=number) for call in both]
                 for _ in range(rounds)]
        here, bare = (1e6 / number * np.median(each) for each in zip(*times))
        print(f"{name},{here:.2f},{bare:.2f},{here - bare:.2f}")


if __name__ == "__main__":
    main()
