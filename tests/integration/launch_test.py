#!/usr/bin/python3
"""scripts/launch starts both daemons, passes their failures on, and leaves none behind."""
import os
import pathlib
import signal
import time
import unittest

import daemons
from daemons import BAD_INPUT, DONE


class LaunchTest(daemons.SessionTest):
    def launch(self, *arguments):
        return self.start(daemons.ROOT / "scripts" / "launch", "--build", daemons.BUILD,
                          "--session", self.session, *arguments)

    def daemons_of_session(self):
        """Process numbers of the servers that run in this test's session."""
        found = []
        for folder in pathlib.Path("/proc").iterdir():
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
            except (NotADirectoryError, FileNotFoundError, ProcessLookupError):
                continue
            is_server = words[0].endswith((b"/sim_server", b"/haptic_server"))
            if is_server and self.session.encode() in words:
                found.append(int(folder.name))
        return found

    def assert_nobody_left(self):
        self.wait_until(lambda: not self.daemons_of_session(), 6.0, "all daemons ended")

    def start_both(self, *arguments):
        launch = self.launch("wall", *arguments)
        self.wait_until(lambda: len(self.daemons_of_session()) == 2, 5.0, "both daemons run")
        return launch

    def test_both_run_for_the_duration_and_write_their_reports(self):
        recording = self.folder / "recording.csv"
        launch = self.launch("wall", "--duration", 0.5, "--record", recording, "--report-dir",
                             self.folder)
        self.assertEqual(launch.wait(10.0), DONE, launch.lines())
        self.assert_nobody_left()
        self.assertGreater(daemons.read_report(self.folder / "haptic.json")["ticks"], 250)
        self.assertGreater(daemons.read_report(self.folder / "sim.json")["steps"], 5)
        self.assertGreater(len(daemons.read_recording(recording)["time_s"]), 250)

    def test_lockstep_runs_both_to_their_end(self):
        launch = self.launch("wall", "--duration", 2, "--lockstep", "--report-dir", self.folder)
        self.assertEqual(launch.wait(20.0), DONE, launch.lines())
        self.assertEqual(daemons.read_report(self.folder / "haptic.json")["ticks"], 2000)
        self.assertEqual(daemons.read_report(self.folder / "sim.json")["steps"], 60)

    def test_Ctrl_C_ends_both_and_both_write_their_reports(self):
        launch = self.start_both("--report-dir", self.folder)
        time.sleep(0.5)
        launch.signal(signal.SIGINT)
        self.assertEqual(launch.wait(10.0), DONE, launch.lines())
        self.assert_nobody_left()
        self.assertGreater(daemons.read_report(self.folder / "haptic.json")["ticks"], 100)
        self.assertGreater(daemons.read_report(self.folder / "sim.json")["steps"], 1)

    def test_a_bad_scene_ends_both_with_its_status(self):
        launch = self.launch(str(self.write("bad.toml", "format = 2\n")))
        self.assertEqual(launch.wait(10.0), BAD_INPUT, launch.lines())
        self.assertEqual(len(launch.lines()), 1, launch.lines())
        self.assert_nobody_left()

    def test_a_bad_device_ends_both_with_its_status(self):
        launch = self.launch("wall", "--device", "touch_9000")
        self.assertEqual(launch.wait(10.0), BAD_INPUT, launch.lines())
        self.assertEqual(len(launch.lines()), 1, launch.lines())
        self.assert_nobody_left()

    def test_a_killed_daemon_ends_the_other(self):
        launch = self.start_both()
        victim = max(self.daemons_of_session())
        os.kill(victim, signal.SIGKILL)
        self.assertEqual(launch.wait(10.0), 128 + signal.SIGKILL, launch.lines())
        self.assert_nobody_left()

    def test_a_launch_that_is_killed_leaves_nobody_behind(self):
        launch = self.start_both()
        launch.kill()
        self.assert_nobody_left()


if __name__ == "__main__":
    daemons.main()
