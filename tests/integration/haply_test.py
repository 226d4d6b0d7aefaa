#!/usr/bin/python3
"""The plugin haply against a fake of the Haply Inverse Service: a wall is felt, and every fault of the service
ends in one line and no force. With --table it prints the table of docs/haply.md, which the tests hold to it."""
import json
import re
import signal
import subprocess
import sys
import time
import unittest

import daemons
from daemons import BAD_INPUT, BUILD, DEVICE_FAULT, DONE, ROOT

SERVICE = ROOT / "tests" / "integration" / "haply_service.py"
PAGE = ROOT / "docs" / "haply.md"
MIDST = ("--after", 1500)  # replies: a second and more, while the wall is pressed
START = ("--after", -1)    # the inventory too

# What happens, the service's options, those of the device, exit status.
FAULTS = (
    ("no service runs", None, "", DEVICE_FAULT),
    ("no device is plugged in", ("--devices", 0), "", DEVICE_FAULT),
    ("two devices and none named", ("--devices", 2), "", BAD_INPUT),
    ("two grips and none named", ("--grips", 2), "", BAD_INPUT),
    ("the device named is not there", (), ",device_id=BEEF", DEVICE_FAULT),
    ("the inventory is no JSON", ("--fault", "garbage", *START), "", DEVICE_FAULT),
    ("the session has other axes", ("--frame", "basis"), "", BAD_INPUT),
    ("applied forces are not told", ("--fault", "no_echo", *START), "", DEVICE_FAULT),
    ("the service dies", ("--fault", "dies", *MIDST), "", DEVICE_FAULT),
    ("it goes silent", ("--fault", "silent", *MIDST), "", DEVICE_FAULT),
    ("it answers after 30 ms", ("--fault", "slow", *MIDST), "", DEVICE_FAULT),
    ("it sends no JSON", ("--fault", "garbage", *MIDST), "", DEVICE_FAULT),
    ("it sends NaN", ("--fault", "nan", *MIDST), "", DEVICE_FAULT),
    ("it sends a text for a number", ("--fault", "wrong_type", *MIDST), "", DEVICE_FAULT),
    ("it sends 20,000 nested lists", ("--fault", "nested", *MIDST), "", DEVICE_FAULT),
    ("it sends 100 KB", ("--fault", "huge", *MIDST), "", DEVICE_FAULT),
    ("it scales the frame meanwhile", ("--fault", "moved", *MIDST), "", DEVICE_FAULT),
    ("it applies twice the force", ("--fault", "wrong_echo", *MIDST), "", DEVICE_FAULT),
    ("it knows neither name of a force", ("--version", "none"), "", DEVICE_FAULT),
    ("the device is unplugged", ("--fault", "unplugged", *MIDST), "", DEVICE_FAULT),
    ("it loses its reference", ("--fault", "uncalibrated", *MIDST), "", DONE),
    ("its power supply is pulled", ("--fault", "unpowered", *MIDST), "", DONE),
    ("the grip goes to sleep", ("--fault", "grip_gone", *MIDST), "", DONE),
    ("it answers twice", ("--fault", "twice", *MIDST), "", DONE),
    ("it takes 'vector' alone", ("--version", "vector_only"), "", DONE),
    ("it takes 'values' alone", ("--version", "3.4"), "", DONE),
)


class ServiceTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.services = []
        self.log = self.folder / "forces.log"

    def tearDown(self):
        for service in self.services:
            service.kill()
            service.communicate()
        super().tearDown()

    def service(self, *options):
        """Starts it. Returns its port."""
        service = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", "/usr/bin/python3", SERVICE, "--log", self.log,
                                    *map(str, options)], stdout=subprocess.PIPE, text=True)
        self.services.append(service)
        return int(service.stdout.readline())

    def stop_services(self):
        """Its log is whole then."""
        for service in self.services:
            service.send_signal(signal.SIGINT)
            service.wait(10 * daemons.PATIENCE)

    def sent_forces_N(self, arm="049D"):
        """Forces along z that the service was sent, as they came."""
        rows = [line.split() for line in self.log.read_text().splitlines()]
        return [float(row[3]) for row in rows if len(row) == 5 and row[4] == arm]

    def run_on_wall(self, port, options="", duration_s=3.0):
        """haptic_server at its end: status, lines, report."""
        report = self.folder / "report.json"
        if not self.daemons:
            self.sim_server("wall")
        hand = self.haptic_server(f"haply:port={port}{options}", "--duration", duration_s, "--report", report)
        status = hand.wait(20.0 + duration_s)
        return status, hand.lines(), json.loads(report.read_text()) if report.exists() else None

    def run_unstalled(self, service, device="", duration_s=3.0, is_stall=False):
        """A service and run_on_wall(), again where the machine stood still: that is no fault of the driver's.
        Returns the port too."""
        for _ in range(4):
            port = self.service(*service) if service is not None else 9
            outcome = self.run_on_wall(port, device, duration_s)
            if is_stall or not any("answered for 80 ms" in line or "is slow" in line for line in outcome[1]):
                break
            self.stop_services()
        return port, *outcome


