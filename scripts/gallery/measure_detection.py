#!/usr/bin/python3
"""Measures the detection of contacts and writes docs/charts/{detection_speed,voxel_ratio}.csv.

detection_speed: processor time per sphere and step for all pairs of N moving spheres, by ours and by
others, on the same paths in one run; medians of rounds and distances between quartiles, and the
pairs found, which must be the same. voxel_ratio: the paper's Fig. 4. Draw both with
plot_detection.py.
"""
import argparse
import csv
import io
import os
import pathlib
import statistics
import subprocess
import sys

from measure_publication import write_csv
from benchmark_report import processor_name, processor_times

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHARTS = ROOT / "docs/charts"


def rows_of(command):
    """What a program prints as CSV, and a note on the machine's load meanwhile."""
    load, before = os.getloadavg()[0], processor_times()
    text = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    after = processor_times()
    stolen = 100.0 * (after[1] - before[1]) / max(1, after[0] - before[0])
    note = (f"{processor_name()}; one thread, Release, not tuned for the processor. Processor time; "
            f"load {load:.1f} at the start, {stolen:.1f} % of the time stolen by the host.")
    return list(csv.DictReader(io.StringIO(text))), note


def measure_speed(program, rounds, most, out):
    rows, note = rows_of([program, str(rounds), str(most)])
    samples, overlaps = {}, {}
    for row in rows:
        key = row["motion"], row["method"], int(row["spheres"])
        samples.setdefault(key, []).append(float(row["ns"]))
        overlaps.setdefault(key, []).append(float(row["overlaps_each"]))
    table = []
    for (motion, method, spheres), ns in samples.items():
        low, median, high = statistics.quantiles(ns, n=4, method="inclusive") if len(ns) > 1 else ns * 3
        table.append([motion, method, spheres, f"{median:.4g}", f"{high - low:.2g}", f"{min(ns):.4g}",
                      len(ns), f"{statistics.mean(overlaps[motion, method, spheres]):.3f}"])
    write_csv(out, [note, "slow: straight on, a twentieth of a radius a step; far: three radii, so "
                          "that every step is a full search."],
              ["motion", "method", "spheres", "ns", "iqr_ns", "least_ns", "rounds", "overlaps_each"],
              table)


def measure_ratio(program, out):
    rows, note = rows_of([program])
    write_csv(out, [note, "4,000 spheres, 0.95 overlaps each; per sphere. ratio: voxel / diameter. "
                          "expected: the handbook's formulas."], rows[0].keys(),
              [row.values() for row in rows])


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/tests",
                        help="folder of detection_benchmark and voxel_ratio_figures")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--most", type=int, default=400000, help="spheres")
    parser.add_argument("--out", type=pathlib.Path, default=CHARTS, help="folder for the CSV files")
    arguments = parser.parse_args()
    for name in ("detection_benchmark", "voxel_ratio_figures"):
        if not (arguments.programs / name).exists():
            sys.exit(f"measure_detection: {arguments.programs / name}: not there; scripts/build first")
    measure_speed(arguments.programs / "detection_benchmark", arguments.rounds, arguments.most,
                  arguments.out / "detection_speed.csv")
    measure_ratio(arguments.programs / "voxel_ratio_figures", arguments.out / "voxel_ratio.csv")


if __name__ == "__main__":
    main()
