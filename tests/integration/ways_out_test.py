#!/usr/bin/python3
"""A driver that hangs, ends the program or crashes in a call before or after the ticks: one exit
status, a line that names the device, and no force. What it does in the midst of a force is in the
fault table."""
import concurrent.futures
import signal
import unittest

import daemons
from daemons import BAD_INPUT, DEVICE_FAULT, heeds
from faults import call_log
from faults.fault_run import DRIVER

LONGEST_CALL_S = 10.0
RELEASE_S = 10.0 + 2.0  # where the same call hangs there, and the next way is gone
AT_A_TIME = 4  # they mostly sleep


class Way(daemons.SessionTest):
    """One run with a fault; no test of its own."""

    def runTest(self):
        pass

    def go(self, call, how, *arguments, more=""):
        self.setUp()
        try:
            log = call_log.CallLog(f"/dev/shm/stillgrid-{self.session}-calls")
            log.trigger()
            sim = self.sim_server("wall", *(("--lockstep",) if "--lockstep" in arguments else ()))
            report = self.folder / "run.json"
            # The address sanitizer leaves signals to the program; other builds do not read it.
            environment = ("env", "ASAN_OPTIONS=handle_segv=0:handle_abort=0")
            if call == "open":
                environment += (f"FAULT_BEFORE_OPTIONS={call}_{how}",)
            hand = self.start(*environment, daemons.BUILD / "bin" / "haptic_server", "--session",
                              self.session, "--device",
                              f"{DRIVER}:log={log.file},fault={call}_{how}{more}", "--duration",
                              0.3, "--report", report, *arguments)
            status = hand.wait(LONGEST_CALL_S + RELEASE_S + 10.0)
            records = log.records()
            force_N = call_log.force_norms_N(records)[-1] if len(records) else 0.0
            sim.stop()
            return status, hand.lines(), force_N, report.exists()
        finally:
            self.tearDown()


def go_all(ways):
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        return list(pool.map(lambda way: Way().go(*way), ways))


class WaysOutTest(unittest.TestCase):
    def assert_ended(self, way, outcome, status):
        ended, lines, force_N, has_report = outcome
        with self.subTest(way=way):
            self.assertEqual(ended, status, lines)
            self.assertTrue(any("faulty" in line for line in lines), lines)
            self.assertEqual(force_N, 0.0)
            if way[0] == "close":
                self.assertTrue(has_report)

    def test_a_call_that_ends_the_program_is_no_success(self):
        statuses = {"exits": DEVICE_FAULT, "exits_at_once": DEVICE_FAULT,
                    "aborts": 128 + signal.SIGABRT, "crashes": 128 + signal.SIGSEGV}
        ways = [(call, how) for call in ("open", "activate", "deactivate", "close")
                for how in statuses]
        for way, outcome in zip(ways, go_all(ways)):
            self.assert_ended(way, outcome, statuses[way[1]])

    def test_a_call_that_hangs_ends_the_program(self):
        ways = [(call, "hangs_for_ever") for call in ("open", "activate", "deactivate", "close")]
        for way, outcome in zip(ways, go_all(ways)):
            self.assert_ended(way, outcome, DEVICE_FAULT)

    def test_a_deactivate_that_fails_is_a_device_fault(self):
        for how in ("fails", "throws"):
            way = ("deactivate", how)
            self.assert_ended(way, Way().go(*way), DEVICE_FAULT)

    def test_lockstep_refuses_a_device_that_may_have_motors(self):
        status, lines, _, _ = Way().go("nothing", "wrong", "--lockstep")
        self.assertEqual(status, BAD_INPUT, lines)
        self.assertEqual(len(lines), 1, lines)
        self.assertIn("STILLGRID_DEVICE_NO_MOTORS", lines[0])

    def test_a_device_without_motors_is_not_released(self):
        for arguments in ((), ("--lockstep",)):
            way = ("read", "exits_at_once")
            status, lines, _, _ = Way().go(*way, *arguments, more=",no_motors=1")
            self.assertEqual(status, DEVICE_FAULT, lines)
            self.assertEqual(len(lines), 1, lines)
            self.assertTrue(lines[0].endswith("a call ended its process, with exit status 0"), lines)


class SignalTest(daemons.SessionTest):
    def test_each_signal_that_may_be_heeded_ends_the_program_by_its_name(self):
        rare = [signal.SIGQUIT, signal.SIGUSR1, signal.SIGUSR2, signal.SIGALRM, signal.SIGVTALRM,
                signal.SIGPROF, signal.SIGXCPU, signal.SIGIO, signal.SIGPWR, signal.SIGRTMIN,
                signal.SIGRTMAX]
        waiting = [self.haptic_server("phantom") for _ in rare]
        for number, hand in zip(rare, waiting):
            self.wait_until(lambda: hand.pid != hand.process.pid and heeds(hand.pid, number), 5.0,
                            "its handlers")
            hand.signal(number)
            self.assertEqual(hand.wait(5.0), 128 + number, hand.lines())
            self.assertIn(f"ended by signal {int(number)} ", hand.lines()[0])


if __name__ == "__main__":
    daemons.main()
