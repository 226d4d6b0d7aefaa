#!/usr/bin/python3
"""Draws docs/charts/blobs_vs_spheres.png from its CSV; with a JSON of blob_benchmark, writes that
CSV first:

  blob_benchmark --benchmark_repetitions=9 --benchmark_format=json > blobs.json
  plot_blobs.py blobs.json
"""
import argparse
import csv
import json
import pathlib
import statistics
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker

CHARTS = pathlib.Path(__file__).resolve().parents[2] / "docs/charts"
COUNTERS = ("spheres", "error_mm", "ripple", "least_over_most", "holes", "tangential", "stiffness",
            "mean_over_depth")
COLUMNS = ("mesh", "model", *COUNTERS, "ns_median", "ns_least", "ns_most")
STYLES = {"spheres": ("#888888", "s"), "blobs": ("#0072B2", "o")}
# quantity, how it is called, whether logarithmic
PANELS = (("ripple", "force ripple\n(std / mean)", True),
          ("holes", "share of surface\nin holes", False),
          ("stiffness", "effective stiffness\n(material: 1)", True),
          ("error_mm", "surface error [mm]\n(Hausdorff)", True),
          ("ns_median", "one force [ns]", True))


def rows_of_benchmark(file):
    runs = {}
    for run in json.loads(pathlib.Path(file).read_text())["benchmarks"]:
        if run.get("run_type") == "iteration":
            runs.setdefault(run["name"].split("/repeats")[0], []).append(run)
    rows = []
    for name, repeats in runs.items():
        _, model, mesh, _ = name.split("/")
        times = [run["real_time"] for run in repeats]
        row = {"mesh": mesh.split(".")[0], "model": model, "ns_median": statistics.median(times),
               "ns_least": min(times), "ns_most": max(times)}
        row.update({counter: repeats[0][counter] for counter in COUNTERS})
        rows.append({key: value if isinstance(value, str) else f"{value:.5g}"
                     for key, value in row.items()})
    # Interleaved runs come in any order.
    return sorted(rows, key=lambda row: (row["mesh"], row["model"], float(row["spheres"])))


def write_rows(rows, file):
    with open(file, "w", newline="") as stream:
        writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read_rows(file):
    with open(file) as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def draw_curve(axes, rows, quantity, model):
    colour, marker = STYLES[model]
    rows = sorted((row for row in rows if row["model"] == model),
                  key=lambda row: float(row["spheres"]))
    x = [float(row["spheres"]) for row in rows]
    y = [float(row[quantity]) for row in rows]
    axes.plot(x, y, marker=marker, color=colour, markersize=5)
    if quantity == "ns_median":
        spread = [[abs(float(row["ns_median"]) - float(row[end])) for row in rows]
                  for end in ("ns_least", "ns_most")]
        axes.errorbar(x, y, yerr=spread, color=colour, capsize=2, linewidth=1.0)


def draw(rows):
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9})
    meshes = list(dict.fromkeys(row["mesh"] for row in rows))
    figure, grid = plt.subplots(len(PANELS), len(meshes), sharex="col", sharey="row",
                                figsize=(2.8 * len(meshes) + 1.0, 10.5), squeeze=False)
    for line, (quantity, label, is_log) in zip(grid, PANELS):
        for axes, mesh in zip(line, meshes):
            for model in STYLES:
                draw_curve(axes, [row for row in rows if row["mesh"] == mesh], quantity, model)
            axes.set_xscale("log")
            if is_log:
                axes.set_yscale("log")
                axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
                axes.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
            counts = sorted({int(float(row["spheres"])) for row in rows if row["mesh"] == mesh})
            axes.set_xticks(counts, [str(count) for count in counts])
            axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
            axes.grid(axis="y", color="0.93")
            if quantity == "stiffness":
                axes.axhline(1.0, color="0.7", linewidth=1.0, zorder=0)
                axes.set_yticks((0.3, 0.5, 1.0, 2.0))
        line[0].set_ylabel(label)
    for axes, mesh in zip(grid[0], meshes):
        axes.set_title(mesh, loc="left", fontsize=10, fontweight="bold")
    for axes in grid[-1]:
        axes.set_xlabel("spheres")
    handles = [plt.Line2D([], [], color=colour, marker=marker) for colour, marker in STYLES.values()]
    figure.legend(handles, ["spheres, contacts summed", "the same number of blobs"], ncol=2,
                  loc="upper right", frameon=False, bbox_to_anchor=(0.99, 0.985))
    figure.suptitle("Blobs beside plain spheres", x=0.01, y=0.985, ha="left", fontsize=12.5,
                    fontweight="bold")
    figure.text(0.01, 0.952, "Box diagonal 200 mm, tool of 4 mm radius pressed 1 mm deep all over",
                color="0.35", fontsize=9.5)
    figure.align_ylabels()
    figure.tight_layout(rect=(0, 0, 1, 0.955))
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmark", nargs="?", metavar="BENCHMARK.json")
    arguments = parser.parse_args()
    rows_file = CHARTS / "blobs_vs_spheres.csv"
    try:
        if arguments.benchmark:
            write_rows(rows_of_benchmark(arguments.benchmark), rows_file)
        figure = draw(read_rows(rows_file))
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"plot_blobs: {type(error).__name__}: {error}")
    figure.savefig(CHARTS / "blobs_vs_spheres.png", dpi=110, facecolor="white")


if __name__ == "__main__":
    main()
