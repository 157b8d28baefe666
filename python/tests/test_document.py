# SPDX-License-Identifier: BSD-3-Clause
"""The code in docs/python.md runs, in its order."""
import contextlib
import io
import os
import re
import unittest
from math import cos
from pathlib import Path

import mbsrank as mb

ROOT = Path(__file__).resolve().parents[2]


def fall(end, steps=2000):
    """Angle (rad) of a rod of 1 m on a hinge, from rest along x, by Runge and Kutta's steps."""
    q, u, h = 0.0, 0.0, end / steps
    for _ in range(steps):
        k = []
        for part in (0.0, 0.5, 0.5, 1.0):
            dq, du = k[-1] if k else (0.0, 0.0)
            k.append((u + part * h * du, 1.5 * 9.81 * cos(q + part * h * dq)))
        q += h / 6 * (k[0][0] + 2 * k[1][0] + 2 * k[2][0] + k[3][0])
        u += h / 6 * (k[0][1] + 2 * k[1][1] + 2 * k[2][1] + k[3][1])
    return q


class Document(unittest.TestCase):
    def test_its_code_runs(self):
        text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        pieces = re.findall(r"^```python\n(.*?)^```$", text, re.S | re.M)
        self.assertGreater(len(pieces), 3)
        here, names = os.getcwd(), {}
        self.addCleanup(os.chdir, here)
        os.chdir(ROOT)
        with contextlib.redirect_stdout(io.StringIO()):
            for piece in pieces:
                exec(compile(piece, "docs/python.md", "exec"), names)
        self.assertEqual(names["many"].shape, (1000, 3))

    def test_the_model_of_all_tools_runs(self):
        text = (ROOT / "docs" / "neighbours.md").read_text(encoding="utf-8")
        (piece,) = re.findall(r"^```python\n(.*?# mbsrank)$", text, re.S | re.M)
        names = {"mb": mb}
        exec(compile(piece, "docs/neighbours.md", "exec"), names)
        self.assertAlmostEqual(names["q"][0], fall(1.0), 4)


if __name__ == "__main__":
    unittest.main()
