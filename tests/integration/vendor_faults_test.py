#!/usr/bin/python3
"""Drivers over a vendor's library, a fake of ours in its place: device_check, and each fault of docs/driver_faults.md.

With --write it runs them all and writes the page's tables anew."""
import argparse
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import unittest
import unittest.mock

import daemons
from daemons import BAD_INPUT, DEVICE_FAULT, DONE

PAGE = daemons.ROOT / "docs" / "driver_faults.md"
FAKES = daemons.BUILD / "tests" / "integration" / "vendors"
LIBRARIES = {"force_dimension": "fake_dhd", "openhaptics": "fake_hd"}
ACCOUNT = ": no force, of "  # that a run closes with
FAULT_AFTER_S = 1.2
GOES_ON_S = 2.4  # of a run that a fault does not end

# What the table calls a fault, the fake's word for it (None: an option does it), options, exit status.
START = [
    ("the library is not installed", None, "", DEVICE_FAULT),
    ("library= leads nowhere", None, "library=/absent.so", BAD_INPUT),
    ("the library lacks a function", None, "library={short}", DEVICE_FAULT),
    ("the library is of another version", "version", "", DEVICE_FAULT),
    ("no device is connected", "none", "", DEVICE_FAULT),
    ("another program has the device", "busy", "", DEVICE_FAULT),
    ("serial= of no device", None, "library={fake},serial=1", DEVICE_FAULT),
]
LATER = [
    ("the device stops answering", "lost", DEVICE_FAULT),
    ("a position is no number", "nan", DEVICE_FAULT),
    ("a position is beyond the room", "huge", DEVICE_FAULT),
    ("an orientation is no rotation", "sheared", DEVICE_FAULT),
    ("the library stands still for 0.3 s, again and again", "stall", None),
    ("the motors go off", "motors_off", DONE),
]
OWN = {
    "force_dimension": [
        ("the plug is pulled, as the status says", "unplugged", DEVICE_FAULT),
        ("the device takes no force", "no_force", DEVICE_FAULT),
        ("the dead-man is let go", "deadman", DONE),
        ("the device is in reset", "reset", DONE),
        ("the controller tells an error", "fault", DONE),
    ],
    "openhaptics": [
        ("the device is at fault", "device_fault", DEVICE_FAULT),
        ("the scheduler calls back no more", "silent", DEVICE_FAULT),
        ("a motor is predicted to be hot", "hot", DONE),
        ("warm motors (HD_WARM_MOTORS)", "warm", DONE),
        ("the greatest force is exceeded (HD_EXCEEDED_MAX_FORCE)", "max_force", DONE),
        ("the greatest speed is exceeded (HD_EXCEEDED_MAX_VELOCITY)", "max_velocity", DONE),
        ("the calibration is lost", "uncalibrated", DONE),
    ],
}
OWN_START = {
    "force_dimension": [],
    "openhaptics": [
        ("the licence is refused", "licence", "", DEVICE_FAULT),
        ("the scheduler never calls back", "no_callbacks", "", DEVICE_FAULT),
    ],
}


class Log:
    """What the fake was told; forces in newtons."""

    def __init__(self, file):
        numbers = struct.unpack("7d", file.read_bytes()) if file.exists() else (0.0,) * 7
        (self.last_N, self.greatest_N, self.at_fault_N, self.late_N, self.fault_s,
         self.zero_after, self.motors_are_on) = numbers


def end_of(status):
    return "the run goes on" if status == DONE else f"exit {status}"


def plain(line):
    """A line without what differs between machines and runs."""
    line = re.sub(r"^haptic_server: ", "", line)
    line = re.sub(r"/\S*/(fake_\w+\.so)", r"\1", line)
    return re.sub(r"\b\d+\.\d+ s\b", "T s", line)


