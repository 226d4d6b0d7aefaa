#!/usr/bin/python3
"""Draws docs/charts/rates.png from rates.csv, which measure_rates.py writes: the force's error and the simulation's
cost of the scenes that ship, rate by rate, on their own hands."""
from drawing import draw_charts, plt, show_plain_numbers
from tables import read_rows

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
PANELS = (("error_share", 1.0 / 0.07, "error of the force [JND]", 1.0), ("processor_share", 100.0, "of a processor [%]", 25.0))


def draw(charts):
    rows = read_rows(charts / "rates.csv")
    figure, panels = plt.subplots(1, 2, figsize=(10.0, 4.1), constrained_layout=True)
    for axes, (column, factor, label, limit) in zip(panels, PANELS):
        axes.axhline(limit, color="#C00000", linewidth=1.0)
        for colour, scene in zip(COLOURS, dict.fromkeys(row["scene"] for row in rows)):
            points = [(row["role"], float(row["rate_hz"]), factor * float(row[column]))
                      for row in rows if row["scene"] == scene and row[column]]
            curve = [point[1:] for point in points if point[0] != "before"]
            axes.plot(*zip(*curve), color=colour, marker=".", linewidth=1.3, label=scene.replace("_", " "))
            for role, face, size in (("before", "white", 8), ("shipped", colour, 9)):
                marks = [point[1:] for point in points if point[0] == role]
                if marks:
                    axes.plot(*zip(*marks), color=colour, marker="o", markerfacecolor=face, markersize=size,
                              linestyle="none")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("rate [Hz]")
        axes.set_ylabel(label)
        show_plain_numbers(axes.xaxis)
        show_plain_numbers(axes.yaxis)
        axes.grid(True, which="major", color="0.92")
    panels[0].legend(frameon=False, fontsize=9)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"rates": draw})
