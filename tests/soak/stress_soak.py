#!/usr/bin/python3
"""Both daemons under load: stress-ng beside them, a reader that checks every snapshot, and the
real-time guard on the 1 kHz thread.

The daemons run in slices of 60 s, and after each slice cyclictest runs for 10 s under the same
load, as the baseline of the machine. Counts are summed over the slices. Laws: no torn snapshot; no violation
of the guard; no page fault after start; of 10,000 ticks, begun or whole, at most one is contended
(both of its reads failed); no force above the device's limit, and in 999 of 1,000 ticks no change above
a tenth of it in a millisecond; neither daemon's memory grows; and the share of missed ticks is at most the baseline's plus
a margin.
The margin is 0.1 %, of a run of one slice 1 %, or the spread (largest less smallest) of the
baseline's slices where that is more; a run of one slice has its baseline before it too. The share of time that a hypervisor stole is noted, and
is no law. Prints its figures; exit status 1 if a law is broken.
"""
import argparse
import json
import math
import pathlib
import re
import shutil
import signal
import statistics
import subprocess
import sys
import threading
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
import daemons  # which also finds cyclictest
import cyclictest
from daemons import BUILD, DONE

HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=2"
LOAD = ("--cpu", "1", "--vm", "1", "--vm-bytes", "256M", "--io", "1", "--switch", "1", "--shm", "1")
LATE_US = 1000  # a wake-up that misses a tick of 1 kHz
BASELINE_S = 10.0  # a slice of cyclictest
LIMIT_N, SLEW_N_PER_MS = 8.5, 0.85  # of the hand's device
ROUNDED = 1.02  # a histogram's upper ends
SETTLED_S = 10.0  # by then all is allocated that will be
GROWTH_KIB = 1024
MOST_CONTENDED = 1e-4  # of all ticks
LEAST_MARGIN = 0.001  # of the share of missed ticks
MARGIN_OF_ONE_SLICE = 0.01
SUMMED = {"haptic": ("ticks", "missed_ticks", "contended", "page_faults"),
          "sim": ("steps", "late_steps"),
          "snapshots": ("snapshots", "continued", "reads", "torn")}


def processor_times():
    """(stolen, all), of all processors since boot."""
    with open("/proc/stat") as stat:
        times = [int(word) for word in stat.readline().split()[1:9]]  # guests are part of user
    return times[7], sum(times)


def stolen_share(before):
    stolen, total = (now - then for now, then in zip(processor_times(), before))
    return stolen / max(1, total)


class MemoryWatch(threading.Thread):
    """Resident memory of some processes, KiB, once a second until they end."""

    def __init__(self, **processes):
        super().__init__(daemon=True)
        self.processes = processes
        self.samples = {name: [] for name in processes}
        self.start()

    def run(self):
        began_s = time.monotonic()
        while any(process.runs() for process in self.processes.values()):
            for name, process in self.processes.items():
                kib = resident_kib(process.pid)
                if kib is not None:
                    self.samples[name].append((time.monotonic() - began_s, kib))
            time.sleep(1.0)

    def growth_kib(self):
        """By name: the most above what it was when settled; 0 for a run that ended before."""
        settled = {name: [kib for at_s, kib in samples if at_s >= SETTLED_S]
                   for name, samples in self.samples.items()}
        return {name: max(kib) - kib[0] if kib else 0 for name, kib in settled.items()}


def resident_kib(pid):
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return None
    found = re.search(r"^VmRSS:\s+(\d+) kB", status, re.M)
    return int(found[1]) if found else None


