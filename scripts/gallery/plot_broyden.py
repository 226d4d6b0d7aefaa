#!/usr/bin/python3
"""Draws docs/charts/broyden_iterations.png from the table that measure_printed.py writes."""
from drawing import draw_charts, label_logarithmic, plt
from tables import read_rows

SOLVERS = (("broyden", "Broyden (paper)", "#D55E00"), ("newton", "Newton, safeguarded", "#0072B2"))
PANELS = (("chain", "Hanging chain, 40 steps", "mean iterations a step"),
          ("onset", "A contact sets in", "iterations"))


def read_curves(file):
    """scene -> solver -> rows of k h2 / m, iterations, failures"""
    curves = {}
    for row in read_rows(file):
        curves.setdefault(row["scene"], {}).setdefault(row["solver"], []).append(
            tuple(float(row[key]) for key in ("k_h2_per_m", "iterations", "failures")))
    return curves


def draw_panel(axes, curves, title, label):
    for solver, name, colour in SOLVERS:
        rows = [row for row in curves[solver] if row[1] > 0]
        axes.plot([row[0] for row in rows], [row[1] for row in rows], color=colour, label=name,
                  linewidth=1.6)
        failed = [row for row in rows if row[2] > 0]
        axes.plot([row[0] for row in failed], [row[1] for row in failed], "x", color=colour,
                  markersize=7, markeredgewidth=1.6)
    label_logarithmic(axes, title, "stiffness k h² / m", label)


def draw(charts):
    curves = read_curves(charts / "broyden_iterations.csv")
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.7))
    for axes, (scene, title, label) in zip(panels, PANELS):
        draw_panel(axes, curves[scene], title, label)
    panels[0].plot([], [], "x", color="0.4", label="some or all solves failed")
    figure.tight_layout(rect=(0, 0.11, 1, 1), w_pad=2.5)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncol=3, frameon=False,
                  fontsize=9)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"broyden_iterations": draw})
