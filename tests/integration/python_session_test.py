#!/usr/bin/python3
"""A simulation in Python is felt: in virtual time the same on every run."""
import sys

import numpy

import daemons
import python_test  # for the library's place
import stillgrid

EXAMPLES = daemons.ROOT / "docs" / "examples" / "python"
sys.path.append(str(EXAMPLES))
import numpy_simulation as pins  # after the path it needs


class SessionTest(daemons.SessionTest):
    def run_pins(self, simulate=pins.simulate, scene=pins.SCENE):
        session = stillgrid.replay(scene, EXAMPLES / "press.csv", simulate, options="resample=cubic")
        self.assertGreater((session.recording["contacts"] > 0).mean(), 0.2, "the pins are touched")
        return session

    def test_two_runs_of_a_simulation_in_virtual_time_feel_the_same_to_the_last_bit(self):
        first, second = self.run_pins().recording, self.run_pins().recording
        for name in first.columns:
            self.assertTrue((first[name] == second[name]).all(), name)

    def test_the_hand_feels_the_opposite_of_what_the_bodies_are_pushed_by(self):
        given_impulse_N_s = numpy.zeros(3)

        class Counting:
            """A Publisher that adds up what it is told."""

            def __init__(self, publisher):
                self.publisher = publisher

            def __getattr__(self, name):
                return getattr(self.publisher, name)

            def pushes(self, step_s):
                pushes = self.publisher.pushes(step_s)
                given_impulse_N_s[:] += step_s * pushes.force_N.sum(axis=0)
                return pushes

        recording = self.run_pins(lambda publisher: pins.simulate(Counting(publisher))).recording
        felt_impulse_N_s = 0.001 * recording.rendered_force_N.sum(axis=0)
        self.assertGreater(felt_impulse_N_s[2], 0.1)
        # A push is the one at its step's end, the hand's force that of each tick until then.
        off_impulse_N_s = numpy.linalg.norm(felt_impulse_N_s + given_impulse_N_s)
        self.assertLess(off_impulse_N_s, 0.12 * numpy.linalg.norm(felt_impulse_N_s))

    def test_a_simulation_that_gives_no_inertia_is_felt_and_its_report_says_that_no_tick_was_local(self):
        scene = stillgrid.Scene(0.02, 1, [stillgrid.Material(500.0)])
        device = self.still_device(0, 0, 0.022)
        with stillgrid.Session(device=device, lockstep=True, duration_s=0.3) as session:
            with session.publish(scene) as publisher:
                publisher.set_shapes([0.02])
                for _ in publisher.steps():
                    publisher.set_spheres([[0.0, 0.0, 0.0]])
                    publisher.publish()
        self.assertAlmostEqual(session.recording.force_N[-1, 2], 500.0 * 0.003, 3)
        self.assertEqual(session.report["local"]["ticks"], 0)

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
            with stillgrid.Session(device="nobody", lockstep=True) as session, session.publish(pins.SCENE) as publisher:
                pins.simulate(publisher)

    def test_an_exception_in_a_session_ends_its_programs_and_is_the_one_that_is_seen(self):
        with self.assertRaises(ZeroDivisionError):
            with stillgrid.Session(daemons.SCENES / "wall.toml") as session:
                1 / 0
        self.assertTrue(all(process.poll() is not None for process in session._running.values()))
        self.assertEqual(list(daemons.SHM.glob(f"{session.name}-*")), [])


if __name__ == "__main__":
    daemons.main()
