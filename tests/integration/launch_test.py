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
        """Process numbers of the servers that run in this test's session, without their children."""
        found, parents = [], {}
        for folder in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
                parents[int(folder.name)] = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except (NotADirectoryError, FileNotFoundError, ProcessLookupError):
                continue
            is_server = words[0].endswith((b"/sim_server", b"/haptic_server", b"/scene_viewer"))
            if is_server and self.session.encode() in words:
                found.append(int(folder.name))
        return [pid for pid in found if parents[pid] not in found]

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

    def test_a_program_that_is_not_built_is_told_with_what_builds_it(self):
        (self.folder / "bin").mkdir()
        for name in ("sim_server", "haptic_server"):
            (self.folder / "bin" / name).symlink_to("/bin/true")
        launch = self.start(daemons.ROOT / "scripts" / "launch", "--build", self.folder, "wall", "--view")
        self.assertEqual(launch.wait(), BAD_INPUT)
        self.assertRegex("\n".join(launch.lines()), r"\Alaunch: no program \S*/bin/scene_viewer: run scripts/build demo_view,")

    def test_lockstep_runs_both_to_their_end(self):
        launch = self.launch("wall", "--duration", 2, "--lockstep", "--report-dir", self.folder)
        self.assertEqual(launch.wait(20.0), DONE, launch.lines())
        self.assertEqual(daemons.read_report(self.folder / "haptic.json")["ticks"], 2000)
        self.assertEqual(daemons.read_report(self.folder / "sim.json")["steps"], 60)

    def test_without_a_device_the_scenes_own_hand_leads_the_tool(self):
        recording = self.folder / "recording.csv"
        launch = self.launch("sewn_ball", "--duration", 2, "--lockstep", "--record", recording)
        self.assertEqual(launch.wait(20.0), DONE, launch.lines())
        self.assertGreater(daemons.read_recording(recording)["contacts"].max(), 0)

    def test_a_hand_each_runs_with_a_device_a_recording_and_a_report_of_its_own(self):
        recording = self.folder / "felt.csv"
        launch = self.launch("block_pinched", "--lockstep", "--duration", 1, "--hand", "left", "--hand",
                             "right=phantom:path=still,profile=touchx", "--record", recording, "--report-dir",
                             self.folder)
        self.assertEqual(launch.wait(20.0), DONE, launch.lines())
        self.assert_nobody_left()
        for name in ("left", "right"):
            self.assertEqual(daemons.read_report(self.folder / f"haptic.{name}.json")["ticks"], 1000)
            self.assertEqual(len(daemons.read_recording(self.folder / f"felt.{name}.csv")["time_s"]), 1000)

    def test_a_record_that_is_refused_is_the_one_line_in_lockstep_too_and_leaves_no_file(self):
        recording = self.folder / "run.csv"
        (self.folder / "run.csv-metadata.json").mkdir()
        for refused in ("/dev/full", "/absent/run.csv", self.folder, recording, self.folder / "run.csv.gz"):
            launch = self.launch("wall", "--lockstep", "--duration", 1, "--record", refused)
            self.assertEqual(launch.wait(10.0), BAD_INPUT, launch.lines())
            (line,) = launch.lines()
            self.assertRegex(line, f"^haptic_server: --record: .*{refused}")
        self.assertEqual([file.name for file in self.folder.glob("run*")], ["run.csv-metadata.json"])

    def test_the_ending_of_a_recording_stays_that_of_each_hand(self):
        both = ("block_pinched", "--lockstep", "--duration", 0.1, "--hand", "left", "--hand", "right", "--record")
        launch = self.launch(*both, self.folder / "felt.MCAP")
        self.assertEqual(launch.wait(20.0), DONE, launch.lines())
        for name in ("left", "right"):
            self.assertTrue((self.folder / f"felt.{name}.MCAP").read_bytes().startswith(b"\x89MCAP"))
        launch = self.launch(*both, self.folder / "felt.csv.gz")
        self.assertEqual(launch.wait(20.0), BAD_INPUT, launch.lines())
        self.assertRegex(launch.lines()[0], r"--record: value '.*felt\.csv\.gz': expected FILE\.csv")

    def test_Ctrl_C_ends_both_and_both_write_their_reports(self):
        launch = self.start_both("--report-dir", self.folder)
        time.sleep(0.5)
        launch.signal(signal.SIGINT)
        self.assertEqual(launch.wait(10.0), DONE, launch.lines())
        self.assert_nobody_left()
        self.assertGreater(daemons.read_report(self.folder / "haptic.json")["ticks"], 100)
        self.assertGreater(daemons.read_report(self.folder / "sim.json")["steps"], 1)

    def test_a_bad_scene_ends_both_with_its_status(self):
        launch = self.launch(str(self.write("bad.toml", "format = 9\n")))
        self.assertEqual(launch.wait(10.0), BAD_INPUT, launch.lines())
        self.assertEqual(len(launch.lines()), 1, launch.lines())
        self.assert_nobody_left()

    def test_a_scene_that_is_not_there_is_told_with_those_that_ship(self):
        launch = self.launch("tisue_and_blocks")
        self.assertEqual(launch.wait(10.0), BAD_INPUT, launch.lines())
        (line,) = launch.lines()
        self.assertRegex(line, "tisue_and_blocks: no such scene: .* threads, tissue_and_blocks, wall$")

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

    def test_a_viewer_beside_them_sees_the_session_and_ends_with_it(self):
        view = self.folder / "session.view"
        launch = self.launch("wall", "--duration", 2, "--viewer", f"--port 0 --save {view}")
        self.assertEqual(launch.wait(20.0), DONE, launch.lines())
        self.assert_nobody_left()
        self.assertIn(b'"sim":"alive","hand":"alive"', view.read_bytes())

    def test_a_viewer_that_cannot_start_leaves_the_session_alone(self):
        launch = self.launch("wall", "--duration", 0.5, "--viewer", "--port none",
                             "--report-dir", self.folder)
        self.assertEqual(launch.wait(20.0), DONE, launch.lines())
        self.assertGreater(daemons.read_report(self.folder / "haptic.json")["ticks"], 250)

    def test_a_viewer_that_does_not_heed_the_end_is_killed(self):
        launch = self.launch("wall", "--viewer", "--port 0")
        self.wait_until(lambda: len(self.daemons_of_session()) == 3, 5.0, "all three run")
        tool = daemons.SHM / f"{self.session}-tool"
        self.wait_until(tool.exists, 5.0, "both daemons heed signals")
        [viewer] = [each for each in self.daemons_of_session() if pathlib.Path(
            f"/proc/{each}/cmdline").read_bytes().split(b"\0")[0].endswith(b"scene_viewer")]
        os.kill(viewer, signal.SIGSTOP)
        launch.signal(signal.SIGINT)
        self.assertEqual(launch.wait(15.0), DONE, launch.lines())
        self.assert_nobody_left()

    def test_a_launch_that_is_killed_leaves_nobody_behind(self):
        launch = self.start_both()
        launch.kill()
        self.assert_nobody_left()


if __name__ == "__main__":
    daemons.main()