def outcome_row(test, fault):
    """One fault's run as a row of the table; asserts what holds of every fault."""
    name, service, device, expected = fault
    port, status, lines, _ = test.run_unstalled(service, device, is_stall="silent" in name or "30 ms" in name)
    lines = [line for line in lines if not line.endswith(" Hz; expected 1000 Hz")]  # of a busy machine
    test.assertEqual(status, expected, (name, lines))
    if status != DONE:
        test.assertEqual(len([line for line in lines if not line.endswith(" is tried")]), 1, (name, lines))
    test.stop_services()
    forces_N = test.sent_forces_N() if service is not None else []
    has_died = name == "the service dies"
    if forces_N and not has_died:
        test.assertEqual(forces_N[-1], 0.0, name)
    force = ("none was sent" if not any(forces_N) else
             "the device's own watchdog decides" if has_died else
             "zero" if status != DONE else
             "none until that has passed" if not any(forces_N[-100:]) and "; no force until" in "".join(lines) else "as ever")
    said = [re.sub(r"^haptic_server: device '[^']*': ", "", line) for line in lines]
    line = "; ".join(line for line in said if not line.startswith(("no force, of", "not believed in")))
    line = re.sub(r"-?\d+\.\d\d -?\d+\.\d\d -?\d+\.\d\d N", "X Y Z N", line).replace(f":{port}", ":PORT")
    return f"| {name} | {line} | {force} | {status} |"


class FaultTable(ServiceTest):
    def test_every_fault_of_the_service_ends_as_the_table_says_and_leaves_no_force(self):
        page = PAGE.read_text()
        missing = []
        for fault in FAULTS:
            with self.subTest(fault[0]):
                row = outcome_row(self, fault)
                if row not in page:
                    missing.append(row)
        self.assertEqual(missing, [], "\n".join(["not in docs/haply.md:", *missing]))
        self.assertEqual(len(re.findall(r"^\| .* \| \d \|$", page, re.MULTILINE)), len(FAULTS))


class HaplyTest(ServiceTest):
    def test_the_driver_keeps_every_rule(self):
        port = self.service()
        check = subprocess.run([BUILD / "bin" / "device_check", f"haply:port={port}", "--seconds", "1", "--any-force",
                                "--timeout", str(20 * daemons.PATIENCE)], capture_output=True, text=True, check=False)
        self.assertEqual(check.returncode, 0, check.stdout)

    def test_the_wall_is_felt_with_what_each_version_calls_a_force(self):
        for version in ("3.1", "3.4", "3.5"):
            with self.subTest(version):
                _, status, lines, report = self.run_unstalled(("--version", version), duration_s=2.0)
                self.assertEqual((status, lines), (DONE, []))
                self.assertGreater(report["ticks"], 1000)
                self.stop_services()
                self.assertGreater(max(self.sent_forces_N()), 0.5)
                self.assertEqual(self.sent_forces_N()[-1], 0.0)

    def test_a_haptic_server_that_is_killed_leaves_no_force(self):
        port = self.service()
        self.sim_server("wall")
        hand = self.haptic_server(f"haply:port={port}", "--duration", 60)
        time.sleep(1.5 * daemons.PATIENCE)
        hand.signal(signal.SIGKILL)  # the process that holds the device; the other takes the force away
        hand.wait()
        self.stop_services()
        self.assertGreater(max(self.sent_forces_N()), 0.5)
        self.assertEqual(self.sent_forces_N()[-1], 0.0)

    def test_two_devices_are_told_apart_by_their_number(self):
        _, status, lines, report = self.run_unstalled(("--devices", 2, "--grips", 2), ",device_id=04EA,grip_id=61571",
                                                      duration_s=1.5)
        self.assertEqual((status, lines), (DONE, []))
        self.stop_services()
        self.assertEqual(self.sent_forces_N("049D"), [])
        self.assertGreater(max(self.sent_forces_N("04EA")), 0.5)
        self.assertIn("04EA", json.dumps(report))


class PaceTest(ServiceTest):
    """The driver's own thread runs the tick, as a host of version 2 lets it."""

    def run_pace(self, port, seconds, period_ns=1_000_000):
        run = subprocess.run([BUILD / "tests" / "haply_pace", BUILD / "lib" / "stillgrid" / "devices" / "haply.so",
                              str(port), str(seconds), str(period_ns)], capture_output=True, text=True, check=False,
                             timeout=60 * daemons.PATIENCE)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return json.loads(run.stdout)

    def test_its_thread_ticks_and_the_force_reaches_the_service(self):
        for _ in range(4):
            outcome = self.run_pace(self.service(), 2.0)
            if outcome["code"] == 0:
                break
            self.stop_services()
        self.assertEqual((outcome["code"], outcome["line"]), (0, ""))
        self.assertGreater(outcome["ticks"], 100)
        self.stop_services()
        self.assertGreater(max(self.sent_forces_N()), 0.5)
        self.assertEqual(self.sent_forces_N()[-1], 0.0)

    def test_a_fault_is_told_in_a_tick_and_the_last_force_is_zero(self):
        for fault in ("dies", "silent", "slow", "garbage", "wrong_echo", "unplugged", "huge"):
            with self.subTest(fault):
                outcome = self.run_pace(self.service("--fault", fault, "--after", 1000), 20.0)
                self.assertEqual(outcome["code"], -5, outcome)
                self.assertRegex(outcome["line"], "the service|device 049D")  # one line, by its JSON
                self.stop_services()
                if fault != "dies":
                    self.assertEqual(self.sent_forces_N()[-1], 0.0)


class Table(ServiceTest):
    def runTest(self):
        print("| Fault | What is said | The force then | Status |\n|---|---|---|---|")
        for fault in FAULTS:
            print(outcome_row(self, fault), flush=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["--table"]:
        sys.exit(not unittest.TextTestRunner(verbosity=0).run(Table()).wasSuccessful())
    daemons.main()
