#!/usr/bin/python3
"""Measures the detection of contacts and writes docs/charts/{detection_speed,voxel_ratio}.csv.

detection_speed: processor time per sphere and step for all pairs of N moving spheres, by ours and by
others, on the same paths in one run; medians of rounds and distances between quartiles, and the
pairs found, which must be the same. voxel_ratio: the paper's Fig. 4.
"""
import csv
import io
import os
import statistics

from benchmark_report import processor_name, processor_times
from measuring import output_of, parser_of, program
from tables import write_rows


def rows_of(command):
    """What a program prints as CSV, and a note on the machine's load meanwhile."""
    load, before = os.getloadavg()[0], processor_times()
    text = output_of(command)
    after = processor_times()
    stolen = 100.0 * (after[1] - before[1]) / max(1, after[0] - before[0])
    note = (f"{processor_name()}; one thread, Release, not tuned for the processor. Processor time; "
            f"load {load:.1f} at the start, {stolen:.1f} % of the time stolen by the host.")
    return list(csv.DictReader(io.StringIO(text))), note


def measure_speed(benchmark, rounds, most):
    """Rows and notes."""
    measured, note = rows_of([benchmark, rounds, most])
    samples, pairs = {}, {}
    for row in measured:
        key = row["motion"], row["method"], int(row["spheres"])
        samples.setdefault(key, []).append(float(row["ns"]))
        pairs.setdefault(key, []).append(float(row["pairs_each"]))
    rows = []
    for (motion, method, spheres), ns in samples.items():
        low, median, high = statistics.quantiles(ns, n=4, method="inclusive") if len(ns) > 1 else ns * 3
        rows.append({"motion": motion, "method": method, "spheres": spheres, "ns": f"{median:.4g}",
                     "iqr_ns": f"{high - low:.2g}", "least_ns": f"{min(ns):.4g}", "rounds": len(ns),
                     "pairs_each": f"{statistics.mean(pairs[motion, method, spheres]):.3f}"})
    return rows, [note, "0.95 pairs a sphere overlap, radii from half to one and a half of the mean; slow: "
                        "straight on, a twentieth of the mean a step; far: three, so that every step is a full search.",
                        "ours, in a step: what the simulation does to find its contacts, which are what may touch "
                        "within the step."]


def measure_ratio(figures):
    rows, note = rows_of([figures])
    return rows, [note, "4,000 spheres, 0.95 overlaps each; per sphere. ratio: voxel / diameter. "
                        "expected: docs/cases.md, case 2.8."]


def main():
    parser = parser_of(__doc__, "detection_speed: 3 rounds up to 4,000 spheres, not 15 up to 400,000; "
                                "voxel_ratio is small")
    parser.add_argument("table", choices=("detection_speed", "voxel_ratio"), metavar="TABLE",
                        help="detection_speed or voxel_ratio")
    arguments = parser.parse_args()
    if arguments.table == "voxel_ratio":
        rows, notes = measure_ratio(program(arguments.build, "voxel_ratio_figures"))
    else:
        rounds, most = (3, 4000) if arguments.small else (15, 400000)
        rows, notes = measure_speed(program(arguments.build, "detection_benchmark"), rounds, most)
    write_rows(arguments.charts / f"{arguments.table}.csv", rows, notes)


if __name__ == "__main__":
    main()
