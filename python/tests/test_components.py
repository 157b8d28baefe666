# SPDX-License-Identifier: BSD-3-Clause
"""Parameters, flexible bodies; the components contact, linear, fmu and fe where they are there."""
import math
import os
import tempfile
import unittest
import zipfile
from pathlib import Path

import numpy as np

import mbsrank as mb
from common import Y, chain, pendulum, start
from mbsrank._interface import COMPONENTS

MODELS = Path(__file__).resolve().parents[2] / "examples" / "models"


def there(component):
    return unittest.skipUnless(component in COMPONENTS, f"without the component {component}")


class Parameters(unittest.TestCase):
    def test_values_by_name_make_another_model(self):
        model = pendulum()
        all_of_it = mb.Parameters(model)
        self.assertEqual(all_of_it["bodies.rod.mass"], 2.0)
        self.assertIn("bodies.rod.mass", [one.name for one in all_of_it])
        self.assertEqual(next(one for one in all_of_it if one.name == "bodies.rod.mass").unit, "kg")
        self.assertNotIn("bodies.rod.weight", all_of_it)
        q, u = np.array([0.3]), np.array([0.0])
        heavy = all_of_it.model({"bodies.rod.mass": 6.0})
        tau = np.array([1.0])
        rest = np.zeros(1)
        light, more = (one.data().inverse_dynamics(q, u, rest) for one in (model, heavy))
        self.assertAlmostEqual(more[0], 3.0 * light[0], 12)
        self.assertEqual(all_of_it["bodies.rod.mass"], 2.0)
        longer = all_of_it.data({"bodies.rod.com[3]": -1.0})
        self.assertTrue(np.allclose(longer.forward_dynamics(q, u), -9.81 * math.sin(0.3)))
        self.assertFalse(np.allclose(longer.forward_dynamics(q, u, tau),
                                     longer.forward_dynamics(q, u)))

    def test_refused(self):
        all_of_it = mb.Parameters(pendulum())
        with self.assertRaises(KeyError):
            all_of_it.model({"bodies.rod.weight": 1.0})
        with self.assertRaisesRegex(mb.UseError, "mass"):
            all_of_it.model({"bodies.rod.mass": -1.0})
        with self.assertRaises(IndexError):
            all_of_it.record(len(all_of_it))
        all_of_it.close()
        with self.assertRaises(mb.ClosedError):
            all_of_it["bodies.rod.mass"]

    def test_a_model_outlives_its_list(self):
        made = mb.Parameters(chain()).model({})
        q, u = start(made)
        self.assertTrue(np.array_equal(made.data().mass_matrix(q), chain().data().mass_matrix(q)))


@there("linear")
class Linear(unittest.TestCase):
    def test_a_pendulum_comes_to_rest_and_swings(self):
        model = pendulum(0.2)
        rest, forces, info = mb.linear.equilibrium(model, np.array([0.4]))
        self.assertAlmostEqual(rest[0], 0.0, 9)
        self.assertEqual(forces.size, 0)
        self.assertGreater(info.iterations, 0)
        one = mb.linear.Linear(model, rest, inputs=[0], outputs=[0])
        named = mb.linear.Linear(model, rest, inputs=["bodies.rod.tau", "bodies.rod.mass"],
                                 outputs=["bodies.rod.q"])
        self.assertTrue(np.allclose(named.response(0.3)[:, :1], one.response(0.3), atol=0))
        self.assertLess(abs(named.response(0.3)[0, 1]), 1e-12)  # it hangs at rest
        with self.assertRaisesRegex(mb.Error, "there is none|no "):
            mb.linear.Linear(model, rest, inputs=["bodies.rod.colour"])
        # m l^2 q'' + d q' + m g l q = w
        inertia, damping, stiffness = 0.5, 0.2, 2.0 * 9.81 * 0.5
        s = np.roots([inertia, damping, stiffness])
        self.assertTrue(np.allclose(np.sort_complex(np.linalg.eigvals(one.Ar)), np.sort_complex(s)))
        (mode,) = one.modes()
        self.assertAlmostEqual(mode.real, s[0].real, 7)
        self.assertAlmostEqual(mode.frequency, abs(s[0].imag) / (2 * math.pi), 7)
        self.assertAlmostEqual(abs(mode.shape[0]), 1.0, 12)
        iw = 2j * math.pi * 0.5
        wanted = 1 / (inertia * iw**2 + damping * iw + stiffness)
        self.assertTrue(np.allclose(one.response(0.5), wanted, rtol=1e-6))
        kinetic, potential, dissipated = mb.linear.participation(model, rest, mode)
        self.assertAlmostEqual(kinetic[0], 1.0, 6)
        self.assertAlmostEqual(abs(potential).sum(), 1.0, 6)
        self.assertAlmostEqual(abs(dissipated).sum(), 1.0, 6)

    def test_views_outlive_the_object(self):
        model = pendulum(0.2)
        one = mb.linear.Linear(model, np.zeros(1))
        matrix, copy = one.A, one.A.copy()
        one.close()
        del one
        self.assertTrue(np.array_equal(matrix, copy))
        self.assertEqual(matrix.shape[0], matrix.shape[1])

    def test_few_modes_are_those_of_the_matrices(self):
        model = chain(6, massless=None)
        rest, _, _ = mb.linear.equilibrium(model, model.finish().start())
        all_modes = mb.linear.Linear(model, rest).modes()
        few = mb.linear.modes_near(model, rest, count=3)
        self.assertEqual(len(few), 3)
        for ours, theirs in zip(few, all_modes):
            self.assertAlmostEqual(ours.real, theirs.real, 6)
            self.assertAlmostEqual(ours.imaginary, theirs.imaginary, 6)
            self.assertEqual(ours.shape.shape, (6,))

    def test_trim_finds_a_preload(self):
        model = mb.Model()
        model.add_body("rod", mb.joint.revolute(axis=Y), mb.inertia.point_mass(2.0, (0.5, 0, 0)))
        model.add_force(mb.force.gravity(0, 0, -9.81))
        model.add_force(mb.force.joint_spring(0, 0, 30.0, 0.1, 0.0), name="spring")
        name = "forces.spring.rest"
        everything = mb.Parameters(model)
        self.assertIn(name, everything, [one.name for one in everything])
        rest, values, _ = mb.linear.trim(everything, np.zeros(1), [name], "all")
        self.assertEqual(rest[0], 0.0)
        tau = everything.model(values).data().inverse_dynamics(np.zeros(1), np.zeros(1),
                                                               np.zeros(1))
        self.assertAlmostEqual(tau[0], 0.0, 8)

    def test_refused(self):
        model = pendulum()
        with self.assertRaisesRegex(TypeError, "there is no 'steps'"):
            mb.linear.equilibrium(model, np.zeros(1), steps=3)
        with self.assertRaisesRegex(ValueError, "shape"):
            mb.linear.equilibrium(model, np.zeros(2))
        with self.assertRaises(mb.UseError):
            mb.linear.Linear(model, np.zeros(1), inputs=[7])