class VendorRun(daemons.SessionTest):
    """The runs of a driver's faults; no test of its own."""

    usual = {}

    def options(self, driver, text):
        library = FAKES / f"{LIBRARIES[driver]}.so"
        short = FAKES / f"{LIBRARIES[driver]}_short.so"
        return text.format(fake=library, short=short) if text else f"library={library}"

    def run_device(self, driver, options, fault, *arguments, after_s=FAULT_AFTER_S):
        self.log_file = self.folder / f"fake-{len(self.daemons)}.log"  # of the newest run
        environment = {"STILLGRID_FAKE_FAULT": fault or "", "STILLGRID_FAKE_AFTER_S": str(after_s),
                       "STILLGRID_FAKE_LOG": str(self.log_file)}
        with unittest.mock.patch.dict(os.environ, environment):
            return self.haptic_server(f"{driver}:{options}" if options else driver, *arguments)

    def start_row(self, driver, fault, text, status):
        """A fault at the start: the line; and no force was ever told."""
        options = "" if not text and fault is None else self.options(driver, text)
        if fault == "no_callbacks":  # which shows when the motors go on, for a scene
            self.sim_server("wall")
        hand = self.run_device(driver, options, fault, "--duration", 1)
        self.assertEqual(hand.wait(), status, hand.lines())
        log = Log(self.log_file)
        self.assertEqual(log.greatest_N, 0.0)
        self.assertEqual(log.motors_are_on, 0.0)
        return self.line_of(driver, hand), f"none was told; {end_of(status)}"

    def later_row(self, driver, fault, status):
        """A fault while the tool is pressed into the wall: the line; and the force afterwards."""
        sim = self.sim_server("wall")
        self.wait_until(lambda: (daemons.SHM / f"{self.session}-scene").exists(), 5.0, "a scene")
        hand = self.run_device(driver, self.options(driver, ""), fault, "--duration", GOES_ON_S)
        ended = hand.wait()
        sim.stop()
        self.assertIn(ended, (status,) if status is not None else (DONE, DEVICE_FAULT), hand.lines())
        log = Log(self.log_file)
        self.assertGreater(log.at_fault_N, 0.3, "it was felt before")
        self.assertEqual(log.last_N, 0.0)
        self.assertEqual(log.motors_are_on, 0.0, "motors are off in the end")
        if status is None:
            return None, "the last one stays while it stands still; zero in the end"
        self.assertGreaterEqual(log.zero_after, 0)
        self.assertLessEqual(log.zero_after, 20)
        self.assertEqual(log.late_N, 0.0, "no force 20 ticks after the fault")
        limit_ms = 500 if fault == "silent" else 20  # a scheduler that is silent is noticed by the clock
        return self.line_of(driver, hand), f"zero within {limit_ms} ms; {end_of(status)}"

    def usual_lines(self, driver):
        """What a run without a fault says."""
        if driver not in self.usual:
            sim = self.sim_server("wall")
            hand = self.run_device(driver, self.options(driver, ""), None, "--duration", 0.2)
            self.assertEqual(hand.wait(), DONE, hand.lines())
            sim.stop()
            self.usual[driver] = [plain(line) for line in hand.lines()]
        return self.usual[driver]

    def line_of(self, driver, hand):
        """The one line of a fault."""
        lines = [line for line in map(plain, hand.lines())
                 if line not in self.usual_lines(driver) and ACCOUNT not in line
                 and not line.endswith(" Hz; expected 1000 Hz")]  # of a busy machine
        self.assertLessEqual(len(lines), 2 if "no tick for" in lines[0] else 1, lines)
        return "; ".join(lines)

    @staticmethod
    def row(make, *arguments):
        """A row. A busy machine may stop a driver for longer than its limits: a row that is not as expected is made
        up to three times, and a fault of ours fails each time."""
        for _ in range(2):
            try:
                return make(*arguments)
            except AssertionError:
                pass
        return make(*arguments)

    def rows_of(self, driver):
        rows = []
        for name, fault, text, status in START + OWN_START[driver]:
            with self.subTest(driver=driver, fault=name):
                rows.append((name, *self.row(self.start_row, driver, fault, text, status)))
        for name, fault, status in LATER + OWN[driver]:
            with self.subTest(driver=driver, fault=name):
                rows.append((name, *self.row(self.later_row, driver, fault, status)))
        return rows


