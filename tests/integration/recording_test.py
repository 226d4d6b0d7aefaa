#!/usr/bin/python3
"""What is recorded survives: a kill at any moment, a disk that is full, Ctrl-C."""
import os
import random
import signal
import subprocess
import time
import unittest

import numpy

import daemons
from daemons import BAD_INPUT, DONE, INCOMPLETE, SKIPPED
from faults import call_log
from faults.fault_run import DRIVER

TOOL_SEGMENT_BYTES = 364_544  # a limit of the size of files counts for it too
PRESS = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0.02,depth_m=0.025,period_s=1"


def whole_rows(recording):
    """Rows that have ended, below the header; -1 before that."""
    lines = recording.read_bytes().split(b"\n")[:-1]
    return sum(not line.startswith(b"#") for line in lines) - 1


class RecordingTest(daemons.SessionTest):
    def start_lockstep(self, recording, device=PRESS):
        both = ("--lockstep", "--duration", 60)
        return (self.sim_server("wall", *both),
                self.haptic_server(device, *both, "--record", recording))

    def rows_by_replay(self, recording):
        """Rows that the product's own reader takes: a replay ticks from the first to the last."""
        again = self.folder / "again.csv"
        sim = self.sim_server("wall", "--lockstep")
        hand = self.haptic_server(f"replay:file={recording}", "--lockstep", "--record", again)
        self.assertEqual(hand.wait(), DONE, hand.lines())
        sim.stop()
        return len(daemons.read_recording(again)["time_s"])

    def assert_sums_up(self, recording, report):
        """Rows on disk and rows lost are all ticks; the file ends with a whole row."""
        rows = daemons.read_recording(recording)
        report = daemons.read_report(report)
        self.assertTrue(recording.read_bytes().endswith(b"\n"))
        self.assertEqual(len(rows["time_s"]) + report["lost_rows"], report["ticks"])
        self.assertTrue((numpy.diff(rows["time_s"]) > 0.0).all())
        return report

    def test_a_kill_at_any_moment_leaves_what_an_undisturbed_run_writes_up_to_a_row(self):
        whole = self.run_lockstep("wall", PRESS, 8.0).read_bytes()
        moments = random.Random(20021001)
        replayed = 0
        for kill in range(20):
            recording = self.folder / f"killed-{kill}.csv"
            sim, hand = self.start_lockstep(recording)
            wanted_bytes = moments.choice((0, moments.uniform(0, 20e3), moments.uniform(0, 600e3)))
            self.wait_until(lambda: recording.exists() and recording.stat().st_size >= wanted_bytes,
                            10.0, f"{wanted_bytes:.0f} bytes")
            time.sleep(moments.uniform(0.0, 0.01))
            hand.signal(signal.SIGKILL)
            hand.wait()
            sim.wait()
            left = recording.read_bytes()
            shared = min(len(left), len(whole))
            self.assertEqual(left[:shared], whole[:shared], f"kill {kill}")
            rows = whole_rows(recording)
            if rows < 1:  # killed before its first row: said in one line
                with self.assertRaisesRegex(ValueError, "expected a header and a row"):
                    daemons.read_recording(recording)
                daemon = self.haptic_server(f"replay:file={recording}")
                self.assert_refused(daemon, BAD_INPUT, recording.name, "no whole")
                continue
            self.assertEqual(len(daemons.read_recording(recording)["time_s"]), rows)
            if replayed < 8:
                replayed += 1
                # A fast machine is killed late: what an earlier kill leaves is this file's beginning.
                recording.write_bytes(left[:moments.randrange(20_000, 200_000)])
                if (rows := whole_rows(recording)) > 0:
                    self.assertEqual(self.rows_by_replay(recording), rows)
        self.assertGreater(replayed, 0)

    def test_a_kill_in_real_time_loses_no_more_than_the_last_moment(self):
        self.sim_server("wall")
        moments = random.Random(7)
        for kill in range(3):
            recording = self.folder / f"killed-{kill}.csv"
            hand = self.haptic_server(PRESS, "--record", recording)
            self.wait_until(lambda: recording.exists() and recording.stat().st_size > 20_000, 5.0,
                            "rows")
            rows_before = whole_rows(recording)
            time.sleep(moments.uniform(0.05, 0.25))
            rows_later = whole_rows(recording)
            hand.signal(signal.SIGKILL)
            hand.wait()
            time_s = daemons.read_recording(recording)["time_s"]
            self.assertGreaterEqual(len(time_s), rows_later)
            self.assertGreater(rows_later, rows_before, "rows reach the disk as they come")
            self.assertTrue((numpy.diff(time_s) > 0.0).all())

    def test_interrupt_writes_every_row(self):
        self.sim_server("wall")
        report = self.folder / "haptic.json"
        for end in (signal.SIGINT, signal.SIGTERM):
            recording = self.folder / f"{end.name}.csv"
            hand = self.haptic_server(PRESS, "--record", recording, "--report", report)
            self.wait_until(lambda: recording.exists() and recording.stat().st_size > 20_000, 5.0,
                            "rows")
            hand.signal(end)
            self.assertEqual(hand.wait(), DONE, hand.lines())
            self.assertEqual(self.assert_sums_up(recording, report)["lost_rows"], 0)

    def limited(self, bytes_, *arguments):
        """haptic_server whose files cannot grow beyond so many bytes, a tool's segment at least."""
        self.assertGreater(bytes_, TOOL_SEGMENT_BYTES)
        return self.start("prlimit", f"--fsize={bytes_}", daemons.BUILD / "bin" / "haptic_server",
                          "--session", self.session, "--device", PRESS, *arguments)

    def test_a_full_disk_does_not_stop_the_loop_and_the_rest_is_counted(self):
        self.sim_server("wall")
        report = self.folder / "haptic.json"
        for bytes_ in (400_000, 400_041):  # mostly in mid-row
            recording = self.folder / f"{bytes_}.csv"
            hand = self.limited(bytes_, "--record", recording, "--report", report, "--rate", 4000, "--duration", 1.2)
            self.assertEqual(hand.wait(), INCOMPLETE, hand.lines())
            figures = self.assert_sums_up(recording, report)
            self.assertGreater(figures["lost_rows"], 0)
            self.assertGreater(figures["force_N"]["max"], 0.0, "it went on to touch")
            self.assertRegex("\n".join(hand.lines()), "could not be written: File too large")
            self.assertIn(f"{recording}: {figures['lost_rows']} of {figures['ticks']} ticks are missing",
                          hand.lines()[-1])

    def test_a_full_disk_does_not_hold_up_lockstep(self):
        sim = self.sim_server("wall", "--lockstep", "--duration", 20)
        recording, report = self.folder / "recording.csv", self.folder / "haptic.json"
        hand = self.limited(400_000, "--record", recording, "--report", report, "--duration", 20,
                            "--lockstep")
        self.assertEqual(hand.wait(), INCOMPLETE, hand.lines())
        self.assertEqual(sim.wait(), DONE, sim.lines())
        figures = self.assert_sums_up(recording, report)
        self.assertEqual(figures["ticks"], 20_000)

    def test_a_disk_without_room_for_the_head_is_refused_before_the_loop(self):
        self.sim_server("wall")
        hand = self.haptic_server(PRESS, "--record", "/dev/full", "--duration", 5)
        self.assert_refused(hand, BAD_INPUT, "/dev/full", "No space left on device")

    def test_the_trajectory_of_the_device_is_not_recorded_over(self):
        hand = self.write("hand.csv", "time_s,x_m,y_m,z_m\n0,0,0,0.02\n1,0,0,0.01\n")
        link = self.folder / "link.csv"
        link.symlink_to(hand)
        before = hand.read_text()
        for record in (hand, link):
            refused = self.haptic_server(f"replay:file={hand}", "--record", record, "--duration", 0.1)
            self.assert_refused(refused, BAD_INPUT, "--record: value ", "expected another file than the device's file")
            self.assertEqual(hand.read_text(), before)

    def test_what_ends_before_the_first_tick_has_cost_no_earlier_recording(self):
        log = call_log.CallLog(f"/dev/shm/stillgrid-{self.session}-calls")
        log.trigger()
        self.sim_server("wall")
        before = {}
        for name in ("run.csv", "run.csv-metadata.json", "run.mcap"):
            before[self.write(name, f"the {name} before")] = f"the {name} before"
        broken = f"{DRIVER}:log={log.file},fault="
        for device, *options in ((broken + "activate_fails",), (broken + "activate_throws",), (broken + "read_fails",),
                                 (PRESS, "--commands", self.folder)):
            for name in ("run.csv", "run.mcap", "new.csv", "new.mcap"):
                hand = self.haptic_server(device, "--record", self.folder / name, *options)
                self.assertNotEqual(hand.wait(), DONE, hand.lines())
                self.assertEqual({file: file.read_text() for file in before}, before, hand.lines())
                self.assertEqual(list(self.folder.glob("new.*")), [], hand.lines())

    def test_a_report_without_room_is_one_line_and_leaves_the_old_one(self):
        self.sim_server("wall")
        hand = self.haptic_server(PRESS, "--report", "/dev/full", "--duration", 0.05)
        self.assert_refused(hand, BAD_INPUT, "/dev/full", "could not be written")
        report, recording = self.write("haptic.json", "the one before"), self.folder / "recording.csv"
        hand = self.haptic_server(PRESS, "--report", report, "--record", recording)
        self.wait_until(lambda: recording.exists() and recording.stat().st_size > 2000, 5.0, "rows")
        # What it says goes to a file too: it has room for that, not for the report.
        room_bytes = len("\n".join(hand.all_lines())) + 500
        subprocess.run(["prlimit", "--pid", str(hand.pid), f"--fsize={room_bytes}"], check=True)
        hand.signal(signal.SIGINT)
        self.assertEqual(hand.wait(), INCOMPLETE, hand.lines())
        self.assertIn("haptic.json: could not be written", hand.lines()[-1])
        self.assertEqual(report.read_text(), "the one before")
        self.assertEqual([file.name for file in self.folder.glob("haptic.json*")], ["haptic.json"])

    def test_a_disk_that_fills_up_and_is_cleared_has_cost_no_row(self):
        self.sim_server("wall")
        recording = self.folder / "copy.csv"
        report = self.folder / "haptic.json"
        disk = self.folder / "disk"
        disk.mkdir()
        # A mount of its own; a quarter of the rows fits beside the file that goes away later.
        script = ('head -c 200000 /dev/zero >"$1/other"; '
                  '(sleep 0.7; rm "$1/other") & "$2" --session "$3" --device "$4" --duration 1 --record '
                  '"$1/r.csv" --report "$6"; status=$?; cp "$1/r.csv" "$5"; exit $status')
        # Root there may mount; the server runs as who it is here, for its user's sessions.
        run = self.start("unshare", "--mount", "--map-root-user", "sh", "-c",
                         'mount -t tmpfs -o size=256k none "$7" || exit 77; exec unshare "$@"', "sh",
                         f"--map-user={os.geteuid()}", f"--map-group={os.getegid()}", "sh", "-c", script, "sh", disk,
                         daemons.BUILD / "bin" / "haptic_server", self.session, PRESS, recording, report)
        status = run.wait()
        if status in (SKIPPED, 1) and not recording.exists():
            self.skipTest("skipped: this user may not mount")
        self.assertEqual(status, DONE, run.lines())
        self.assertRegex("\n".join(run.lines()), "could not be written: No space left on device")
        self.assertEqual(self.assert_sums_up(recording, report)["lost_rows"], 0)


if __name__ == "__main__":
    daemons.main()
