#!/usr/bin/python3
"""Measures how long the simulation's steps take in real time: docs/charts/step_times.csv.

Runs both daemons on a scene with a phantom at its device, at one rate after the other, and keeps
what sim_server's report says. The machine's stolen time is written beside: a step that its host
did not run is late whatever the solver. scripts/gallery/plot_step_times.py draws the chart.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

from tables import write_rows

ROOT = pathlib.Path(__file__).resolve().parents[2]
PERCENTILES = ("p50", "p99", "p999", "max")
PHASES = ("detect", "respond", "integrate", "publish")


def stolen_share(before, after):
    """Of all processor time between two readings of /proc/stat."""
    total = sum(after) - sum(before)
    return (after[7] - before[7]) / total if total else 0.0


def processor_times():
    with open("/proc/stat") as stream:
        return [int(field) for field in stream.readline().split()[1:9]]


def run(scene, rate_hz, seconds, build):
    """One row of the table."""
    before = processor_times()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [ROOT / "scripts/launch", scene, "--duration", str(seconds), "--build", build,
             "--sim", f"--rate {rate_hz}", "--report-dir", folder],
            check=True, stdout=subprocess.DEVNULL)
        report = json.loads((pathlib.Path(folder) / "sim.json").read_text())
    row = {"scene": scene, "rate_hz": rate_hz, "seconds": seconds, "steps": report["steps"],
           "late_steps": report["late_steps"],
           "out_of_budget": report["solver"]["out_of_budget"],
           "not_converged": report["solver"]["not_converged"],
           "stolen_share": f"{stolen_share(before, processor_times()):.4f}"}
    row.update({f"step_{name}_ms": report["step_ms"][name] for name in PERCENTILES})
    row.update({f"{phase}_{name}_ms": report["phases_ms"][phase][name]
                for phase in PHASES for name in PERCENTILES})
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", default="tissue_and_blocks")
    parser.add_argument("--rates", type=float, nargs="+", default=[33, 100], metavar="HZ")
    parser.add_argument("--seconds", type=float, default=600.0, help="of each rate")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--csv", type=pathlib.Path, default=ROOT / "docs/charts/step_times.csv")
    arguments = parser.parse_args()
    rows = []
    for rate_hz in arguments.rates:
        rows.append(run(arguments.scene, rate_hz, arguments.seconds, arguments.build))
        print(f"{rate_hz:g} Hz: {rows[-1]['late_steps']} of {rows[-1]['steps']} late, "
              f"p99 {rows[-1]['step_p99_ms']} ms of {1e3 / rate_hz:.1f} ms")
    write_rows(arguments.csv, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
