"""The machine's own latency: a thread that cyclictest wakes at 1 kHz, and how late it woke."""
import shutil
import subprocess


def call(*options):
    return bool(shutil.which("cyclictest")) and subprocess.run(
        ["cyclictest", "--quiet", "--mlockall", "--threads=1", "--priority=80", "--interval=1000", *options],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


def may_run():
    """Whether it is there and this user has real-time priority."""
    return call("--loops=1")


def run(seconds, report):
    """Writes cyclictest's JSON to report. False where it is absent or may not be real-time."""
    return call(f"--duration={seconds:.0f}", "--histogram=100000", f"--json={report}")


def wake_ups(report):
    """Counts by whole us of lateness, of a report that was read; those above 100 ms are not in."""
    return {int(us): count for us, count in report["thread"]["0"]["histogram"].items()}


def percentile_us(counts, share):
    """The least lateness that a share of all wake-ups do not exceed; 0 without any."""
    needed, seen = share * sum(counts.values()), 0
    for us in sorted(counts):
        seen += counts[us]
        if seen >= needed:
            return us
    return 0
