#!/usr/bin/python3
"""An instrument through a trocar, from the hand through the scene and back, in lockstep."""
import csv
import subprocess
import unittest

import numpy

import daemons
from instrument import distance_of, force_at_handle_N, rows_of, shaft_of

PIVOT_M = numpy.array([0.0, 0.0, 0.18])  # of the scene
DEVICE_M = numpy.array([0.0, 0.0, 0.29])
HAND_N_PER_M = 300.0  # hand=light
TIP_M = 0.25
# Nothing but the hand's spring stands against the force; the safety chain stays out of it.
DEVICE = ("phantom:friction_N=0,resolution_m=0,limits=0,max_force_N=20,"
          "pivot_x_m=0,pivot_y_m=0,pivot_z_m=-0.11,")
LIVER = daemons.DATA / "meshes" / "sofa_liver-smooth.obj"


def handle_m(distance_m, tilt_rad):
    """Of the device, the tip swung towards -y by the tilt."""
    return (PIVOT_M - DEVICE_M
            + distance_m * numpy.array([0.0, numpy.sin(tilt_rad), numpy.cos(tilt_rad)]))


class LaparoscopyTest(daemons.SessionTest):
    def path(self, name, rows):
        """A way of the handle through (time, distance from the pivot, tilt), at rest at its end."""
        times_s, distances_m, tilts_rad = zip(*rows)
        lines = ["time_s,x_m,y_m,z_m"]
        for time_s in numpy.arange(0.0, times_s[-1] + 0.02, 0.02):
            point_m = handle_m(numpy.interp(time_s, times_s, distances_m),
                               numpy.interp(time_s, times_s, tilts_rad))
            lines.append(",".join(f"{number:.9g}" for number in (time_s, *point_m)))
        return self.write(name, "\n".join(lines) + "\n"), point_m + DEVICE_M

    def run_path(self, name, rows, duration_s, sim=(), haptic=()):
        """The recording, and where the hand means to be at its end."""
        file, aim_m = self.path(name, rows)
        recording = self.run_lockstep("laparoscopy", f"{DEVICE}path={file}", duration_s, sim, haptic)
        return recording, daemons.read_recording(recording), aim_m

    def sweep(self, *haptic):
        """The rod goes down beside the organ and then sweeps against its side."""
        state = self.folder / "state.csv"
        run = self.run_path("sweep.csv", [(0.0, 0.14, 0.4), (0.5, 0.08, 0.4), (1.0, 0.08, 0.1)], 2.5,
                            ("--final-state", state), haptic)
        with open(state) as lines:
            y_m = [float(row["y_m"]) for row in csv.DictReader(lines) if row["body"] == "organ"]
        return *run, numpy.array(y_m)

    def assert_hand_rests(self, recording, aim_m, felt_N):
        """At the end the hand's spring holds the force at the handle, and nothing else does."""
        pull_N = HAND_N_PER_M * (aim_m - rows_of(recording, "{}_m")[-1])
        numpy.testing.assert_allclose(pull_N, -felt_N[-1], atol=0.02)

    def test_pressing_with_the_tip_is_felt_along_the_shaft(self):
        _, recording, aim_m = self.run_path("press.csv", [(0.0, 0.14, 0.0), (0.5, 0.11, 0.0)], 2.5)
        felt_N, shaft = force_at_handle_N(recording, PIVOT_M), shaft_of(recording)
        along_N = -numpy.sum(felt_N * shaft, axis=1)
        self.assertGreater(along_N[-1], 0.8)
        self.assertLess(numpy.linalg.norm(felt_N[-1] + along_N[-1] * shaft[-1]), 0.2 * along_N[-1])
        self.assert_hand_rests(recording, aim_m, felt_N)

    def test_a_shaft_that_sweeps_sideways_pushes_the_organ_and_is_felt_reversed(self):
        _, recording, aim_m, swept_y_m = self.sweep()
        _, free, _ = self.run_path("away.csv", [(0.0, 0.14, 0.4), (0.5, 0.14, 0.4)], 0.5)
        self.assertEqual(free["contacts"].max(), 0)
        still = self.folder / "still.csv"
        sim = self.sim_server("laparoscopy", "--lockstep", "--duration", 0.1, "--final-state", still)
        hand = self.haptic_server(self.still_device(0, 0, 0.05), "--lockstep", "--duration", 0.1)
        self.assertEqual((hand.wait(), sim.wait()), (daemons.DONE, daemons.DONE))
        with open(still) as lines:
            y_m = [float(row["y_m"]) for row in csv.DictReader(lines) if row["body"] == "organ"]
        self.assertGreater((swept_y_m - y_m).max(), 0.002)  # the tip goes towards +y

        force_N, felt_N = rows_of(recording, "f{}_N")[-1], force_at_handle_N(recording, PIVOT_M)
        touched_m = numpy.linalg.norm(rows_of(recording, "t{}_N_m")[-1]) / numpy.linalg.norm(force_N)
        distance_m = distance_of(recording, PIVOT_M)[-1]
        self.assertLess(force_N[1], -0.5)
        self.assertLess(touched_m, TIP_M - 0.01)  # by its side, not its tip
        lever = (distance_m - touched_m) / distance_m
        self.assertLess(lever, -0.5)
        self.assertAlmostEqual(felt_N[-1, 1] / (lever * force_N[1]), 1.0, delta=0.1)
        self.assert_hand_rests(recording, aim_m, felt_N)

    def test_the_trocar_takes_no_work(self):
        report = self.folder / "haptic.json"
        _, recording, _, _ = self.sweep("--report", report)
        felt_N, at_m = force_at_handle_N(recording, PIVOT_M), rows_of(recording, "{}_m")
        work_J = numpy.sum(felt_N[:-1] * numpy.diff(at_m, axis=0))
        commanded_J = numpy.sum(rows_of(recording, "f{}_N")[:-1] * numpy.diff(at_m, axis=0))
        given_J = daemons.read_report(report)["energy"]["given_J"]
        self.assertLess(work_J, -1e-3)
        self.assertAlmostEqual(work_J / given_J, 1.0, delta=2e-3)
        self.assertGreater(abs(commanded_J / given_J - 1.0), 0.1)  # the torque is most of it

    def test_a_recording_replays_with_the_shaft_where_it_was(self):
        file, recording, _, _ = self.sweep("--max-force", 20)
        replay = self.run_lockstep("laparoscopy", f"replay:file={file},offset_z_m={-DEVICE_M[2]}", 2.5,
                                   (), ("--max-force", 20))
        again = daemons.read_recording(replay)
        self.assertGreater(recording["contacts"].max(), 0)
        for name in ("f{}_N", "t{}_N_m"):
            numpy.testing.assert_allclose(rows_of(again, name), rows_of(recording, name), atol=1e-6)

    @unittest.skipUnless(LIVER.exists(), f"skipped: {LIVER} is absent")
    def test_a_liver_lies_in_the_scene_and_is_felt(self):
        scene = self.folder / "liver.toml"
        subprocess.run([daemons.ROOT / "scripts/make_laparoscopy.py", LIVER, scene], check=True)
        file, _ = self.path("press.csv", [(0.0, 0.14, 0.0), (0.5, 0.11, 0.0)])
        recording = daemons.read_recording(
            self.run_lockstep(scene, f"{DEVICE}path={file}", 1.0))
        self.assertGreater(force_at_handle_N(recording, PIVOT_M)[-1, 2], 0.5)


if __name__ == "__main__":
    daemons.main()
