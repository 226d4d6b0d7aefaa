#!/usr/bin/python3
"""Measures blobs beside plain spheres, as force and as time, with the program blob_benchmark, which takes
meshes of the folder of real inputs where it is there: docs/charts/blobs_vs_spheres.csv."""
import json
import statistics

from measuring import output_of, parser_of, program
from tables import write_rows

COUNTERS = ("spheres", "error_mm", "ripple", "least_over_most", "holes", "tangential", "stiffness",
            "mean_over_depth")


def rows_of(report):
    runs = {}
    for run in report["benchmarks"]:
        if run.get("run_type") == "iteration":
            runs.setdefault(run["name"].split("/repeats")[0], []).append(run)
    rows = []
    for name, repeats in runs.items():
        _, model, mesh, _ = name.split("/")
        times = [run["real_time"] for run in repeats]
        values = {counter: repeats[0][counter] for counter in COUNTERS}
        values |= {"ns_median": statistics.median(times), "ns_least": min(times), "ns_most": max(times)}
        rows.append({"mesh": mesh.split(".")[0], "model": model,
                     **{key: f"{value:.5g}" for key, value in values.items()}})
    # Interleaved runs come in any order.
    return sorted(rows, key=lambda row: (row["mesh"], row["model"], float(row["spheres"])))


def main():
    arguments = parser_of(__doc__, "one repetition, not nine, of the torus and the sphere").parse_args()
    command = [program(arguments.build, "blob_benchmark"), "--benchmark_format=json",
               f"--benchmark_repetitions={1 if arguments.small else 9}",
               f"--benchmark_min_time={0.02 if arguments.small else 0.5}"]
    if arguments.small:
        command.append("sofa_torus.obj")
    write_rows(arguments.charts / "blobs_vs_spheres.csv", rows_of(json.loads(output_of(command))))


if __name__ == "__main__":
    main()
