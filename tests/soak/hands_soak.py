#!/usr/bin/python3
"""One hand never touches another: of two that hold a block, one is killed (SIGKILL), or stopped (SIGSTOP)
and let go on, again and again, while the other's device goes on.

Laws of the other hand, beside an undisturbed run as long with nobody beside it: one process, exit status 0,
no line on standard error; no stop of its device, no safety flag but those that a start and a simulation that is late
give (ramped, faded), no page fault. Where its user has no real-time priority, it may stall, and no locked memory, fault
pages. In runs of a minute and more its missed ticks are compared with those
undisturbed, and cyclictest's, for a tenth of the time right after, stand beside.

Whether the simulation is late for it is told by one run, for a machine's load changes from run to run: every
other SLICE_S seconds it is a hand of another session that is killed instead. Late ticks are those that are
faded, but for the fade of the hand's own end. With --stress stress-ng works beside all of it. Exit status 1
if a law is broken.
"""
import argparse
import csv
import json
import pathlib
import random
import shutil
import signal
import statistics
import subprocess
import sys
import time
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
import daemons  # after the path it needs; it also finds cyclictest
import cyclictest
from daemons import DONE, SCENES

SCENE = "block_pinched"
MAY_BE_FLAGGED = {"ramped", "faded"}  # faded: the simulation was late, for a busy machine; and at the end
SHORTEST_S, LONGEST_S = 0.3, 1.2  # that a hand lives before it is killed or stopped
STOPPED_S = 0.2
COMPARED_FROM_S = 60.0
MOST_MORE_MISSED = MOST_MORE_LATE = 0.002  # of all ticks
SLICE_S = 5.0
PROGRESS_S = 10.0
PERIOD_US = 1000
WANT_OF_TICKS = "no tick for 100 ms or more"


def device_of(name):
    return f"phantom:profile=touchx,path={SCENES / f'{SCENE}.{name}.csv'}"


class HandsSoak(daemons.SessionTest):
    kills, seconds, seed, report_file, stress = 3, 0.0, 1, None, False

    def hand(self, name, *arguments):
        return self.haptic_server(device_of(name), "--hand", name, *arguments)

    def other_hand(self, disturb):
        """What a hand reports that disturb() ran beside, and for how long."""
        report, recording = (self.folder / f"{len(self.daemons)}.{kind}" for kind in ("json", "csv"))
        sim = self.sim_server(SCENE)
        other = self.hand("right", "--report", report, "--record", recording)
        self.wait_until(lambda: any(daemons.SHM.glob(f"{self.session}+right-tool")), 10.0, "the other hand")
        began_s = time.monotonic()
        disturb()
        seconds = time.monotonic() - began_s
        for daemon in (other, sim):
            self.assertTrue(daemon.runs(), daemon.lines())
            self.assertEqual(daemon.stop(), DONE, daemon.lines())
        if not other.has("real-time priority") and any(WANT_OF_TICKS in line for line in other.lines()):
            self.skipTest("skipped: without real-time priority the machine kept a loop waiting for 100 ms")
        self.assertEqual(other.lines(), [])  # a busy simulation may end steps early, and say so
        return {**daemons.read_report(report), "seconds": seconds, "late_s": late_ticks_s(recording),
                "rights": {right for right in ("locked memory", "real-time priority") if other.has(right)}}

    def kill_hands(self):
        instants = random.Random(self.seed)
        session = self.session
        self.session += "-other"
        elsewhere = self.sim_server(SCENE)
        began_s = said_s = time.monotonic()
        self.killed = self.stopped = number = 0
        while self.killed < self.kills or time.monotonic() < began_s + self.seconds:
            is_beside = int((time.monotonic() - began_s) / SLICE_S) % 2 == 0
            self.session = session + ("" if is_beside else "-other")
            self.kill_hand(instants, is_stopped=number % 2)
            self.stopped += is_beside and number % 2
            self.killed += is_beside
            number += 1
            if time.monotonic() > said_s + PROGRESS_S:
                said_s += PROGRESS_S
                print(f"hands_soak: {self.killed} killed", file=sys.stderr)
        self.assertEqual(elsewhere.stop(), DONE, elsewhere.lines())
        self.session = session

    def kill_hand(self, instants, is_stopped):
        hand = self.hand("left")
        time.sleep(instants.uniform(SHORTEST_S, LONGEST_S))
        self.assertTrue(hand.runs(), hand.lines())
        if is_stopped:
            hand.signal(signal.SIGSTOP)
            time.sleep(STOPPED_S)
            hand.signal(signal.SIGCONT)
        hand.kill()

    def test_what_becomes_of_one_hand_is_nothing_to_the_other(self):
        load = self.start_load()
        try:
            disturbed = self.other_hand(self.kill_hands)
            alone = self.other_hand(lambda: time.sleep(disturbed["seconds"]))
            baseline = self.baseline(0.1 * disturbed["seconds"])
        finally:
            if load is not None:
                load.terminate()
                load.wait()
        figures = {"killed": self.killed, "stopped": self.stopped, "stress": self.stress,
                   "disturbed": figures_of(disturbed), "undisturbed": figures_of(alone),
                   "late_share_beside": late_share(disturbed, 0),
                   "late_share_elsewhere": late_share(disturbed, 1),
                   "cyclictest": baseline}
        print(json.dumps(figures, indent=2))
        if self.report_file:
            pathlib.Path(self.report_file).write_text(json.dumps(figures, indent=2) + "\n")
        for run in (disturbed, alone):
            flags = {flag for flag, count in run["safety"].items() if count}
            self.assertLessEqual(flags, MAY_BE_FLAGGED if "real-time priority" in run["rights"] else
                                 MAY_BE_FLAGGED | {"stalled"})
            self.assertEqual((run["device_stops"], run["lost_rows"]), (0, 0))
            if "locked memory" in run["rights"]:
                self.assertEqual(run["page_faults"], 0)
        if disturbed["seconds"] >= COMPARED_FROM_S:
            self.assertLessEqual(figures["disturbed"]["missed_share"],
                                 figures["undisturbed"]["missed_share"] + MOST_MORE_MISSED)
            self.assertLessEqual(figures["late_share_beside"],
                                 figures["late_share_elsewhere"] + MOST_MORE_LATE)

    def baseline(self, seconds):
        """cyclictest's wake-ups and those a period late; null in a short run, or where it may not run."""
        report = self.folder / "cyclictest.json"
        if seconds < 0.1 * COMPARED_FROM_S or not cyclictest.run(seconds, report):
            return None
        wake_ups = cyclictest.wake_ups(daemons.read_report(report))
        return {"ticks": sum(wake_ups.values()),
                "missed_ticks": sum(count for us, count in wake_ups.items() if us >= PERIOD_US)}

    def start_load(self):
        if not self.stress:
            return None
        if shutil.which("stress-ng") is None:
            self.fail("no stress-ng: scripts/setup")
        return subprocess.Popen(["stress-ng", "--quiet", "--cpu", "0", "--vm", "1", "--vm-bytes", "128M"],
                                stdout=subprocess.DEVNULL)


