#!/usr/bin/python3
"""Draws docs/charts/rights.png from the table that measure_rights.py writes."""
import statistics

from drawing import draw_charts, plt
from tables import read_rows

WAYS = {"fifo": "SCHED_FIFO 80", "rtkit": "RealtimeKit 20", "other": "none"}
COLOURS = {"quiet": "#0072B2", "loaded": "#D55E00"}
LABELS = {"quiet": "without stress-ng", "loaded": "beside stress-ng"}


def draw(charts):
    rows = read_rows(charts / "rights.csv")
    figure, panels = plt.subplots(1, 2, figsize=(9.2, 3.6), constrained_layout=True)
    for axes, title, value in ((panels[0], "ticks missed [%]",
                                lambda row: 100 * float(row["missed_ticks"]) / float(row["ticks"])),
                               (panels[1], "woken late, 99 % [us]", lambda row: float(row["wake_p99_us"]))):
        for shift, (load, colour) in zip((-0.12, 0.12), COLOURS.items()):
            for place, way in enumerate(WAYS):
                values = [value(row) for row in rows if row["load"] == load and row["way"] == way]
                axes.plot([place + shift] * len(values), values, "o", color=colour, alpha=0.45, markersize=4)
                axes.plot(place + shift, statistics.median(values), "_", color=colour, markersize=18,
                          markeredgewidth=2, label=LABELS[load] if place == 0 else None)
        axes.set_xticks(range(len(WAYS)), WAYS.values())
        axes.set_xlim(-0.5, len(WAYS) - 0.5)
        axes.set_title(title, loc="left", fontsize=10, fontweight="bold")
        axes.grid(True, axis="y", color="0.92")
    panels[0].set_yscale("symlog", linthresh=0.01)
    panels[0].set_ylim(bottom=0)
    panels[1].set_yscale("log")
    panels[0].legend(frameon=False, title="bar: median")
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"rights": draw})