@there("contact")
class Contact(unittest.TestCase):
    def ball(self):
        model, contacts = mb.Model(), mb.Contacts()
        ball = model.add_body("ball", mb.joint.translational(), mb.inertia.point_mass(3.0))
        model.add_force(mb.force.gravity(0, 0, -9.81))
        law = {"stiffness": 1e4, "exponent": 1.0, "damping": 20.0}
        contacts.add("plane", law=law, name="floor")
        contacts.add("sphere", 0.1, ball, law=law)
        return model, contacts, model.add_force(contacts.force())

    def test_shapes_have_frames(self):
        for frame in ((0.0, 0.0, 0.5), mb.Frame((0.0, 0.0, 0.5), axis=(1, 0, 0), angle=0.0)):
            model, contacts = mb.Model(), mb.Contacts()
            ball = model.add_body("ball", mb.joint.translational(), mb.inertia.point_mass(3.0))
            contacts.add("plane", frame=frame, law={"stiffness": 1e4})
            contacts.add("sphere", 0.1, ball, law={"stiffness": 1e4})
            force, data = model.add_force(contacts.force()), model.data()
            data.velocities(np.array([0.0, 0.0, 0.59]), np.zeros(3))
            point, = mb.Contacts.report(data, force)
            self.assertAlmostEqual(point.depth, 0.01)

    def test_a_ball_rests_on_the_floor(self):
        model, contacts, force = self.ball()
        contacts.close()  # the model keeps it
        sim = mb.Simulation(model, np.array([0.0, 0.0, 0.12]))
        sim.to(3.0)
        data = model.data()
        data.velocities(sim.q, sim.u)
        (point,) = mb.Contacts.report(data, force)
        self.assertAlmostEqual(point.normal_force, 3 * 9.81, 3)
        self.assertAlmostEqual(abs(point.normal[2]), 1.0, 12)
        self.assertAlmostEqual(point.depth, 3 * 9.81 / 5e3, 6)

    def test_refused(self):
        contacts = mb.Contacts()
        with self.assertRaisesRegex(ValueError, "there is no shape 'cone'"):
            contacts.add("cone")
        with self.assertRaisesRegex(mb.UseError, "size"):
            contacts.add("sphere", -1.0, 0)
        with self.assertRaisesRegex(TypeError, "there is no 'colour'"):
            contacts.add("plane", colour=1)
        contacts.close()
        with self.assertRaises(mb.ClosedError):
            contacts.add("plane")

    def test_shapes_of_a_file(self):
        model, force = mb.touching(mb.read(MODELS / "gripper.xml"))
        data = model.data()
        data.velocities(model.start(), np.zeros(model.nu))
        self.assertIsInstance(mb.Contacts.report(data, force), list)

    def test_what_is_drawn_into_each_other_never_touches(self):
        file = mb.read(MODELS / "suspension.xml")
        model, force = mb.touching(file)
        data = model.data()
        data.velocities(file.q0, np.zeros(model.nu))
        weight = 9.81 * data.momentum()[0]
        self.assertLess(sum(point.normal_force for point in mb.Contacts.report(data, force)), weight)


