#!/usr/bin/python3
"""Measures how long the simulation's steps take in real time: docs/charts/step_times.csv.

Runs both daemons on tissue_and_blocks with a phantom at its device, ten minutes at each of two rates,
and keeps what sim_server's report says. The machine's stolen time is written beside: a step that its
host did not run is late whatever the solver.
"""
import json
import pathlib
import subprocess
import tempfile

from benchmark_report import processor_times
from measuring import ROOT, parser_of
from tables import write_rows

SCENE = "tissue_and_blocks"
RATES_HZ = (33, 100)
PERCENTILES = ("p50", "p99", "p999", "max")
PHASES = ("detect", "respond", "integrate", "publish")


def run(rate_hz, seconds, build):
    """One row of the table."""
    all_before, stolen_before = processor_times()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [ROOT / "scripts/launch", SCENE, "--duration", str(seconds), "--build", build,
             "--sim", f"--rate {rate_hz}", "--report-dir", folder],
            check=True, stdout=subprocess.DEVNULL)
        report = json.loads((pathlib.Path(folder) / "sim.json").read_text())
    all_after, stolen_after = processor_times()
    row = {"scene": SCENE, "rate_hz": rate_hz, "seconds": seconds, "steps": report["steps"],
           "late_steps": report["late_steps"],
           "out_of_budget": report["solver"]["out_of_budget"],
           "not_converged": report["solver"]["not_converged"],
           "stolen_share": f"{(stolen_after - stolen_before) / max(1, all_after - all_before):.4f}"}
    row.update({f"step_{name}_ms": report["step_ms"][name] for name in PERCENTILES})
    row.update({f"{phase}_{name}_ms": report["phases_ms"][phase][name]
                for phase in PHASES for name in PERCENTILES})
    return row


def main():
    arguments = parser_of(__doc__, "4 s at each rate").parse_args()
    rows = []
    for rate_hz in RATES_HZ:
        rows.append(run(rate_hz, 4.0 if arguments.small else 600.0, arguments.build))
        print(f"{rate_hz:g} Hz: {rows[-1]['late_steps']} of {rows[-1]['steps']} late, "
              f"p99 {rows[-1]['step_p99_ms']} ms of {1e3 / rate_hz:.1f} ms")
    write_rows(arguments.charts / "step_times.csv", rows)


if __name__ == "__main__":
    main()
