"""Starts the daemons for a test, reads what they wrote, and leaves none behind."""
import itertools
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("STILLGRID_BUILD_DIR", ROOT / "build" / "release"))
SCENES = ROOT / "sim_server" / "scene" / "scenes"
DATA = pathlib.Path(os.environ.get("STILLGRID_DATA", ROOT.parent / "shared" / "data"))



def load_per_processor():
    """How many programs want each processor, at least 1: the larger of now and the last minute's mean."""
    mean, _, _, running, _ = pathlib.Path("/proc/loadavg").read_text().split()
    return max(1.0, float(mean) / os.cpu_count(), int(running.split("/")[0]) / os.cpu_count())


# Every limit of time is multiplied by this: for instrumented code, and for a machine that runs other programs too.
SLOWNESS = float(os.environ.get("STILLGRID_PATIENCE", 1))
PATIENCE = SLOWNESS * load_per_processor()
LEAST_WAIT_S = 30.0  # before a test fails because an event has not come
SHM = pathlib.Path("/dev/shm") / f"stillgrid-{os.geteuid()}"  # docs/protocol.md, "Names"

RELAY_OFFSET = 128
RELAY_FIGURES = ("relay_id", "connected", "clock_offset_ns", "clock_bound_ns", "round_trip_ns", "received",
                 "received_bytes", "lost", "repeated", "out_of_order", "late", "refused", "partitions",
                 "longest_silence_ns")

NOBODY = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups")  # before a command: as another user

DONE, BAD_INPUT, COULD_NOT_START, DEVICE_FAULT, NOT_CONVERGED, INCOMPLETE = 0, 1, 2, 3, 5, 6  # exit status
SKIPPED = 77  # of a test program, known to ctest

sys.path.append(str(ROOT / "scripts" / "gallery"))
import recording  # after the path it needs

_numbers = itertools.count(1)


class Daemon:
    """A program that runs, its standard error in a file."""

    def __init__(self, arguments, stderr_file):
        self._stderr_file = stderr_file
        # pdeathsig: a test that ctest kills for its time takes its daemons along.
        with open(stderr_file, "w") as stderr:
            self.process = subprocess.Popen(
                ["setpriv", "--pdeathsig", "KILL", *map(str, arguments)],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=stderr)

    def wait(self, timeout_s=30.0):
        """Exit status; a test fails where a program hangs."""
        limit_s = PATIENCE * max(timeout_s, LEAST_WAIT_S)
        try:
            return self.process.wait(limit_s)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f"{self.process.args[3]} hung for {limit_s:g} s: {self.lines()}") from None

    def runs(self):
        return self.process.poll() is None

    @property
    def pid(self):
        """Of the process that does the work: of haptic_server the child that holds the device."""
        own = self.process.pid
        try:
            program = os.readlink(f"/proc/{own}/exe")
            for child in pathlib.Path(f"/proc/{own}/task/{own}/children").read_text().split():
                if os.readlink(f"/proc/{child}/exe") == program:
                    return int(child)
        except OSError:  # it has ended
            pass
        return own

    def signal(self, number):
        """To the process that was started; what it could not pass on, to the one that works."""
        if number in (signal.SIGKILL, signal.SIGSTOP, signal.SIGCONT):
            if self.runs():
                os.kill(self.pid, number)
        else:
            self.process.send_signal(number)

    def stop(self):
        """As Ctrl-C does. Returns the exit status."""
        self.signal(signal.SIGINT)
        return self.wait(5.0)

    def kill(self):
        self.signal(signal.SIGKILL)
        if self.runs():
            self.process.kill()
        self.process.wait()

    def all_lines(self):
        """What it has written on standard error."""
        return self._stderr_file.read_text().splitlines()

    def lines(self):
        """The same, but for rights that the machine does not grant."""
        return [line for line in self.all_lines() if ": running without " not in line]

    def has(self, right):
        """Whether the machine grants it a right that it wants: "locked memory", without which page faults are no fault
        of its own, or "real-time priority", without which late ticks are none."""
        return not any(": running without " in line and right in line for line in self.all_lines())


