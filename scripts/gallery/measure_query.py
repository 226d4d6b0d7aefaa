#!/usr/bin/python3
"""Measures the tick's query beside Bullet's and nanoflann's trees; writes docs/charts/query_speed.csv.

A row a benchmark of query_benchmark, all of them in turn in one run, the run repeated: the median of
the runs and the distance between their quartiles. Every method sums the same force or is not
measured. Figures of the handbook stand beside: another machine's, so compare ratios, not times.
"""
import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

# (question, method): ns at N = 400, 40,000, 400,000, of the handbook's table of peers.
SIZES = (400, 40000, 400000)
HANDBOOK = {
    ("query_hot", "grid"): (42, 41, 43), ("query_anywhere", "grid"): (94, 148, 199),
    ("query_flushed", "grid"): (1653, 2354, 2614),
    ("query_hot", "Bullet_dbvt"): (124, 250, 292), ("query_anywhere", "Bullet_dbvt"): (351, 2608, 6848),
    ("query_flushed", "Bullet_dbvt"): (6852, 25693, 32355),
    ("query_hot", "nanoflann"): (88, 156, 181), ("query_anywhere", "nanoflann"): (231, 558, 895),
    ("query_flushed", "nanoflann"): (3626, 7833, 11560),
}


def one_run(program, out):
    subprocess.run([program, "--benchmark_min_time=0.05", f"--benchmark_out={out}",
                    "--benchmark_out_format=json"], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    for run in json.loads(out.read_text())["benchmarks"]:
        if run.get("error_occurred"):
            raise ValueError(f"{run['name']}: {run['error_message']}")
        question, method, spheres = run["name"].split("/")[:3]
        yield (question, method, int(spheres)), run.get("median_ns", run["cpu_time"])


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, metavar="FILE",
                        default=root / "build" / "release" / "tests" / "query_benchmark")
    parser.add_argument("--runs", type=int, default=9, metavar="N")
    parser.add_argument("--out", type=pathlib.Path, metavar="FILE.csv",
                        default=root / "docs" / "charts" / "query_speed.csv")
    arguments = parser.parse_args()
    times = {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(arguments.runs):
                for key, ns in one_run(arguments.program, pathlib.Path(folder) / "run.json"):
                    times.setdefault(key, []).append(ns)
        with open(arguments.out, "w") as stream:
            stream.write(f"# medians and quartile distances of {arguments.runs} runs, ns a query; "
                         "handbook: another machine, its cell list beside our grid\n")
            rows = csv.writer(stream, lineterminator="\n")
            rows.writerow(["question", "method", "spheres", "median_ns", "spread_ns", "handbook_ns"])
            for (question, method, spheres), runs in times.items():
                low, _, high = statistics.quantiles(runs, n=4)
                rows.writerow([question, method, spheres, f"{statistics.median(runs):.4g}",
                               f"{high - low:.2g}",
                               HANDBOOK[question, method][SIZES.index(spheres)]])
    except (OSError, ValueError, KeyError, subprocess.CalledProcessError) as error:
        sys.exit(f"measure_query: {type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
