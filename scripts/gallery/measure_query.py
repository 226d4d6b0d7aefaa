#!/usr/bin/python3
"""Measures the tick's query beside Bullet's and nanoflann's trees; writes docs/charts/query_speed.csv.

lists: what static spheres are searched in; grid: what moving ones are. A row a benchmark of
query_benchmark, all of them in turn in one run, the run repeated: the median of the runs and the
distance between their quartiles. Every method sums the same force or is not measured. Figures of
another machine stand beside: compare ratios, not times.
"""
import json
import pathlib
import statistics
import tempfile

from measuring import fail, output_of, parser_of, program
from tables import write_rows

# (question, method): ns at N = 400, 40,000, 400,000, of another machine, where they were measured by a prototype.
SIZES = (400, 40000, 400000)
PUBLISHED = {
    ("query_hot", "lists"): (34, 33, 34), ("query_anywhere", "lists"): (36, 244, 307),
    ("query_flushed", "lists"): (1583, 1753, 1843),
    ("query_hot", "grid"): (42, 41, 43), ("query_anywhere", "grid"): (94, 148, 199),
    ("query_flushed", "grid"): (1653, 2354, 2614),
    ("query_hot", "Bullet_dbvt"): (124, 250, 292), ("query_anywhere", "Bullet_dbvt"): (351, 2608, 6848),
    ("query_flushed", "Bullet_dbvt"): (6852, 25693, 32355),
    ("query_hot", "nanoflann"): (88, 156, 181), ("query_anywhere", "nanoflann"): (231, 558, 895),
    ("query_flushed", "nanoflann"): (3626, 7833, 11560),
}


def one_run(benchmark, sizes, folder, last_cache_mb):
    out = pathlib.Path(folder) / "run.json"
    output_of([benchmark, "--benchmark_min_time=0.05", f"--benchmark_filter=/({sizes})(/|$)",
               f"--benchmark_out={out}",
               "--benchmark_out_format=json"])
    report = json.loads(out.read_text())
    last_cache_mb.append(report["context"]["last_cache_mb"])
    for run in report["benchmarks"]:
        if run.get("error_occurred"):
            fail(f"{run['name']}: {run['error_message']}")
        question, method, spheres = run["name"].split("/")[:3]
        yield (question, method, int(spheres)), run.get("median_ns", run["cpu_time"])


def main():
    arguments = parser_of(__doc__, "two runs, not five, up to 40,000 spheres of 400,000").parse_args()
    runs, sizes = (2, "400|40000") if arguments.small else (5, "[0-9]+")
    times, last_cache_mb = {}, []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(runs):
            for key, ns in one_run(program(arguments.build, "query_benchmark"), sizes, folder,
                                   last_cache_mb):
                times.setdefault(key, []).append(ns)
    rows = []
    for (question, method, spheres), samples in times.items():
        low, median, high = statistics.quantiles(samples, n=4, method="inclusive")
        rows.append({"question": question, "method": method, "spheres": spheres,
                     "median_ns": f"{median:.4g}", "spread_ns": f"{high - low:.2g}",
                     "published_ns": PUBLISHED[question, method][SIZES.index(spheres)]})
    write_rows(arguments.charts / "query_speed.csv", rows,
               [f"medians and quartile distances of {runs} runs, ns a query; 0.95 pairs a sphere, radii from half "
                "to one and a half of the mean",
                f"flushed: 1.25 times the last cache, {last_cache_mb[-1]} MB here, read and written before "
                "each query; published_ns: another machine, its prototypes beside our lists and our grid"])


if __name__ == "__main__":
    main()