class SessionTest(unittest.TestCase):
    """A test with a session and a folder of its own."""

    def setUp(self):
        self.first_session = self.session = f"test-{os.getpid()}-{next(_numbers)}"
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-"))
        self.daemons = []

    def tearDown(self):
        for daemon in self.daemons:
            daemon.kill()
        shutil.rmtree(self.folder)
        for left in (*SHM.glob(f"{self.first_session}-*"), *SHM.glob(f"{self.first_session}+*"),
                     *SHM.parent.glob(f"stillgrid-{self.first_session}-*")):
            left.unlink()

    def start(self, *arguments):
        daemon = Daemon(arguments, self.folder / f"{len(self.daemons)}.stderr")
        self.daemons.append(daemon)
        return daemon

    def sim_server(self, scene, *arguments):
        """scene: a file, or the name of a shipped one."""
        file = scene if isinstance(scene, pathlib.Path) else SCENES / f"{scene}.toml"
        return self.start(BUILD / "bin" / "sim_server", "--scene", file, "--session", self.session,
                          *arguments)

    def haptic_server(self, device, *arguments):
        return self.start(BUILD / "bin" / "haptic_server", "--session", self.session,
                          "--device", device, *arguments)

    def run_lockstep(self, scene, device, duration_s, sim=(), haptic=(), wait_s=30.0):
        """Runs both to their end. Returns the recording's file."""
        recording = self.folder / f"recording-{next(_numbers)}.csv"
        both = ("--lockstep", "--duration", duration_s)
        sim_server = self.sim_server(scene, *both, *sim)
        haptic_server = self.haptic_server(device, *both, "--record", recording, *haptic)
        self.assertEqual(haptic_server.wait(wait_s), DONE, haptic_server.lines())
        self.assertEqual(sim_server.wait(), DONE, sim_server.lines())
        return recording

    def set_relay_figures(self, kind, **figures):
        """Writes into the segment of a server what a relay would tell of it there: docs/protocol.md. What is not
        given is 0."""
        words = {"relay_id": 1, **figures}
        unknown = words.keys() - set(RELAY_FIGURES)
        self.assertFalse(unknown)
        with open(SHM / f"{self.session}-{kind}", "r+b", buffering=0) as segment:
            segment.seek(RELAY_OFFSET)
            segment.write(b"".join((words.get(name, 0) % 2**64).to_bytes(8, "little") for name in RELAY_FIGURES))

    def still_device(self, x_m, y_m, z_m):
        """A device that is held at a point, exactly, for as long as any test takes."""
        file = self.folder / f"still-{next(_numbers)}.csv"
        file.write_text(f"time_s,x_m,y_m,z_m\n0,{x_m},{y_m},{z_m}\n1000,{x_m},{y_m},{z_m}\n")
        return f"replay:file={file}"

    def write(self, name, text):
        file = self.folder / name
        file.write_text(text)
        return file

    def wait_until(self, condition, timeout_s, what):
        limit_s = PATIENCE * max(timeout_s, LEAST_WAIT_S)
        deadline = time.monotonic() + limit_s
        while not condition():
            self.assertLess(time.monotonic(), deadline, f"{what}: not within {limit_s:g} s")
            time.sleep(0.02)

    def assert_refused(self, daemon, status, *words, timeout_s=5.0):
        """It ends with this status and one line, which names the program and holds the words."""
        self.assertEqual(daemon.wait(timeout_s), status, daemon.lines())
        lines = daemon.lines()
        self.assertEqual(len(lines), 1, lines)
        self.assertRegex(lines[0], "^(sim|haptic)_server: ")
        for word in words:
            self.assertIn(word, lines[0])


def copy_for_others(test, *programs):
    """Copies programs, the drivers and the scene wall to a folder that any user may enter, which a home or a clone
    need not be. Returns the folder; skips the test if another user may not enter there either."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-", dir="/tmp"))
    test.addCleanup(shutil.rmtree, folder)
    folder.chmod(0o755)
    (folder / "bin").mkdir()
    for program in programs:
        shutil.copy(BUILD / "bin" / program, folder / "bin")
    shutil.copytree(BUILD / "lib" / "stillgrid", folder / "lib" / "stillgrid")
    for file in SCENES.glob("wall.*"):
        shutil.copy(file, folder)
    if subprocess.run([*NOBODY, "test", "-x", folder / "bin" / programs[0]], capture_output=True, check=False).returncode:
        test.skipTest("no program that another user may run")
    return folder


def waited_s(pid):
    """How long the threads of a process, all together, have been kept from a processor by others. 0 where it has ended
    or the kernel does not say."""
    waited_ns = 0
    for file in pathlib.Path(f"/proc/{pid}/task").glob("*/schedstat"):
        try:
            waited_ns += int(file.read_text().split()[1])
        except OSError:  # the thread has ended
            pass
    return 1e-9 * waited_ns


def heeds(pid, number):
    """Whether a process has a handler for the signal."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    caught = int(re.search(r"^SigCgt:\s+(\w+)", status, re.M)[1], 16)
    return caught >> (number - 1) & 1


def read_recording(file):
    """The columns by name, arrays of floats; flags as text."""
    return recording.load(file)


def vectors(recording, name, unit):
    """Three columns as rows of vectors: vectors(r, "f", "N")."""
    prefix, _, kind = name.rpartition("_")
    prefix = prefix + "_" if prefix else ""
    return numpy.stack([recording[f"{prefix}{kind}{axis}_{unit}"] for axis in "xyz"], axis=1)


def read_report(file):
    return json.loads(pathlib.Path(file).read_text())


def main():
    """unittest's, but a program whose tests were all skipped exits with SKIPPED."""
    program = unittest.main(module="__main__", exit=False, verbosity=1)
    result = program.result
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(SKIPPED if result.testsRun and len(result.skipped) == result.testsRun else 0)