class Stress(daemons.SessionTest):
    """The helpers of a test, without being one."""

    def runTest(self):
        pass

    def under_load(self, seconds, work):
        """What work(seconds) returns, and beside it the share of time that was stolen."""
        load = self.start("stress-ng", "--quiet", *LOAD, "--timeout", f"{seconds + 60:.0f}s")
        before = processor_times()
        figures = work(seconds)
        steal_share = stolen_share(before)
        self.assertTrue(load.runs(), load.lines())
        load.signal(signal.SIGINT)
        load.wait()
        return {**figures, "steal_share": steal_share}

    def run_daemons(self, seconds):
        """Reports of haptic_server, sim_server and snapshot_watch."""
        files = {name: self.folder / f"{name}.json" for name in SUMMED}
        sim = self.sim_server("tissue_and_blocks", "--rate", 33, "--report", files["sim"])
        hand = self.haptic_server(HAND, "--realtime-guard", "--duration", seconds, "--report",
                                  files["haptic"], "--record", self.folder / "record.csv")
        memory = MemoryWatch(sim_server=sim, haptic_server=hand)
        with open(files["snapshots"], "w") as out:
            snapshots = subprocess.run([BUILD / "tests" / "snapshot_watch", "--session", self.session,
                                     "--duration", str(seconds)], stdout=out)
        self.assertEqual(hand.wait(60), DONE, hand.lines())
        self.assertEqual(sim.stop(), DONE, sim.lines())
        reports = {name: daemons.read_report(file) for name, file in files.items()}
        # Its status tells of torn snapshots, which are a law, or that it saw none.
        self.assertGreater(reports["snapshots"]["snapshots"], 0, snapshots)
        reports["growth_kib"] = memory.growth_kib()
        return reports

    def run_cyclictest(self, seconds):
        """Counts of its wake-ups, and of those that were later than a tick."""
        report = self.folder / "cyclictest.json"
        self.assertTrue(cyclictest.run(seconds, report), "cyclictest failed")
        baseline = json.loads(report.read_text())
        cycles = baseline["thread"]["0"]["cycles"]
        # The histogram ends at 100 ms; cycles are all.
        in_time = sum(n for us, n in cyclictest.wake_ups(baseline).items() if us < LATE_US)
        return {"ticks": cycles, "missed_ticks": cycles - in_time}


def missed_share(figures):
    return figures["missed_ticks"] / figures["ticks"]


def margin_over(baselines, slices):
    shares = [missed_share(baseline) for baseline in baselines]
    least = MARGIN_OF_ONE_SLICE if len(slices) == 1 else LEAST_MARGIN
    return max(least, max(shares) - min(shares))


def sum_up(slices, baselines):
    """The figures of all slices together. Shares of stolen time are means."""
    figures = {key: sum(s[name][key] for s in slices) for name, keys in SUMMED.items()
               for key in keys}
    figures["realtime_violations"] = sum(s["haptic"]["realtime_violations"]["total"]
                                         for s in slices)
    baseline = {key: sum(b[key] for b in baselines) for key in ("ticks", "missed_ticks")}
    for sums, parts in ((figures, slices), (baseline, baselines)):
        sums["missed_share"] = missed_share(sums)
        sums["steal_share"] = statistics.mean(part["steal_share"] for part in parts)
    figures["force_max_N"] = max(s["haptic"]["force_N"]["max"] for s in slices)
    # A stall cuts at once, by design, and what it let the hand do comes within a tick or two after.
    for key in ("p999", "max"):
        figures[f"slew_{key}_N_per_ms"] = max(
            [s["haptic"]["slew_N_per_ms"][key] for s in slices
             if s["haptic"]["safety"]["stalled"] == 0], default=0.0)
    figures["growth_kib"] = {name: max(s["growth_kib"][name] for s in slices)
                             for name in slices[0]["growth_kib"]}
    return {**figures, "baseline": baseline, "margin": margin_over(baselines, slices),
            "slices": slices, "baseline_slices": baselines}


def broken_laws(figures):
    most_missed = figures["baseline"]["missed_share"] + figures["margin"]
    laws = {"a torn snapshot": figures["torn"] == 0,
            "a violation of the real-time guard": figures["realtime_violations"] == 0,
            "page faults after the start": figures["page_faults"] == 0,
            "more than one tick in 10,000 contended":
                figures["contended"] <= math.ceil(MOST_CONTENDED * figures["ticks"]),
            f"a force above {LIMIT_N} N": figures["force_max_N"] <= LIMIT_N * (1.0 + 1e-9),
            f"a change above {SLEW_N_PER_MS} N/ms in more than one tick in 1,000":
                figures["slew_p999_N_per_ms"] <= ROUNDED * SLEW_N_PER_MS,
            f"memory that grew by more than {GROWTH_KIB} KiB":
                max(figures["growth_kib"].values()) <= GROWTH_KIB,
            f"more missed ticks than the baseline and {100 * figures['margin']:.3f} %":
                figures["missed_share"] <= most_missed}
    return [law for law, holds in laws.items() if not holds]


