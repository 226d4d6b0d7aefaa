#!/usr/bin/python3
"""What the 1 kHz loop calls is counted and named, and the devices that ship call nothing that may
block. Gates on counts."""
import re
import shutil
import signal
import time
import unittest

import daemons
from daemons import BAD_INPUT, DONE
from faults import call_log
from faults.fault_run import DRIVER

REALTIME_VIOLATION = 4
GUARD = daemons.BUILD / "lib" / "stillgrid" / "librealtime_guard.so"
BLOCKS = daemons.BUILD / "tests" / "haptic_server" / "bad_drivers" / "blocks.so"
HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"


class RealtimeGuardTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        if not GUARD.exists():
            self.skipTest("skipped: a sanitizer or this processor keeps the guard from being built")
        self.report = self.folder / "report.json"

    def run_over_a_restart(self, device, recording):
        """Four seconds, in whose midst the simulation is killed and replaced. Returns the report."""
        sim = self.sim_server("tissue_and_blocks")
        hand = self.haptic_server(device, "--realtime-guard", "--duration", 4, "--record",
                                  recording, "--report", self.report)
        self.wait_until(lambda: recording.exists() and recording.stat().st_size > 150_000, 10.0,
                        "a second of touching")
        sim.signal(signal.SIGKILL)
        sim.wait()
        time.sleep(0.3)
        sim = self.sim_server("tissue_and_blocks")
        status = hand.wait()
        self.assertEqual(sim.stop(), DONE, sim.lines())
        self.assertEqual(status, DONE, hand.lines())
        rows = daemons.read_recording(recording)
        self.assertIn("faded", "".join(rows["flags"]), "the kill was noticed")
        oldest = rows["age_s"].argmax()
        self.assertLess(rows["age_s"][oldest:].min(), 0.1, "the next simulation was taken up")
        self.assert_without_faults(hand)
        return daemons.read_report(self.report)

    def assert_without_faults(self, hand):
        if hand.has("locked memory"):
            self.assertEqual(daemons.read_report(self.report)["page_faults"], 0)

    def test_shipped_devices_call_nothing_that_may_block_even_over_a_restart(self):
        recording = self.folder / "recording.csv"
        devices = (HAND, f"replay:file={recording},loop=1")
        for number, device in enumerate(devices):
            with self.subTest(device=device):
                file = recording if number == 0 else self.folder / "again.csv"
                report = self.run_over_a_restart(device, file)
                self.assertEqual(report["realtime_violations"], {"total": 0})
                self.assertGreater(report["contact_ticks"], 0)

    def test_a_driver_that_blocks_is_named_with_its_call_and_its_tick(self):
        self.sim_server("wall")
        for option, call in (("malloc", "malloc"), ("mutex", "pthread_mutex_lock"),
                             ("file", "write"), ("sleep", "clock_nanosleep")):
            with self.subTest(call=call):
                hand = self.haptic_server(f"{BLOCKS}:call={option}", "--realtime-guard",
                                          "--duration", 1, "--report", self.report)
                self.assertEqual(hand.wait(), REALTIME_VIOLATION, hand.lines())
                report = daemons.read_report(self.report)
                count = report["ticks"] // 10  # it blocks at each tenth
                violations = report["realtime_violations"]
                self.assertEqual(violations[call], count)
                self.assertEqual(violations["total"], sum(violations.values()) / 2)
                line = (f"haptic_server: real-time violation: {call}, {count} times, "
                        r"first from blocks\.so\+0x[0-9a-f]+ at tick 10")
                self.assertTrue(any(re.fullmatch(line, one) for one in hand.lines()),
                                hand.lines())

    def test_a_device_that_was_stopped_for_want_of_ticks_goes_on_without_reproach(self):
        self.sim_server("wall")
        log = call_log.CallLog(f"/dev/shm/stillgrid-{self.session}-calls")
        log.trigger()
        hand = self.haptic_server(f"{DRIVER}:log={log.file},fault=read_spins", "--realtime-guard", "--duration", 2,
                                  "--report", self.report)
        self.assertEqual(hand.wait(), DONE, hand.lines())
        report = daemons.read_report(self.report)
        self.assertGreater(report["device_stops"], 0)
        self.assertGreater(report["missed_ticks"], 0)  # the stall is told
        self.assertEqual(report["realtime_violations"], {"total": 0})

    def test_without_the_guard_the_same_driver_is_not_reproached(self):
        self.sim_server("wall")
        hand = self.haptic_server(f"{BLOCKS}:call=malloc", "--duration", 0.5, "--report",
                                  self.report)
        self.assertEqual(hand.wait(), DONE, hand.lines())
        self.assertNotIn("realtime_violations", daemons.read_report(self.report))

    def test_the_guard_of_a_loop_in_virtual_time_is_refused(self):
        hand = self.haptic_server("phantom", "--realtime-guard", "--lockstep")
        self.assert_refused(hand, BAD_INPUT, "--realtime-guard", "--lockstep")

    def test_a_program_without_its_guard_beside_it_says_so(self):
        program = self.folder / "bin" / "haptic_server"
        program.parent.mkdir()
        shutil.copy(daemons.BUILD / "bin" / "haptic_server", program)
        hand = self.start(program, "--session", self.session, "--device", "phantom",
                          "--realtime-guard")
        self.assert_refused(hand, BAD_INPUT, "--realtime-guard", GUARD.name)

    def test_a_guarded_run_ends_at_Ctrl_C_with_its_report(self):
        self.sim_server("wall")
        hand = self.haptic_server(f"{BLOCKS}:call=file", "--realtime-guard", "--report",
                                  self.report, "--record", self.folder / "recording.csv")
        self.wait_until((self.folder / "recording.csv").exists, 5.0, "haptic_server at work")
        time.sleep(0.3)
        self.assertEqual(hand.stop(), REALTIME_VIOLATION, hand.lines())
        self.assertGreater(daemons.read_report(self.report)["realtime_violations"]["write"], 0)


if __name__ == "__main__":
    daemons.main()
