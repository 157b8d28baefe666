# SPDX-License-Identifier: BSD-3-Clause
"""The code in docs/python.md runs, in its order."""
import contextlib
import io
import os
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


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


if __name__ == "__main__":
    unittest.main()
