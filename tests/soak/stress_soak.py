#!/usr/bin/python3
"""Both daemons under load: stress-ng beside them, a reader that checks every image, and the
real-time guard on the 1 kHz thread. Laws: no torn image, no violation of the guard, no page fault
after start, and no more missed ticks than the machine itself misses, measured by cyclictest under
the same load right after. Prints its figures; exit status 1 if a law is broken."""
import argparse
import json
import pathlib
import shutil
import signal
import subprocess
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
import daemons
from daemons import BUILD, DONE

HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=2"
LOAD = ("--cpu", "1", "--vm", "1", "--vm-bytes", "256M", "--io", "1", "--switch", "1", "--shm", "1")
LATE_US = 1000  # a wake-up that misses a tick of 1 kHz


class Stress(daemons.SessionTest):
    """The helpers of a test, without being one."""

    def runTest(self):
        pass

    def load(self, seconds):
        return self.start("stress-ng", "--quiet", *LOAD, "--timeout", f"{seconds:.0f}s")

    def run_daemons(self, seconds):
        """Reports of haptic_server, sim_server and image_watch."""
        haptic_file, sim_file = self.folder / "haptic.json", self.folder / "sim.json"
        images_file = self.folder / "images.json"
        load = self.load(seconds + 30)
        sim = self.sim_server("tissue_and_blocks", "--report", sim_file)
        hand = self.haptic_server(HAND, "--realtime-guard", "--duration", seconds, "--report",
                                  haptic_file, "--record", self.folder / "record.csv")
        with open(images_file, "w") as out:
            images = subprocess.run([BUILD / "tests" / "image_watch", "--session", self.session,
                                     "--duration", str(seconds)], stdout=out)
        self.assertEqual(images.returncode, 0, images_file.read_text())
        self.assertEqual(hand.wait(60), DONE, hand.lines())
        self.assertEqual(sim.stop(), DONE, sim.lines())
        load.signal(signal.SIGINT)
        load.wait()
        return [json.loads(f.read_text()) for f in (haptic_file, sim_file, images_file)]

    def run_baseline(self, seconds):
        """Share of cyclictest's wake-ups that were later than a tick, under the same load."""
        report = self.folder / "cyclictest.json"
        load = self.load(seconds + 30)
        subprocess.run(["cyclictest", "--quiet", "--mlockall", "--threads=1", "--priority=80",
                        "--interval=1000", f"--duration={seconds:.0f}", "--histogram=100000",
                        f"--json={report}"], stdout=subprocess.DEVNULL, check=True)
        load.signal(signal.SIGINT)
        load.wait()
        histogram = json.loads(report.read_text())["thread"]["0"]["histogram"]
        counts = {int(us): n for us, n in histogram.items()}
        return sum(n for us, n in counts.items() if us >= LATE_US) / sum(counts.values())


def check(haptic, sim, images, baseline):
    """The laws that were broken, a line each."""
    missed = haptic["missed_ticks"] / haptic["ticks"]
    guard = haptic["realtime_violations"]["total"]
    print(f"ticks {haptic['ticks']}, missed {haptic['missed_ticks']} ({100 * missed:.3f} %; "
          f"cyclictest under the same load {100 * baseline:.3f} %)\n"
          f"tick p50 {haptic['tick_ns']['p50'] / 1e3:.1f} us, p99 "
          f"{haptic['tick_ns']['p99'] / 1e3:.1f} us; steps {sim['steps']}, late "
          f"{sim['late_steps']}\n"
          f"images {images['images']}, of which {images['continued']} follow the one before; "
          f"read {images['reads']} times, contended {images['contended']}, torn {images['torn']}\n"
          f"guard violations {guard}, page faults {haptic['page_faults']}")
    laws = {"a torn image": images["torn"] == 0,
            "a violation of the real-time guard": guard == 0,
            "page faults after the start": haptic["page_faults"] == 0,
            "a contended tick": haptic["contended"] <= 1e-3 * haptic["ticks"],
            "more missed ticks than twice the baseline and 1 %": missed <= 2 * baseline + 0.01}
    return [law for law, holds in laws.items() if not holds]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0, help="default: 600")
    parser.add_argument("--report", type=pathlib.Path, help="write the figures (JSON) there")
    arguments = parser.parse_args()
    for program in ("stress-ng", "cyclictest"):
        if not shutil.which(program):
            sys.exit(f"stress_soak: no {program}: run scripts/setup")
    stress = Stress()
    stress.setUp()
    try:
        haptic, sim, images = stress.run_daemons(arguments.seconds)
        baseline = stress.run_baseline(max(5.0, min(60.0, arguments.seconds)))
    finally:
        stress.tearDown()
    broken = check(haptic, sim, images, baseline)
    if arguments.report:
        arguments.report.write_text(json.dumps(
            {"haptic": haptic, "sim": sim, "images": images, "baseline_missed_share": baseline,
             "broken_laws": broken}, indent=2) + "\n")
    for law in broken:
        print(f"stress_soak: {law}", file=sys.stderr)
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
