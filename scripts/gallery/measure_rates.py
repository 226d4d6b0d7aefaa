#!/usr/bin/python3
"""Measures the rates of the scenes that ship, each on its own hand: docs/charts/rates.csv, and prints the table of
docs/algorithms/rate_choice.md.

A row is a rate: what the simulation costs of a processor, by how much the force errs, the worst of eight runs. What
scenes shipped with before they had a hand stands in BEFORE, measured once by the same runs on that version.
"""
import json
import pathlib
import subprocess
import tempfile
import tomllib

from measuring import ROOT, fail, parser_of
from tables import write_rows

# Rate, share of a processor and error of the force, as shipped before (velocity Verlet).
BEFORE = {"tissue_and_blocks": (33.0, 0.0693, 0.388), "threads": (50.0, 0.0316, 0.0421),
          "organ": (50.0, 0.0379, 0.224), "laparoscopy": (50.0, 0.0521, 0.293)}
SCENES = ROOT / "sim_server/scene/scenes"
JUST_NOTICEABLE = 0.07


def curve_of(build, scene):
    """The record of one scene's choice."""
    with tempfile.TemporaryDirectory() as folder:
        record = pathlib.Path(folder) / "choice.json"
        run = subprocess.run([build / "bin/sim_server", "--scene", SCENES / f"{scene}.toml", "--explain", "--choice",
                              record], capture_output=True, text=True, check=False)
        if run.returncode:
            fail(f"{scene}: {run.stderr.strip().splitlines()[-1]}")
        return json.loads(record.read_text())


def rows_of(build, scene):
    simulation = tomllib.loads((SCENES / f"{scene}.toml").read_text())["simulation"]
    shipped_hz = simulation.get("rate_hz", 1.0 / simulation.get("period_s", 0.01))
    record = curve_of(build, scene)
    rows = [{"scene": scene, "role": "before", "rate_hz": BEFORE[scene][0], "processor_share": BEFORE[scene][1],
             "error_share": BEFORE[scene][2], "runs": 8}] if scene in BEFORE else []
    for rate in record["rates"]:
        rows.append({"scene": scene, "role": "shipped" if abs(rate["rate_hz"] - shipped_hz) < 1e-6 * shipped_hz else "",
                     "rate_hz": rate["rate_hz"], "processor_share": rate.get("processor_share", ""),
                     "error_share": rate.get("error_share", ""), "runs": rate["runs"]})
    return rows


def table_of(rows):
    lines = ["| scene | | rate, Hz | a processor | error | JND |", "|---|---|---|---|---|---|"]
    for row in rows:
        if row["role"]:
            lines.append(f"| {row['scene']} | {row['role']} | {row['rate_hz']:g} | {100 * row['processor_share']:.2g} % | "
                         f"{100 * row['error_share']:.2g} % | {row['error_share'] / JUST_NOTICEABLE:.2f} |")
    return "\n".join(lines)


def main():
    arguments = parser_of(__doc__, "threads only").parse_args()
    scenes = ["threads"] if arguments.small else list(BEFORE)
    rows = [row for scene in scenes for row in rows_of(arguments.build, scene)]
    write_rows(arguments.charts / "rates.csv", rows)
    print(table_of(rows))


if __name__ == "__main__":
    main()
