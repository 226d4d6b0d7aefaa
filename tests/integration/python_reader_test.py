#!/usr/bin/python3
"""A Reader in Python sees what a Publisher and a haptic_server publish; a mesh becomes spheres."""
import unittest

import numpy

import daemons
import python_test  # for the library's place
import stillgrid

MATERIALS = [stillgrid.Material(500.0, 1.0, 0.25), stillgrid.Material(250.0)]
PLANES = [stillgrid.Plane((0.0, 0.0, 1.0), -0.5, 1, 7)]
CUBE_m = 0.01 * numpy.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
CUBE_TRIANGLES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                  [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]


class ReaderTest(daemons.SessionTest):
    def test_a_session_that_is_not_there_is_nothing_and_no_error(self):
        with stillgrid.Reader(self.session) as reader:
            state = reader.poll()
            self.assertFalse(state.is_published or state.is_felt)
            for read in (reader.fixed, reader.snapshot, reader.static, reader.displayed, reader.tool):
                self.assertIsNone(read())
        with self.assertRaisesRegex(stillgrid.StillgridError, "not closed"):
            reader.poll()

    def test_what_is_read_is_what_was_published(self):
        hand = stillgrid.Hand(tool_m=[[0, 0, 0.25, 0.5], [0, 0, 0, 0.125]], device_position_m=(1.0, 2.0, 3.0))
        static = stillgrid.StaticSpheres([[8.0, 9.0, 10.0]], [0.25], [1], [3])
        scene = stillgrid.Scene(0.02, 4, MATERIALS, PLANES, static, [hand], name="read")
        positions, velocities = numpy.arange(6.0).reshape(2, 3) / 4, numpy.ones((2, 3)) / 2
        with stillgrid.Publisher(scene, self.session) as publisher, stillgrid.Reader(self.session) as reader:
            publisher.set_shapes([0.5, 0.25], [0, 1], [5, 6])
            publisher.set_spheres(positions, velocities)
            publisher.publish()
            state = reader.poll()
            self.assertEqual((state.scene_name, state.is_published, state.is_felt, state.is_virtual_time,
                              state.sphere_capacity, state.static_count), ("read", True, False, False, 4, 1))
            self.assertAlmostEqual(state.publication_period_s, 0.02)
            snapshot = reader.snapshot()
            there = ~numpy.isnan(snapshot.positions_m[:, 0])
            self.assertEqual(there.sum(), 2)
            for name, values in (("positions_m", positions), ("velocities_m_s", velocities), ("radii_m", [0.5, 0.25]),
                                 ("materials", [0, 1]), ("bodies", [5, 6])):
                numpy.testing.assert_array_equal(getattr(snapshot, name)[there], values, name)
            fixed, spheres = reader.fixed(), reader.static()
        self.assertEqual(fixed.materials, MATERIALS)
        self.assertEqual(fixed.planes, PLANES)
        numpy.testing.assert_array_equal(fixed.hand.tool_m, hand.tool_m)
        self.assertEqual(fixed.hand.device_position_m, hand.device_position_m)
        numpy.testing.assert_array_equal(spheres.positions_m, static.positions_m)
        numpy.testing.assert_array_equal(spheres.bodies, [3])

    def test_the_tool_is_read_alike_by_reader_and_publisher_and_is_that_of_the_recording(self):
        scene = stillgrid.Scene(0.02, 1, MATERIALS)
        seen = []
        with stillgrid.Session(device=self.still_device(0, 0, 0.01), lockstep=True, duration_s=0.2) as session:
            with session.publish(scene) as publisher, session.reader() as reader:
                publisher.set_shapes([0.01])
                for _ in publisher.steps():
                    publisher.set_spheres(numpy.zeros((1, 3)))
                    publisher.publish()
                    reader.poll()
                    seen.append((publisher.tool(), reader.tool()))
        recording = session.recording
        seen = [pair for pair in seen if None not in pair]
        self.assertGreater(len(seen), 5)
        for pair in seen:
            for tool in pair:
                row = numpy.flatnonzero(numpy.isclose(recording.time_s, 1e-9 * tool.time_ns, atol=1e-7))
                numpy.testing.assert_allclose(tool.position_m, recording.position_m[row[0]], atol=1e-12)
                self.assertTrue(numpy.isnan(tool.gripper_m))
        self.assertGreater(seen[-1][0].force_N[2], 1.0)


class MeshTest(unittest.TestCase):
    def test_the_spheres_of_a_cube_cover_it_within_the_tolerance(self):
        spheres, report = stillgrid.decompose(CUBE_m, CUBE_TRIANGLES, tolerance_m=0.002)
        self.assertEqual(spheres.shape[1], 4)
        self.assertLessEqual(report["hausdorff_m"], 0.002)
        centres_m, radii_m = spheres[:, :3], spheres[:, 3]
        for point in (*CUBE_m, *numpy.random.default_rng(0).uniform(-0.01, 0.01, (200, 3))):
            self.assertLess((numpy.linalg.norm(centres_m - point, axis=1) - radii_m).min(), 0.002)
        self.assertLess((abs(centres_m) + radii_m[:, None]).max(), 0.012)

    def test_an_open_mesh_and_one_that_names_no_vertex_are_refused_in_one_line(self):
        for triangles in (CUBE_TRIANGLES[4:], [[0, 1, 8]]):
            with self.assertRaises(stillgrid.StillgridError) as raised:
                stillgrid.decompose(CUBE_m, triangles, tolerance_m=0.002)
            self.assertEqual(raised.exception.code, stillgrid.Code.ARGUMENT)
            self.assertEqual(len(raised.exception.line.splitlines()), 1)
        with self.assertRaises(ValueError):
            stillgrid.decompose(CUBE_m[:, :2], CUBE_TRIANGLES, tolerance_m=0.002)


if __name__ == "__main__":
    daemons.main()
