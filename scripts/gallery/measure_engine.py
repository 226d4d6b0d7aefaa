#!/usr/bin/python3
"""Measures our engine beside Bullet and MuJoCo and writes docs/charts/engine_peers.csv.

One run of engine_benchmark, repetitions in random order: medians, and the coefficient of variation of the time.
us is processor time per body and 10 ms of piles, per 10 ms of a chain, per tick of 1 ms of a neighbourhood.
"""
import json
import pathlib
import statistics
import tempfile

from benchmark_report import NS, processor_name, run_benchmark
from measuring import parser_of, program
from tables import write_rows

COUNTERS = ("overlap_mm", "height_mm", "gap_mm", "error_mm", "touching")


def row_of(name, runs):
    per_body = "per_body" in runs[0]
    us = [1e6 * run["per_body"] if per_body else 1e-3 * run["cpu_time"] * NS[run["time_unit"]] for run in runs]
    spread = 100.0 * statistics.stdev(us) / statistics.mean(us) if len(us) > 1 else 0.0
    scene, engine, *count = [word for word in name.split("/") if not word.startswith(("iterations", "real_time"))]
    median = {key: f"{statistics.median(run[key] for run in runs):.4g}" if key in runs[0] else ""
              for key in COUNTERS}
    return {"scene": scene, "engine": engine, "bodies": count[0] if count else "",
            "us": f"{statistics.median(us):.4g}", "cv_percent": f"{spread:.1f}", **median}


def main():
    parser = parser_of(__doc__, "2 repetitions of the small scenes, not 3 of all")
    parser.add_argument("--filter", metavar="PATTERN", help="these benchmarks; default: all")
    arguments = parser.parse_args()
    repetitions, pattern = (2, "/400/|/[a-z_]*1000_N|2000_") if arguments.small else (3, ".*")
    with tempfile.TemporaryDirectory() as name:
        report = pathlib.Path(name) / "report.json"
        load, stolen = run_benchmark(program(arguments.build, "engine_benchmark"), repetitions,
                                     arguments.filter or pattern, report)
        runs = json.loads(report.read_text())["benchmarks"]
    by_name = {}
    for run in runs:
        if run["run_type"] == "iteration":
            by_name.setdefault(run["run_name"], []).append(run)
    rows = [row_of(name, of_name) for name, of_name in by_name.items() if name.count("/") > 1]
    rows.sort(key=lambda row: (row["scene"], int(row["bodies"] or 0), row["engine"]))
    write_rows(arguments.charts / "engine_peers.csv", rows,
               [f"{processor_name()}; Release, not tuned for the processor; one thread but for ours_two_threads.",
                f"Medians of {repetitions} repetitions in random order; load {load:.1f} at the start, {stolen:.1f} % "
                "of the time stolen by the host. Processor time; wall time of ours_two_threads."])


if __name__ == "__main__":
    main()
