#!/usr/bin/python3
"""Measures docs/charts/viewer_ticks.csv: the haptic loop's ticks alone, and beside scene_viewer with a
page that asks it for 30 frames a second and for the ticks, in turns; after each pair the machine's own
latency, by cyclictest. A row a run: percentiles of a tick's work and of how late it woke, and the share of
deadlines missed. Both daemons run tissue_and_blocks in real time, under a hand that presses."""
import json
import os
import pathlib
import subprocess
import tempfile
import threading
import time

import cyclictest
from benchmark_report import processor_name
from measure_demo import HAND
from measuring import ROOT, fail, parser_of
from tables import write_rows
from viewer_client import Page

FRAMES_PER_S = 30
SHARES = {"p50": 0.5, "p99": 0.99, "p999": 0.999}


def poll(page, stop, counts):
    """What a page asks for, until it is told to stop."""
    last_tick = 0
    while not stop.wait(1.0 / FRAMES_PER_S):
        _, arrays = page.frame()
        ticks = page.ticks(first=last_tick + 1)["tick"]
        last_tick = int(ticks[-1]) if ticks.size else last_tick
        counts["frames"] += 1
        counts["displayed"] += arrays["displayed"].size > 0


class Viewer:
    """scene_viewer and a page that asks it, for as long as it stands."""

    def __init__(self, build, session):
        self._process = subprocess.Popen(
            [build / "bin/scene_viewer", "--session", session, "--port", "0"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        address = self._process.stdout.readline().strip()
        if not address:
            fail("scene_viewer did not start")
        self.counts, self._stop = {"frames": 0, "displayed": 0}, threading.Event()
        self._thread = threading.Thread(target=poll, args=(Page(address), self._stop, self.counts))

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        self._process.terminate()
        self._process.wait()


def run_daemons(build, session, seconds, folder):
    """The haptic loop's report."""
    subprocess.run([ROOT / "scripts/launch", "tissue_and_blocks", "--session", session, "--device", HAND,
                    "--duration", str(seconds), "--report-dir", folder, "--build", build],
                   check=True, stdout=subprocess.DEVNULL)
    return json.loads((folder / "haptic.json").read_text())


def row_of(beside, pair, report):
    return {"beside": beside, "pair": pair, "ticks": report["ticks"],
            "missed_share": f"{report['missed_ticks'] / report['ticks']:.3g}",
            **{f"tick_{share}_us": f"{1e-3 * report['tick_ns'][share]:.4g}" for share in SHARES},
            **{f"wake_{share}_us": f"{1e-3 * report['wake_ns'][share]:.4g}" for share in SHARES}}


def machine_row(pair, seconds, folder):
    """The same of cyclictest, which does no work; None where it may not run."""
    file = folder / "cyclictest.json"
    if not cyclictest.run(seconds, file):
        return None
    counts = cyclictest.wake_ups(json.loads(file.read_text()))
    ticks = sum(counts.values())
    missed = sum(count for us, count in counts.items() if us >= 1000)
    return {"beside": "machine", "pair": pair, "ticks": ticks, "missed_share": f"{missed / ticks:.3g}",
            **{f"tick_{share}_us": "" for share in SHARES},
            **{f"wake_{name}_us": cyclictest.percentile_us(counts, share)
               for name, share in SHARES.items()}}


def main():
    parser = parser_of(__doc__, "2 pairs of 4 s, not 20 of 15 s")
    arguments = parser.parse_args()
    pairs, seconds = (2, 4) if arguments.small else (20, 15)
    session, rows, frames, began_s = f"viewer-{os.getpid()}", [], 0, time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for pair in range(1, pairs + 1):
            order = ("nothing", "viewer") if pair % 2 else ("viewer", "nothing")
            for beside in order:
                if beside == "nothing":
                    report = run_daemons(arguments.build, session, seconds, folder)
                else:
                    with Viewer(arguments.build, session) as viewer:
                        report = run_daemons(arguments.build, session, seconds, folder)
                    frames += viewer.counts["frames"]
                    if not viewer.counts["displayed"]:
                        fail("no frame of the viewer displayed the scene")
                rows.append(row_of(beside, pair, report))
            rows += filter(None, [machine_row(pair, seconds, folder)])
    write_rows(arguments.charts / "viewer_ticks.csv", rows,
               [f"{processor_name()}; {pairs} pairs of runs of {seconds} s in {time.monotonic() - began_s:.0f} s, "
                f"load {os.getloadavg()[1]:.1f}; {frames} frames were asked for.",
                "machine: cyclictest at 1 kHz; missed there: woke 1 ms late or more."])


if __name__ == "__main__":
    main()
