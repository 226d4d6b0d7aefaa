#!/usr/bin/python3
"""Draws docs/charts/query_speed.csv: time of one query against N, a panel a state of the caches."""
import argparse
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker

TITLES = {"query_hot": "The same few spheres again and again", "query_anywhere": "Anywhere in the scene",
          "query_flushed": "Caches flushed before each query"}
METHODS = {"grid": ("Stillgrid", "#0072B2", "o", (0, -15)), "nanoflann": ("nanoflann", "#D55E00", "s", (21, -4)),
           "Bullet_dbvt": ("Bullet, dynamic tree", "#777777", "^", (-6, 8))}


def draw_panel(axes, question, rows):
    for method, (name, colour, marker, offset) in METHODS.items():
        mine = [row for row in rows if (row["question"], row["method"]) == (question, method)]
        n = [int(row["spheres"]) for row in mine]
        median = [float(row["median_ns"]) for row in mine]
        half = [float(row["spread_ns"]) / 2 for row in mine]
        axes.errorbar(n, median, yerr=[[min(bar, 0.9 * y) for bar, y in zip(half, median)], half], color=colour, marker=marker, capsize=3, label=name)
        axes.plot(n, [float(row["handbook_ns"]) for row in mine], color=colour, marker=marker,
                  linestyle=":", alpha=0.45, markerfacecolor="none")
        for x, y in zip(n, median):
            axes.annotate(f"{y:,.0f}", (x, y), textcoords="offset points", xytext=offset, ha="center",
                          fontsize=8, color=colour)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(150, 1800000)
    shown = [float(row[column]) for row in rows if row["question"] == question
             for column in ("median_ns", "handbook_ns")]
    # A run that lost the processor may spread beyond all measure: its bar ends at the frame.
    axes.set_ylim(0.6 * min(shown), 2.0 * max(shown))
    axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.set_xlabel("still spheres N")
    axes.grid(alpha=0.25)
    axes.set_title(TITLES[question], loc="left", fontsize=10.5)


def main():
    root = pathlib.Path(__file__).resolve().parents[2] / "docs" / "charts"
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=pathlib.Path, default=root / "query_speed.csv")
    parser.add_argument("picture", type=pathlib.Path, nargs="?", default=root / "query_speed.png")
    arguments = parser.parse_args()
    try:
        with open(arguments.rows) as stream:
            rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
        plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9.5})
        figure, panels = plt.subplots(1, 3, figsize=(14, 4.8))
        for axes, question in zip(panels, TITLES):
            draw_panel(axes, question, rows)
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"plot_query: {type(error).__name__}: {error}")
    panels[0].set_ylabel("time of one query [ns]")
    handles, labels = panels[0].get_legend_handles_labels()
    handles.append(plt.Line2D([], [], color="black", linestyle=":", alpha=0.45))
    labels.append("handbook, another machine")
    figure.suptitle("The force on one probe among N still spheres", x=0.01, ha="left", fontsize=13,
                    fontweight="bold")
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 0.98), w_pad=2.5)
    figure.legend(handles, labels, loc="lower center", ncol=4, frameon=False)
    figure.savefig(arguments.picture, dpi=110, facecolor="white")


if __name__ == "__main__":
    main()
