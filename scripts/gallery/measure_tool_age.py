#!/usr/bin/python3
"""Measures how old the tool's sample is when its snapshot is published: docs/charts/tool_age.csv.

Runs both daemons on tissue_and_blocks, a hand pressing through to the tissue, with one method and
rate after the other, and keeps what sim_server's report says. Rows of other builds stay in the
table: give each its --label.
"""
import json
import pathlib
import subprocess
import tempfile

from measuring import ROOT, fail, parser_of
from tables import read_rows, write_rows

SCENE = ROOT / "sim_server/scene/scenes/tissue_and_blocks.toml"
# Through the gap between the blocks into the tissue, once a second.
HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"
METHODS = {"velocity_verlet": 'integrator = "velocity_verlet"',
           "newton": 'integrator = "implicit_euler"\nsolver = "newton"'}
RATES_HZ = (10, 33, 100)
PERCENTILES = ("p50", "p99", "p999", "max")


def scene_with(method, folder):
    text = SCENE.read_text()
    shipped = 'integrator = "velocity_verlet"'
    if shipped not in text:
        fail(f"{SCENE}: expected the line {shipped}")
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
    parser = parser_of(__doc__, "2 s a run, not 20")
    parser.add_argument("--label", default="late samples", help="of this build's rows")
    arguments = parser.parse_args()
    table = arguments.charts / "tool_age.csv"
    rows = [row for row in read_rows(table) if row["build"] != arguments.label] if table.exists() else []
    for method in METHODS:
        for rate_hz in RATES_HZ:
            row = run(arguments.label, method, rate_hz, 2.0 if arguments.small else 20.0, arguments.build)
            rows.append(row)
            print(f"{method}, {rate_hz:g} Hz: age p50 {row['age_p50_ms']}, p99 {row['age_p99_ms']}"
                  f" ms; step p50 {row['step_p50_ms']}, p99 {row['step_p99_ms']} ms", flush=True)
    write_rows(table, rows)


if __name__ == "__main__":
    main()
