#!/usr/bin/python3
"""Draws docs/charts/broyden_iterations.png from the CSV that broyden_figures prints."""
import argparse
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

CHARTS = pathlib.Path(__file__).resolve().parents[2] / "docs/charts"
SOLVERS = (("broyden_mass", "Broyden from the mass", "#D55E00"),
           ("broyden", "Broyden from the Jacobian", "#E69F00"),
           ("kinsol_anderson", "KINSOL, Anderson", "#CC79A7"),
           ("kinsol_newton_krylov", "KINSOL, Newton-Krylov", "#56B4E9"),
           ("newton", "Newton, safeguarded", "#0072B2"))
PANELS = (("chain", "Hanging chain, 40 steps", "mean iterations a step"),
          ("onset", "A contact sets in", "iterations"))


def read_curves(file):
    """scene -> solver -> rows of k h2 / m, iterations, failures"""
    curves = {}
    with open(file) as stream:
        for row in csv.DictReader(line for line in stream if not line.startswith("#")):
            curves.setdefault(row["scene"], {}).setdefault(row["solver"], []).append(
                tuple(float(row[key]) for key in ("k_h2_per_m", "iterations", "failures")))
    return curves


def draw(axes, curves, title, label):
    for solver, name, colour in SOLVERS:
        rows = [row for row in curves[solver] if row[1] > 0]
        axes.plot([row[0] for row in rows], [row[1] for row in rows], color=colour, label=name,
                  linewidth=1.6)
        failed = [row for row in rows if row[2] > 0]
        axes.plot([row[0] for row in failed], [row[1] for row in failed], "x", color=colour,
                  markersize=7, markeredgewidth=1.6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("stiffness k h² / m")
    axes.set_ylabel(label)
    axes.set_title(title, loc="left", fontsize=10.5, fontweight="bold")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(True, which="major", color="0.92")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv", type=pathlib.Path, default=CHARTS / "broyden_iterations.csv")
    parser.add_argument("--png", type=pathlib.Path, default=CHARTS / "broyden_iterations.png")
    arguments = parser.parse_args()
    curves = read_curves(arguments.csv)
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True)
    for axes, (scene, title, label) in zip(panels, PANELS):
        draw(axes, curves[scene], title, label)
    panels[0].plot([], [], "x", color="0.4", label="some or all solves failed")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="upper center", ncol=3,
                  bbox_to_anchor=(0.5, 0.0), frameon=False, fontsize=9)
    figure.savefig(arguments.png, dpi=150, bbox_inches="tight")
    return 0


if __name__ == "__main__":
    sys.exit(main())
