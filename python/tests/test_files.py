# SPDX-License-Identifier: BSD-3-Clause
"""Models from files, and pages of them."""
import gc
import os
import tempfile
import unittest
from pathlib import Path

import numpy as np

import mbsrank as mb

MODELS = Path(__file__).resolve().parents[2] / "examples" / "models"

ARM = """<mujoco model="arm"><worldbody><body name="a"><joint name="j" axis="0 1 0" range="-1 2"/>
<geom size=".1" pos=".3 0 0"/><site name="tip" pos=".3 0 0"/></body></worldbody>
<actuator><motor name="m" joint="j" gear="2"/></actuator>
<sensor><framepos name="place" objtype="site" objname="tip"/></sensor>
<keyframe><key name="up" qpos="1.5" qvel="0.5" ctrl="3"/></keyframe></mujoco>"""


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.path = self.folder / "arm.xml"
        self.path.write_text(ARM, encoding="utf-8")

    def test_what_is_in_it(self):
        file = mb.read(self.path)
        self.assertEqual((file.name, file.bodies, file.keys, file.findings),
                         ("arm", ["a"], ["up"], []))
        joint = file.joints[0]
        self.assertEqual((joint.name, joint.kind, joint.limited), ("j", "hinge", 1))
        np.testing.assert_allclose(joint.range, np.deg2rad([-1, 2]))
        q, u, control = file.key("up")
        self.assertEqual((q[0], u[0], control[0]), (1.5, 0.5, 3.0))
        with self.assertRaises(KeyError):
            file.key("down")
        data = file.model.data()
        before = data.forward_dynamics(q, u)
        file.control[0] = 4.0
        after = data.forward_dynamics(q, u)
        self.assertAlmostEqual((after - before)[0] * data.mass_matrix(q)[0, 0], 8.0, 10)
        data.velocities(q, u)
        np.testing.assert_allclose(file.sense("place", data, q, u), data.point(0, (0.3, 0, 0))[0])

    def test_the_model_outlives_its_file(self):
        file = mb.read(self.path)
        model, control, zero = file.model, file.control, np.zeros(1)
        control[0] = 1.0
        expected = model.data().forward_dynamics(zero, zero)
        file.close()
        with self.assertRaises(mb.ClosedError):
            file.key("up")
        del file
        gc.collect()
        np.testing.assert_array_equal(model.data().forward_dynamics(zero, zero), expected)
        del model
        gc.collect()
        self.assertEqual(control[0], 1.0)

    def test_refused(self):
        self.path.write_text("<mujoco><worldbody><body><joint axis='0 0 0'/></body></worldbody>"
                             "</mujoco>", encoding="utf-8")
        with self.assertRaisesRegex(mb.UseError, "arm.xml.*axis"):
            mb.read(self.path)
        with self.assertRaises(FileNotFoundError):
            mb.read("nowhere.xml")
        with self.assertRaisesRegex(TypeError, "no 'flooting'"):
            mb.read(self.path, flooting=1)

    def test_files_outside_are_not_read(self):
        (self.folder / "outside.xml").write_text(
            "<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>",
            encoding="utf-8")
        inner = self.folder / "inner"
        inner.mkdir()
        (inner / "a.xml").write_text("<mujoco><include file='../outside.xml'/></mujoco>",
                                     encoding="utf-8")
        with self.assertRaisesRegex(mb.UseError, "ermission"):
            mb.read(inner / "a.xml")
        self.assertEqual(mb.read(inner / "a.xml", folders=[self.folder]).q0.size, 1)

    def test_there_and_back(self):
        for name in ("arm.urdf", "suspension.xml"):
            file = mb.read(MODELS / name)
            text, _ = mb.to_mjcf(file.model, file)
            self.path.write_text(text, encoding="utf-8")
            again = mb.read(self.path)
            q, u = file.q0.copy(), np.linspace(-1, 1, file.model.finish().nu)
            data = [one.model.data() for one in (file, again)]
            np.testing.assert_allclose(*(one.bias_forces(q, u) for one in data), rtol=1e-9,
                                       atol=1e-9)

    @unittest.skipUnless(os.environ.get("MBSRANK_PROGRAM"), "needs the program mbsrank")
    def test_a_page(self):
        file = mb.read(self.path)
        run = mb.Simulation(file.model, file.q0).run(np.linspace(0, 1, 11))
        try:
            mb.view(self.path)
        except RuntimeError as error:
            if "no viewer" in str(error):
                self.skipTest(str(error))
            raise
        for page in (mb.view(self.path), mb.view(file, run), mb.view(file.model)):
            self.assertIn("<html", page.html[:500].lower())
            self.assertIn("<iframe", page._repr_html_())
            page.save(self.folder / "page.html")
        with self.assertRaises(RuntimeError):
            mb.view(self.folder / "nowhere.xml")


if __name__ == "__main__":
    unittest.main()
