#!/usr/bin/python3
"""Draws our benchmarks as bars beside the figures of others.

A benchmark is named QUESTION/METHOD or QUESTION/METHOD/SPHERES: detect/grid/400. Rows of a CSV
have the columns question,method,spheres,ns (figures of others) or those that measure_step1.py
writes (ours, with a figure beside); "#" lines are notes. Questions:
  detect          all contacts among N moving spheres; drawn per sphere
  query_hot       the force on one probe among N spheres, caches warm
  query_flushed   the same, caches flushed, as a tick once a millisecond finds them
  anything else   is drawn as it is, one panel each
"""
import argparse
import csv
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker

TITLES = {
    "detect": "All contacts of N moving spheres,\nper sphere and step",
    "query_hot": "Force on one probe among N spheres,\ncaches warm",
    "query_flushed": "Force on one probe among N spheres,\ncaches flushed",
}
PER_SPHERE = {"detect"}
NS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
PANELS_A_ROW = 4
OURS, THEIRS = "#0072B2", "#BBBBBB"


def read_benchmarks(file):
    """Rows (question, method, spheres or None, ns) of Google Benchmark's JSON; medians if repeated."""
    runs = json.loads(pathlib.Path(file).read_text())["benchmarks"]
    medians = [run for run in runs if run.get("aggregate_name") == "median"]
    rows = []
    for run in medians or [run for run in runs if run.get("run_type", "iteration") == "iteration"]:
        words = run.get("run_name", run["name"]).split("/")
        if run.get("error_occurred") or len(words) < 2:
            continue
        spheres = int(words[2]) if len(words) > 2 and words[2].isdigit() else None
        clock = "real_time" if "manual_time" in words else "cpu_time"
        ns = run[clock] * NS[run["time_unit"]]
        if words[0] in PER_SPHERE and spheres:
            ns /= spheres
        rows.append((words[0], f"Stillgrid: {words[1].replace('_', ' ')}", spheres, ns))
    return rows


def read_rows(file):
    """Rows of ours and rows of others, from a CSV of either kind."""
    ours, theirs = [], []
    with open(file) as stream:
        for row in csv.DictReader(line for line in stream if not line.startswith("#")):
            if "benchmark" not in row:
                spheres = int(row["spheres"]) if row["spheres"] else None
                theirs.append((row["question"], row["method"], spheres, float(row["ns"])))
                continue
            question, method = row["benchmark"].split("/")
            spheres, factor = int(row["n"]) if row["n"] else None, NS[row["unit"].split()[0]]
            ours.append((question, f"Stillgrid: {method.replace('_', ' ')}", spheres,
                         float(row["median"]) * factor))
            if row["handbook_figure"]:
                theirs.append((question, row["handbook_note"].split(";")[0], spheres,
                               float(row["handbook_figure"]) * factor))
    return ours, theirs


def in_words(ns):
    for unit, factor in (("s", 1e9), ("ms", 1e6), ("µs", 1e3)):
        if ns >= factor:
            return f"{ns / factor:.3g} {unit}"
    return f"{ns:.3g} ns"


def bars_of(question, ours, theirs):
    """Labelled bars, sets of equal sphere count together, ours first."""
    bars = [(spheres or 0, 0, method, ns, OURS) for q, method, spheres, ns in ours if q == question]
    bars += [(spheres or 0, 1, method, ns, THEIRS)
             for q, method, spheres, ns in theirs if q == question]
    return sorted(bars, key=lambda bar: (bar[0], bar[1], bar[3]))


def draw_panel(axes, question, bars):
    """Returns the height it took, in bars."""
    position, previous = 0.0, None
    ticks, labels = [], []
    for spheres, _, method, ns, colour in bars:
        if spheres != previous:
            position += 0.9 if previous is not None else 0.0
            if spheres:
                axes.text(0.0, position - 0.75, f"N = {spheres:,}", fontsize=8.5,
                          fontweight="bold", transform=axes.get_yaxis_transform(), va="center")
                position += 0.1
            previous = spheres
        axes.barh(position, ns, height=0.78, color=colour)
        axes.text(ns, position, f"  {in_words(ns)}", va="center", fontsize=8)
        ticks.append(position)
        labels.append(method)
        position += 1.0
    axes.set_yticks(ticks, labels, fontsize=8.5)
    axes.set_xscale("log")
    smallest, largest = min(bar[3] for bar in bars), max(bar[3] for bar in bars)
    axes.set_xlim(smallest / 2.5, largest * 3.5)
    axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.set_xlabel("time [ns], logarithmic")
    axes.tick_params(axis="y", length=0)
    axes.set_title(TITLES.get(question, question.replace("_", " ")), loc="left", fontsize=10.5,
                   fontweight="bold")
    return position


def draw(ours, theirs, title):
    questions = list(dict.fromkeys(row[0] for row in ours + theirs))
    panels = [(question, bars_of(question, ours, theirs)) for question in questions]
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9.5})
    columns = min(len(panels), PANELS_A_ROW)
    rows = -(-len(panels) // columns)
    height = 1.6 + 0.25 * max(len(bars) for _, bars in panels)
    figure, grid = plt.subplots(rows, columns, figsize=(5.2 * columns, 0.4 + height * rows),
                                squeeze=False)
    for row in range(rows):
        shown = panels[row * columns:(row + 1) * columns]
        heights = [draw_panel(axes, question, bars)
                   for axes, (question, bars) in zip(grid[row], shown)]
        for axes in grid[row]:  # bars equally thick
            axes.set_ylim(max(heights) - 0.4, -1.2)
        for axes in grid[row][len(shown):]:
            axes.set_visible(False)
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour) for colour in (OURS, THEIRS)]
    figure.tight_layout(rect=(0.0, 0.03, 1.0, 0.97), w_pad=3.0, h_pad=2.0)
    figure.legend(handles, ["Stillgrid, this machine", "handbook, another machine"],
                  loc="lower right", ncol=2, frameon=False)
    figure.suptitle(title, x=0.01, ha="left", fontsize=13, fontweight="bold")
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", metavar="OUT.png")
    parser.add_argument("--benchmark", action="append", default=[], metavar="FILE.json",
                        help="of Google Benchmark; may be repeated")
    parser.add_argument("--rows", action="append", default=[], metavar="FILE.csv",
                        help="may be repeated; default: docs/charts/handbook_figures.csv")
    parser.add_argument("--title", default="Stillgrid beside others")
    arguments = parser.parse_args()
    root = pathlib.Path(__file__).resolve().parents[2]
    files = arguments.rows or [root / "docs" / "charts" / "handbook_figures.csv"]
    try:
        ours = [row for file in arguments.benchmark for row in read_benchmarks(file)]
        theirs = []
        for file in files:
            more_ours, more_theirs = read_rows(file)
            ours += more_ours
            theirs += [row for row in more_theirs if row not in theirs]
        # Without a bar of ours a question has nothing to compare.
        asked = {row[0] for row in ours}
        theirs = [row for row in theirs if not asked or row[0] in asked]
        if not ours + theirs:
            raise ValueError("expected a row at least")
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"plot_benchmark: {type(error).__name__}: {error}")
    figure = draw(ours, theirs, arguments.title)
    figure.savefig(arguments.picture, dpi=120, facecolor="white")


if __name__ == "__main__":
    main()
