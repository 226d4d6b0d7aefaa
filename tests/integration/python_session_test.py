#!/usr/bin/python3
"""A simulation in Python is felt: in virtual time the same on every run; killed, its force fades and comes back."""
import json
import os
import signal
import sys
import time

import numpy

import daemons
from python_test import start_python
import stillgrid

EXAMPLES = daemons.ROOT / "docs" / "examples" / "python"
sys.path.append(str(EXAMPLES))
import numpy_simulation as net  # after the path it needs

FADE_S = 0.1
# Publishes without a pause, so that a kill most often meets it in mid-write.
HURRIED = """
import numpy, sys
import stillgrid
scene = stillgrid.Scene(0.02, 20001, [stillgrid.Material(500.0)])
positions_m = numpy.zeros((20001, 3))
positions_m[1:] = numpy.random.default_rng(0).uniform(1.0, 2.0, (20000, 3))
with stillgrid.Publisher(scene, sys.argv[1]) as publisher:
    publisher.set_shapes(numpy.full(20001, 0.02))
    while True:
        publisher.set_spheres(positions_m)
        publisher.publish()
"""


class SessionTest(daemons.SessionTest):
    def run_net(self, simulate=net.simulate, scene=net.SCENE):
        session = stillgrid.replay(scene, EXAMPLES / "press.csv", simulate, options="resample=cubic")
        self.assertGreater((session.recording["contacts"] > 0).mean(), 0.2, "the net is touched")
        return session

    def test_two_runs_of_a_simulation_in_virtual_time_feel_the_same_to_the_last_bit(self):
        first, second = self.run_net().recording, self.run_net().recording
        for name in first.columns:
            self.assertTrue((first[name] == second[name]).all(), name)

    def test_the_hand_feels_the_opposite_of_what_the_bodies_are_pushed_by(self):
        given_N_s = numpy.zeros(3)

        class Counting:
            """A Publisher that adds up what it is told."""

            def __init__(self, publisher):
                self.publisher = publisher

            def __getattr__(self, name):
                return getattr(self.publisher, name)

            def pushes(self):
                pushes = self.publisher.pushes()
                given_N_s[:] += net.PERIOD_s * pushes.force_N.sum(axis=0)
                return pushes

        recording = self.run_net(lambda publisher: net.simulate(Counting(publisher))).recording
        felt_N_s = 0.001 * recording.rendered_force_N.sum(axis=0)
        self.assertGreater(felt_N_s[2], 0.1)
        self.assertLess(numpy.linalg.norm(felt_N_s + given_N_s), 0.1 * numpy.linalg.norm(felt_N_s),
                        f"felt {felt_N_s}, given {given_N_s} N s")

    def test_a_session_of_a_scene_file_returns_recording_and_both_reports(self):
        with stillgrid.Session(daemons.SCENES / "wall.toml", device=self.still_device(0, 0, 0.003),
                               lockstep=True, duration_s=0.5) as session:
            self.assertTrue(session.wait(30))
        self.assertEqual(len(session.recording), 500)
        self.assertEqual(session.report["ticks"], 500)
        self.assertGreater(session.simulation_report["steps"], 10)
        self.assertAlmostEqual(session.recording.force_norm_N()[-1], 2.0, 2)
        self.assertEqual(session.recording.metadata["scene"], session.report["scene"])

    def test_what_a_program_refuses_is_an_exception_with_its_line(self):
        for arguments, program, words in (
                ({"scene": self.write("bad.toml", "[scene]\nwrong = 1\n")}, "sim_server", "bad.toml"),
                ({"scene": daemons.SCENES / "wall.toml", "device": "nobody"}, "haptic_server", "nobody")):
            with self.subTest(program), self.assertRaisesRegex(stillgrid.DaemonError, words) as raised:
                with stillgrid.Session(**arguments, lockstep=True, duration_s=0.1) as session:
                    session.wait(30)
            self.assertEqual(raised.exception.program, program)
        with self.assertRaisesRegex(stillgrid.DaemonError, "nobody"):
            with stillgrid.Session(device="nobody", lockstep=True) as session, session.publish(net.SCENE) as publisher:
                net.simulate(publisher)

    def test_an_exception_in_a_session_ends_its_programs_and_is_the_one_that_is_seen(self):
        with self.assertRaises(ZeroDivisionError):
            with stillgrid.Session(daemons.SCENES / "wall.toml") as session:
                1 / 0
        self.assertTrue(all(process.poll() is not None for process in session._running.values()))
        self.assertEqual(list(daemons.SHM.glob(f"{session.name}-*")), [])

    def test_the_force_of_a_simulation_killed_in_mid_write_fades_and_returns_with_the_next(self):
        program, record = self.write("hurried.py", HURRIED), self.folder / "recording.csv"
        with stillgrid.Session(device=self.still_device(0, 0, 0.022), name=self.session, record=record) as session:
            for _ in range(3):
                simulation = start_python(program, self.session)
                self.addCleanup(simulation.kill)
                self.wait_until(lambda: self.is_felt(session, record), 30, "the force")
                simulation.kill()
                simulation.wait()
                time.sleep(0.4)
            self.assertIsNone(session.check())
        force_N, time_s = session.recording.force_norm_N(), session.recording.time_s
        late_s = numpy.diff(time_s).max()
        full = force_N > 0.999 * force_N.max()
        self.assertEqual(force_N[-1], 0.0)
        fades = 0
        for last in numpy.flatnonzero(full[:-1] & ~full[1:]):  # the last tick in full
            gone = last + numpy.flatnonzero(force_N[last:] == 0.0)[0]
            if full[last + 1:gone].any():
                continue  # it came back before it was gone
            fades += 1
            self.assertLess(time_s[gone] - time_s[last], FADE_S + 0.01 + late_s)
            self.assertTrue((numpy.diff(force_N[last:gone]) <= 1e-9).all(), "it only falls")
        self.assertEqual(fades, 3)

    def is_felt(self, session, record):
        """In full, within the last 50 rows."""
        session.check()
        lines = record.read_text().splitlines(keepends=True) if record.exists() else []
        if len(lines) < 200:
            return False
        header = next(line for line in lines if line.startswith("time_s")).split(",")
        column = header.index("rendered_fz_N"), header.index("fz_N")
        rows = [line.split(",") for line in lines[-50:] if line.endswith("\n")]
        return all(float(row[column[1]]) > 0.1 and row[column[0]] == row[column[1]] for row in rows)


if __name__ == "__main__":
    daemons.main()