def table_of(rows):
    lines = ["| fault | line of haptic_server | force |", "|---|---|---|"]
    for name, line, force in rows:
        lines.append(f"| {name} | {'none or several' if line is None else f'`{line}`'} | {force} |")
    return "\n".join(lines) + "\n"


def split_page(driver):
    """The page before, in and after a driver's table."""
    return re.match(rf"(.*<!-- {driver} -->\n)(.*?)(<!-- end -->.*)", PAGE.read_text(), re.S).groups()


class VendorFaultsTest(VendorRun):
    def assert_page_is_true(self, driver):
        rows = self.rows_of(driver)
        self.assertEqual(split_page(driver)[1], table_of(rows))

    def test_each_fault_of_force_dimension_has_the_line_and_the_end_that_its_table_says(self):
        self.assert_page_is_true("force_dimension")

    def test_each_fault_of_openhaptics_has_the_line_and_the_end_that_its_table_says(self):
        self.assert_page_is_true("openhaptics")


class VendorDriversTest(VendorRun):
    def test_the_drivers_over_a_vendors_library_break_no_rule_of_device_check(self):
        for driver, fake in LIBRARIES.items():
            report = self.folder / f"{driver}.json"
            subprocess.run([daemons.BUILD / "bin" / "device_check",
                            f"{driver}:library={FAKES / fake}.so", "--seconds", "0.5", "--any-force",
                            "--json", report], capture_output=True, check=False)
            checks = json.loads(report.read_text())["checks"]
            failed = [check for check in checks
                      if check["verdict"] == "FAIL" and not check["name"].startswith("timing")]
            self.assertEqual(failed, [], driver)
            self.assertIn("read.believed", [check["name"] for check in checks
                                            if check["verdict"] == "PASS"])

    def test_a_listed_device_opens_by_the_line_that_lists_it(self):
        for driver, fake in (("force_dimension", "fake_dhd"), ("openhaptics", "fake_hd")):
            for given in ("", ",index=0"):
                with self.subTest(driver, given=given):
                    device = f"{driver}:library={FAKES / fake}.so" + (given if driver == "force_dimension" else "")
                    listed = subprocess.run([daemons.BUILD / "bin" / "haptic_server", "--list-devices", "--device",
                                             device], text=True, capture_output=True)
                    self.assertEqual(listed.returncode, 0, listed.stderr)
                    line = listed.stdout.splitlines()[-1].split()[0]
                    self.assertIn("serial=", line)
                    again = subprocess.run([daemons.BUILD / "bin" / "haptic_server", "--list-devices", "--device",
                                            line], text=True, capture_output=True)
                    self.assertEqual((again.returncode, again.stdout.splitlines()[-1].split()[0]), (0, line))

    def test_a_wall_is_felt_through_either_library(self):
        for driver in LIBRARIES:
            sim = self.sim_server("wall")
            hand = self.run_device(driver, self.options(driver, ""), None, "--duration", 1.2)
            self.assertEqual(hand.wait(), DONE, hand.lines())
            sim.stop()
            log = Log(self.log_file)
            self.assertGreater(log.greatest_N, 1.0)
            self.assertEqual((log.last_N, log.motors_are_on), (0.0, 0.0))


def write_page():
    run = VendorRun()
    for driver in LIBRARIES:
        run.setUp()
        try:
            rows = run.rows_of(driver)
        finally:
            run.tearDown()
        before, _, after = split_page(driver)
        PAGE.write_text(before + table_of(rows) + after)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="the page's tables anew")
    if parser.parse_known_args()[0].write:
        write_page()
    else:
        unittest.main()
