#!/usr/bin/python3
"""What haptic_server does where it may not be real-time: asks RealtimeKit, and says who grants it.

RealtimeKit is a fake on a bus of its own; as root it really makes a thread real-time."""
import os
import shutil
import socket
import subprocess
import time
import unittest

import daemons
from faults import call_log
from rights_bed import WITHOUT_RIGHTS, bus_command

FAKE = daemons.BUILD / "tests" / "integration" / "fake_realtime_kit"
TISSUE = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=2"


def may_drop_rights():
    return subprocess.run([*WITHOUT_RIGHTS, "true"], capture_output=True).returncode == 0


@unittest.skipUnless(os.geteuid() == 0 and may_drop_rights(), "needs root, to grant and to be without")
@unittest.skipUnless(shutil.which("dbus-daemon"), "needs dbus-daemon")
class RightsTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.address = self.folder / "bus"
        os.environ["DBUS_SYSTEM_BUS_ADDRESS"] = f"unix:path={self.address}"
        self.addCleanup(os.environ.pop, "DBUS_SYSTEM_BUS_ADDRESS")

    def start_bus(self, mode):
        self.start(*bus_command(self.folder, self.address))
        self.wait_until(self.address.exists, 5, "a bus")
        fake = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", FAKE, mode], stdout=subprocess.PIPE, text=True)
        self.addCleanup(fake.stdout.close)
        self.addCleanup(fake.wait)
        self.addCleanup(fake.kill)
        self.assertEqual(fake.stdout.readline(), "ready\n")

    def run_without_rights(self, device=TISSUE, status=daemons.DONE, duration_s=0.3, prefix=WITHOUT_RIGHTS):
        """The report's scheduling, and the lines."""
        self.sim_server("tissue_and_blocks", "--duration", duration_s + 8)
        report = self.folder / "haptic.json"
        hand = self.start(*prefix, daemons.BUILD / "bin" / "haptic_server", "--session", self.session,
                          "--device", device, "--duration", duration_s, "--report", report)
        self.assertEqual(hand.wait(), status, hand.lines())
        lines = hand.all_lines()
        return daemons.read_report(report)["scheduling"], [line for line in lines if "running without" in line], lines

    def assert_other(self, scheduling, warnings, *words):
        self.assertEqual((scheduling["way"], scheduling["priority"]), ("other", 0))
        self.assertEqual(len(warnings), 1, warnings)
        for word in ("real-time priority and locked memory", "docs/realtime.md#rights", *words):
            self.assertIn(word, warnings[0])

    def test_where_fifo_is_refused_realtime_kit_grants_its_20(self):
        self.start_bus("grants")
        scheduling, warnings, _ = self.run_without_rights()
        self.assertEqual((scheduling["way"], scheduling["priority"], scheduling["was_demoted"]), ("rtkit", 20, False))
        self.assertEqual(len(warnings), 1)
        self.assertNotIn("priority", warnings[0], "memory alone is missing")

    def test_a_devices_own_thread_gets_it_too(self):
        self.start_bus("grants")
        scheduling, _, _ = self.run_without_rights(f"{TISSUE},pace=device")
        self.assertEqual((scheduling["way"], scheduling["priority"]), ("rtkit", 20))

    def test_what_it_answers_is_bounded(self):
        self.start_bus("says_99")
        scheduling, _, _ = self.run_without_rights()
        self.assertEqual((scheduling["way"], scheduling["priority"]), ("rtkit", 20))

    def test_its_refusal_is_told_in_one_line(self):
        self.start_bus("refuses")
        scheduling, warnings, _ = self.run_without_rights()
        self.assert_other(scheduling, warnings, "RealtimeKit: the session is not active")

    def test_answers_that_cannot_be_are_refused(self):
        for mode, words in (("says_minus_1", "priority -1"), ("says_no_time", "for -5 us"),
                            ("does_nothing", "the thread has none")):
            with self.subTest(mode=mode):
                self.start_bus(mode)
                scheduling, warnings, _ = self.run_without_rights()
                self.assert_other(scheduling, warnings, words)
                self.tearDown()
                self.doCleanups()
                self.setUp()

    def test_nobody_waits_for_long_for_a_service_that_does_not_answer(self):
        self.start_bus("hangs")
        scheduling, warnings, _ = self.run_without_rights()
        self.assert_other(scheduling, warnings, "RealtimeKit: ")

    def test_nobody_waits_for_long_for_a_bus_that_says_nothing(self):
        with socket.socket(socket.AF_UNIX) as mute:
            mute.bind(str(self.address))
            mute.listen()
            began = time.monotonic()
            scheduling, warnings, _ = self.run_without_rights()
            self.assertLess(time.monotonic() - began, daemons.PATIENCE * 20, "sd_bus alone waits for 90 s")
        self.assert_other(scheduling, warnings, "RealtimeKit: no system bus")

    def test_without_a_bus_nothing_is_lost(self):
        scheduling, warnings, _ = self.run_without_rights()
        self.assert_other(scheduling, warnings, "RealtimeKit: no system bus", "root here has no CAP_SYS_NICE")

    def test_a_loop_that_never_rests_loses_its_priority_and_not_its_process(self):
        self.start_bus("grants")
        faulty = daemons.BUILD / "tests" / "integration" / "faults" / "faulty_driver.so"
        log = call_log.CallLog(self.folder / "calls")
        log.trigger()
        scheduling, _, lines = self.run_without_rights(f"{faulty}:log={log.file},fault=read_spins", duration_s=1)
        self.assertEqual((scheduling["way"], scheduling["was_demoted"]), ("rtkit", True), lines)
        self.assertIn("the device was stopped", "".join(lines))

    def test_who_is_not_in_the_group_is_told_how_to_come_in(self):
        """device_check says what the servers say; it needs no session, so that any user can run it."""
        check = (daemons.copy_for_others(self, "device_check") / "bin" / "device_check", "phantom", "--only",
                 "timing.calls", "--seconds", "0.1")
        told = subprocess.run([*map(str, (*WITHOUT_RIGHTS, *daemons.NOBODY, *check))], capture_output=True, text=True)
        self.assertRegex(told.stdout, "measured without real-time priority and locked memory: '.*stillgrid.*"
                         r" \(docs/realtime.md#rights\)", told.stderr)


if __name__ == "__main__":
    daemons.main()