def describe(figures):
    baseline = figures["baseline"]
    p50_us, p99_us = ([1e-3 * s["haptic"]["tick_ns"][p] for s in figures["slices"]]
                      for p in ("p50", "p99"))
    return (f"ticks {figures['ticks']}, missed {figures['missed_ticks']} "
            f"({100 * figures['missed_share']:.3f} %; cyclictest under the same load "
            f"{100 * baseline['missed_share']:.3f} %, margin {100 * figures['margin']:.3f} %), "
            f"contended {figures['contended']}\n"
            f"stolen time {100 * figures['steal_share']:.2f} %, beside cyclictest "
            f"{100 * baseline['steal_share']:.2f} %\n"
            f"tick p50 {statistics.median(p50_us):.1f} us, p99 {max(p99_us):.1f} us (median and "
            f"largest of {len(p50_us)} slices); steps {figures['steps']}, late "
            f"{figures['late_steps']}\n"
            f"snapshots {figures['snapshots']}, of which {figures['continued']} follow the one before; "
            f"read {figures['reads']} times, torn {figures['torn']}\n"
            f"force at most {figures['force_max_N']:.2f} N, change at most "
            f"{figures['slew_max_N_per_ms']:.3f} N/ms; memory grew by "
            f"{', '.join(f'{kib} KiB ({name})' for name, kib in figures['growth_kib'].items())}\n"
            f"guard violations {figures['realtime_violations']}, page faults "
            f"{figures['page_faults']}")


def run_slices(seconds, slice_s):
    """The daemons and cyclictest in alternation."""
    count = max(1, round(seconds / slice_s))
    slices, baselines = [], []
    stress = Stress()
    stress.setUp()
    baseline_s = max(5.0, min(BASELINE_S, seconds / count))
    try:
        if count == 1:  # what else runs on the machine may come or go between the two
            baselines.append(stress.under_load(baseline_s, stress.run_cyclictest))
        for number in range(1, count + 1):
            slices.append(stress.under_load(seconds / count, stress.run_daemons))
            baselines.append(stress.under_load(baseline_s, stress.run_cyclictest))
            if count > 1:
                print(f"stress_soak: {number} of {count} slices: missed "
                      f"{100 * missed_share(slices[-1]['haptic']):.3f} %, cyclictest "
                      f"{100 * missed_share(baselines[-1]):.3f} %", file=sys.stderr)
    finally:
        stress.tearDown()
    return sum_up(slices, baselines)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=600.0,
                        help="of the daemons, all slices together; default: %(default)s")
    parser.add_argument("--slice-s", type=float, default=60.0,
                        help="of a slice of the daemons; default: %(default)s")
    parser.add_argument("--report", type=pathlib.Path, help="write the figures (JSON) there")
    arguments = parser.parse_args()
    for option in ("seconds", "slice_s"):
        if not 1.0 <= getattr(arguments, option) <= 1e6:
            parser.error(f"--{option.replace('_', '-')}: value {getattr(arguments, option)}: "
                         "expected 1 to 1e6")
    for program in ("stress-ng", "cyclictest"):
        if not shutil.which(program):
            sys.exit(f"stress_soak: no {program}: run scripts/setup")
    if not cyclictest.may_run():
        print("stress_soak: skipped: no baseline, for this user has no real-time priority: docs/realtime.md#rights",
              file=sys.stderr)
        sys.exit(daemons.SKIPPED)
    figures = run_slices(arguments.seconds, arguments.slice_s)
    broken = broken_laws(figures)
    print(describe(figures))
    if arguments.report:
        arguments.report.write_text(json.dumps({**figures, "broken_laws": broken}, indent=2) + "\n")
    for law in broken:
        print(f"stress_soak: {law}", file=sys.stderr)
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