def late_ticks_s(recording):
    """When the simulation was late, but for the fade of the end."""
    late_s, last = [], 0
    with open(recording) as lines:
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        for number, row in enumerate(rows):
            if "faded" in row["flags"].split("|"):
                late_s.append(float(row["time_s"]))
            else:
                last = len(late_s)
    return late_s[:last]


def late_share(report, which):
    """Of the ticks of whole slices, the first or the second of each pair: the median slice."""
    late = [0] * int(report["seconds"] / SLICE_S)
    for late_s in report["late_s"]:
        if late_s < SLICE_S * len(late):
            late[int(late_s / SLICE_S)] += 1
    return statistics.median(late[which::2]) / (1e6 / PERIOD_US * SLICE_S) if len(late) > which else None


def figures_of(report):
    return {"seconds": round(report["seconds"], 3), "ticks": report["ticks"],
            "missed_ticks": report["missed_ticks"],
            "missed_share": report["missed_ticks"] / max(1, report["ticks"]),
            "late_ticks": len(report["late_s"]),
            "safety": {flag: count for flag, count in report["safety"].items() if count},
            "tick_ns": report["tick_ns"], "wake_ns": report["wake_ns"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=3, help="at least; default: %(default)s")
    parser.add_argument("--seconds", type=float, default=0.0, help="at least; default: %(default)s")
    parser.add_argument("--seed", type=int, default=1, help="of the kills' instants; default: %(default)s")
    parser.add_argument("--stress", action="store_true", help="stress-ng beside")
    parser.add_argument("--report", metavar="FILE.json", help="write the figures")
    arguments = parser.parse_args()
    if arguments.kills < 1:
        parser.error(f"--kills: value {arguments.kills}: expected 1 at least")
    HandsSoak.kills, HandsSoak.seconds, HandsSoak.seed = arguments.kills, arguments.seconds, arguments.seed
    HandsSoak.report_file, HandsSoak.stress = arguments.report, arguments.stress
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(HandsSoak)
    result = unittest.TextTestRunner().run(suite)
    sys.exit(1 if not result.wasSuccessful() else daemons.SKIPPED if result.skipped else 0)


if __name__ == "__main__":
    main()
