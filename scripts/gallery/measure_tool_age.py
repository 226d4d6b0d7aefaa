#!/usr/bin/python3
"""Measures how old the tool's sample is when its image is published: docs/charts/tool_age.csv.

Runs both daemons on tissue_and_blocks, a hand pressing through to the tissue, with one method and
rate after the other, and keeps what sim_server's report says. Rows of other builds stay in the
table: give each its --label. scripts/gallery/plot_tool_age.py draws the chart.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

from tables import read_rows, write_rows

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "sim_server/scene/scenes/tissue_and_blocks.toml"
# Through the gap between the blocks into the tissue, once a second.
HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"
METHODS = {"velocity_verlet": 'integrator = "velocity_verlet"',
           "newton": 'integrator = "implicit_euler"\nsolver = "newton"'}
PERCENTILES = ("p50", "p99", "p999", "max")


def scene_with(method, folder):
    text = SCENE.read_text()
    shipped = 'integrator = "velocity_verlet"'
    if shipped not in text:
        raise RuntimeError(f"{SCENE}: expected the line {shipped}")
    file = pathlib.Path(folder) / "scene.toml"
    file.write_text(text.replace(shipped, METHODS[method]))
    return file


def run(label, method, rate_hz, seconds, build):
    """One row of the table."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [ROOT / "scripts/launch", scene_with(method, folder), "--duration", str(seconds),
             "--build", build, "--device", HAND, "--sim", f"--rate {rate_hz}",
             "--report-dir", folder],
            check=True, stdout=subprocess.DEVNULL)
        report = json.loads((pathlib.Path(folder) / "sim.json").read_text())
    row = {"build": label, "method": method, "rate_hz": rate_hz, "seconds": seconds,
           "steps": report["steps"], "late_steps": report["late_steps"],
           "out_of_budget": report["solver"]["out_of_budget"],
           "not_converged": report["solver"]["not_converged"],
           "iterations": f"{report['solver']['iterations']:.3f}",
           "contacts": f"{report['contacts']:.1f}"}
    for key, name in (("tool_age_ms", "age"), ("step_ms", "step")):
        row.update({f"{name}_{p}_ms": f"{report[key][p]:.4f}" for p in PERCENTILES})
    row["publish_p50_ms"] = f"{report['phases_ms']['publish']['p50']:.4f}"
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--label", default="late samples", help="of this build's rows")
    parser.add_argument("--rates", type=float, nargs="+", default=[10, 33, 100], metavar="HZ")
    parser.add_argument("--methods", nargs="+", default=list(METHODS), choices=list(METHODS))
    parser.add_argument("--seconds", type=float, default=20.0, help="of each run")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--csv", type=pathlib.Path, default=ROOT / "docs/charts/tool_age.csv")
    arguments = parser.parse_args()
    rows = []
    if arguments.csv.exists():
        rows = [row for row in read_rows(arguments.csv) if row["build"] != arguments.label]
    for method in arguments.methods:
        for rate_hz in arguments.rates:
            row = run(arguments.label, method, rate_hz, arguments.seconds, arguments.build)
            rows.append(row)
            print(f"{method}, {rate_hz:g} Hz: age p50 {row['age_p50_ms']}, p99 {row['age_p99_ms']}"
                  f" ms; step p50 {row['step_p50_ms']}, p99 {row['step_p99_ms']} ms", flush=True)
    write_rows(arguments.csv, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