@there("fmu")
class Fmu(unittest.TestCase):
    def test_an_archive_with_a_description(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "pendulum.fmu")
            why = mb.export_fmu(pendulum(), path, name="pendulum")
            self.assertEqual(why, "")
            with zipfile.ZipFile(path) as archive:
                self.assertIsNone(archive.testzip())
                description = archive.read("modelDescription.xml").decode()
            self.assertIn('modelName="pendulum"', description)

    def test_refused(self):
        with self.assertRaises(mb.UseError):
            mb.export_fmu(pendulum(), "/dev/null", version=4)
        with self.assertRaisesRegex(TypeError, "there is no 'format'"):
            mb.export_fmu(pendulum(), "/dev/null", format=2)



def lattice(cells):
    """A bar of cubes of springs along x: nodes, stiffness, masses."""
    places = np.array([(x, y, z) for x in range(cells + 1) for y in (0, 1) for z in (0, 1)], float)
    K = np.zeros((3 * len(places),) * 2)
    for i, a in enumerate(places):
        for j, b in enumerate(places[:i]):
            along = a - b
            if max(abs(along)) > 1.0:
                continue
            part = 500.0 * np.outer(along, along) / (along @ along)
            for k, l, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                K[3 * k:3 * k + 3, 3 * l:3 * l + 3] += sign * part
    return 0.3 * places, K, np.repeat(0.1 + 0.02 * np.arange(len(places)), 3)


class Flexible(unittest.TestCase):
    def frequencies(self, model, count):
        model.finish()
        q = np.zeros(model.nq)
        if model.nq > model.nu:
            q[0] = 1.0
        found = [mode.frequency for mode in mb.linear.Linear(model, q).modes()]
        return sorted(one for one in found if one > 1e-3)[:count]

    @there("linear")
    def test_a_beam_sways_as_euler_says(self):
        beam = mb.Flex.beam(length=2.0, density=0.5, EI_y=30.0, modes=3)
        self.assertEqual((beam.modes, beam.markers), (3, 16))
        model = mb.Model()
        body = model.add_flexible("beam", beam)
        tip = model.add_marker("tip", body, 15)
        roots = np.array([1.87510406871, 4.69409113297])
        right = roots ** 2 * math.sqrt(30.0 / 0.5) / 4.0 / (2.0 * math.pi)
        self.assertTrue(np.allclose(self.frequencies(model, 2), right, rtol=1e-5))
        with self.assertRaisesRegex(ValueError, "s: expected 3"):
            beam.mass_matrix([0.0])
        M = beam.mass_matrix(np.zeros(3))
        self.assertAlmostEqual(M[3, 3], 1.0, 9)
        data = model.data()
        data.forward_dynamics(np.zeros(3), np.zeros(3))
        self.assertTrue(np.allclose(data.frame(tip).x, [2.0, 0.0, 0.0]))

    @there("linear")
    @there("fe")
    def test_finite_elements_keep_their_frequencies(self):
        nodes, K, masses = lattice(4)
        markers = {"root": [0, 1, 2, 3], "tip": [16, 17, 18]}
        flex = mb.Flex.elements(K, np.diag(masses), nodes, markers, ["tip"], modes=6, free=1,
                                cutoff=math.inf)
        self.assertGreaterEqual(flex.report.modes, 6)
        self.assertAlmostEqual(flex.report.mass, masses.sum() / 3.0, 9)
        model = mb.Model()
        model.add_flexible("bar", flex, joint=mb.joint.free())
        root = np.sqrt(masses)
        omega2 = np.linalg.eigvalsh(K / np.outer(root, root))[6:10]
        self.assertTrue(np.allclose(self.frequencies(model, 4), np.sqrt(omega2) / (2.0 * math.pi),
                                    rtol=1e-7))

    @there("fe")
    def test_wrong_elements_are_refused(self):
        nodes, K, masses = lattice(1)
        markers = {"root": [0, 1, 2, 3]}
        with self.assertRaisesRegex(ValueError, "square"):
            mb.Flex.elements(K[:, :-1], np.diag(masses), nodes, markers)
        with self.assertRaisesRegex(ValueError, "no marker 'tip'"):
            mb.Flex.elements(K, np.diag(masses), nodes, markers, ["tip"])
        with self.assertRaisesRegex(ValueError, "count x 3"):
            mb.Flex.elements(K, np.diag(masses), nodes.T, markers)
        with self.assertRaises(mb.UseError):
            mb.Flex.elements(K + np.eye(24), np.diag(masses), nodes, markers)
        with self.assertRaises(mb.UseError):
            mb.Flex.sid(Path(__file__))


if __name__ == "__main__":
    unittest.main()
