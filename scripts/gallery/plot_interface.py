#!/usr/bin/python3
"""Draws docs/charts/interface_energy.png from the table of interface_figures (measure_printed.py)."""
import statistics

from drawing import draw_charts, plt
from tables import read_rows

COLOURS = {"on time": "#0072B2", "late or with jitter": "#D55E00"}
LINEAR_MJ = 1e-3  # below which the axis is linear


def is_late(row):
    return float(row["latency_share"]) > 0.0 or float(row["jitter"]) > 0.0


def draw_transition(axes, place, rows):
    for side, (name, colour) in zip((-0.19, 0.19), COLOURS.items()):
        some = [1e3 * float(row["most_made_in_a_second_J"]) for row in rows
                if is_late(row) == (name != "on time")]
        if not some:
            continue
        width = 0.26 / max(len(some), 1)
        axes.plot([place + side - 0.13 + width * i for i in range(len(some))], sorted(some), ".",
                  color=colour, markersize=3.5, alpha=0.75)
        axes.plot([place + side - 0.15, place + side + 0.15], [statistics.median(some)] * 2,
                  color="0.2", linewidth=1.4)
        axes.annotate(f"{max(some):.2g}", (place + side, max(some)), xytext=(0, 4),
                      textcoords="offset points", ha="center", fontsize=8, color=colour)


def draw(charts):
    rows = read_rows(charts / "interface_energy.csv")
    transitions = list(dict.fromkeys(row["transition"] for row in rows))
    drawn = len({row["seed"] for row in rows})
    touched = {row["seed"] for row in rows if float(row["put_in_J"]) > 0.0}
    rows = [row for row in rows if row["seed"] in touched]
    figure, axes = plt.subplots(figsize=(9.6, 4.6), constrained_layout=True)
    for place, transition in enumerate(transitions):
        draw_transition(axes, place, [row for row in rows if row["transition"] == transition])
    axes.axhline(0.0, color="0.75", linewidth=0.8, zorder=0)
    axes.set_yscale("symlog", linthresh=LINEAR_MJ)
    axes.set_xticks(range(len(transitions)), transitions)
    axes.set_ylabel("most made in a second [mJ]")
    axes.grid(True, axis="y", which="major", color="0.93")
    for name, colour in COLOURS.items():
        axes.plot([], [], ".", color=colour, label=f"snapshots {name}")
    axes.plot([], [], color="0.2", linewidth=1.4, label="median; the number is the largest")
    axes.legend(frameon=False, fontsize=8.5, loc="lower right")
    axes.set_title(f"Energy made by the interface over any second or longer: {len(touched)} of {drawn} drawn "
                   "scenes, which the hand touches", loc="left", fontsize=10.5, fontweight="bold")
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"interface_energy": draw})
