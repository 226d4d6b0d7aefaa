#!/usr/bin/python3
"""Measures whole steps of piles of rigid spheres: docs/charts/pile_steps.csv.

A row an engine and number of spheres, awake (fallen into a bin for half a second) or sleeping (lying): the
processor time of a step of 10 ms over the spheres, of two threads the clock's, the median of the repetitions
and the distance of their quartiles. Ours is what sim_server does of a period, publication included. A row is left out where the build
has not the engine.
"""
import json
import pathlib
import statistics
import tempfile

from benchmark_report import processor_name
from measuring import output_of, parser_of, program
from tables import write_rows

REPETITIONS = {400: 9, 4_000: 7, 40_000: 5, 400_000: 3}
NAMES = {"ours_predicting": "ours, predicting", "ours_two_threads": "ours, two threads"}


def ns_a_sphere(run, count):
    """Of two threads what the clock says, which is what they are for."""
    return 1e3 * run["real_time"] / count if "two_threads" in run["name"] else run["ns_per_sphere"]


def measure(benchmark, states, count, repetitions):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "run.json"
        output_of([benchmark, f"--benchmark_filter=^({states})/.*/{count}/", f"--benchmark_repetitions={repetitions}",
                   "--benchmark_min_time=0.05", f"--benchmark_out={out}", "--benchmark_out_format=json"])
        runs = json.loads(out.read_text())["benchmarks"]
    samples = {}
    for run in runs:
        if run["run_type"] == "iteration" and not run.get("error_occurred"):
            samples.setdefault(tuple(run["run_name"].split("/")[:2]), []).append(run)
    for (state, engine), of in samples.items():
        low, median, high = statistics.quantiles([ns_a_sphere(run, count) for run in of], n=4,
                                                 method="inclusive")
        yield {"state": state, "engine": NAMES.get(engine, engine), "spheres": count,
               "ns": f"{median:.4g}", "iqr_ns": f"{high - low:.2g}", "repetitions": len(of),
               "touching_each": f"{statistics.median(run['touching_per_sphere'] for run in of):.2f}",
               "mean_height_mm": f"{statistics.median(run['mean_height_mm'] for run in of):.1f}"}


def main():
    parser = parser_of(__doc__, "400 spheres, 3 repetitions")
    parser.add_argument("--most", type=int, default=400_000, metavar="N", help="spheres; default: 400000")
    parser.add_argument("--most-awake", type=int, default=400_000, metavar="N", help="awake; default: 400000")
    arguments = parser.parse_args()
    most = 400 if arguments.small else arguments.most
    rows = []
    for count, repetitions in REPETITIONS.items():
        if count <= most:
            states = "awake|sleeping" if count <= arguments.most_awake else "sleeping"
            rows += measure(program(arguments.build, "pile_benchmark"), states, count,
                            3 if arguments.small else repetitions)
    write_rows(arguments.charts / "pile_steps.csv", rows,
               [f"{processor_name()}; processor time, of two threads the clock's; Release, not tuned for the processor",
                "spheres of 8 to 12 mm and 1 g/cm3, friction 0.5, steps of 10 ms; awake: ten layers that fell for "
                "0.5 s into a bin; sleeping: one layer that lies"])


if __name__ == "__main__":
    main()
