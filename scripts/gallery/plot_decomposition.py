#!/usr/bin/python3
"""Draws docs/charts/decomposition_error.png, error and time against spheres, from the table that
measure_decomposition.py writes."""
import numpy as np

from drawing import draw_charts, plt, show_plain_numbers
from tables import read_rows

COLOURS = {"bunny": "#0072B2", "spot": "#D55E00", "liver": "#009E73", "contour": "#CC79A7",
           "torus": "#E69F00"}


def draw_slopes(axes, rows):
    """Pieces of lines that are as steep as theory has it, beside the curves."""
    spheres = np.array([int(row["spheres"]) for row in rows])
    errors = np.array([100 * float(row["hausdorff"]) for row in rows])
    low, high = errors.min() / 1.5, errors.max() * 1.5
    axes.set_xlim(spheres.min() / 2.2, spheres.max() * 4)
    axes.set_ylim(low, high)
    torus = np.array([row["mesh"] == "torus" for row in rows])
    last = np.argmax(np.where(torus, spheres, 0))
    for slope, at, end, name, side in (
            (-2, (0.62 * spheres[last], errors[last]), 3.0, "slope -2:\ntorus, rod", "right"),
            (-1, (1.8 * spheres.max(), errors.min()), 3.0, "slope -1:\nslab", "left")):
        e = at[1] * np.array([1.0, end])
        n = at[0] * np.array([1.0, end]) ** (1.0 / slope)
        axes.plot(n, e, "--", color="#555555", lw=1.2)
        axes.annotate(name, (np.sqrt(n.prod()), np.sqrt(e.prod())), color="#555555", fontsize=9,
                      ha=side, va="center", xytext=(-9 if side == "right" else 9, 0),
                      textcoords="offset points")


def draw_errors(charts):
    rows = read_rows(charts / "decomposition_error.csv")
    figure, (errors, times) = plt.subplots(1, 2, figsize=(11.5, 4.8))
    for name, colour in COLOURS.items():
        own = [row for row in rows if row["mesh"] == name]
        if not own:
            continue
        spheres = [int(row["spheres"]) for row in own]
        errors.loglog(spheres, [100 * float(row["hausdorff"]) for row in own], "o-", color=colour,
                      label=name, lw=1.8, ms=5)
        times.loglog(spheres, [float(row["time_s"]) for row in own], "o-", color=colour, lw=1.8,
                     ms=5)
    draw_slopes(errors, rows)
    errors.set_xlabel("spheres")
    errors.set_ylabel("two-sided Hausdorff distance [% of the box's diagonal]")
    errors.set_title("Error falls with the number of spheres", loc="left", fontweight="bold",
                     fontsize=10.5)
    errors.legend(frameon=False, loc="upper right")
    times.set_xlabel("spheres")
    times.set_ylabel("time [s], one thread")
    for axes in (errors, times):
        show_plain_numbers(axes.xaxis)
        show_plain_numbers(axes.yaxis)
    times.set_title("Time to find them", loc="left", fontweight="bold", fontsize=10.5)
    figure.tight_layout(w_pad=3.0)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"decomposition_error": draw_errors}, dpi=120)
