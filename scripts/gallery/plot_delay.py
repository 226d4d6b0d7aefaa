#!/usr/bin/python3
"""Draws docs/charts/loop_delay.png from loop_delay.csv, which measure_delay.py writes: the stiffness that a device
bears by whose thread computes its force."""
from drawing import draw_charts, plt
from tables import read_rows

NAMES = {"host": "the host's loop\nreads and writes", "device": "the device's thread\ncalls the host's tick",
         "late": "the host's loop beside\nthe device's thread"}
COLOURS = {"virtual": "#0072B2", "real": "#D55E00"}
DAMPING_N_S_PER_M, TICK_S = 5.0, 1e-3


def draw(charts):
    rows = read_rows(charts / "loop_delay.csv")
    figure, axes = plt.subplots(figsize=(7.2, 3.4), constrained_layout=True)
    for shift, (time, colour) in zip((-0.18, 0.18), COLOURS.items()):
        limits = [float(row["limit_N_per_m"]) for pace in NAMES for row in rows
                  if row["time"] == time and row["pace"] == pace]
        bars = axes.bar([at + shift for at in range(len(limits))], limits, 0.34, color=colour, label=f"{time} time")
        axes.bar_label(bars, [f"{limit:,.0f}" for limit in limits], fontsize=9, padding=5)
    for ticks, text in ((1.0, "2 b / T"), (3.0, "2 b / 3 T")):
        level = 2.0 * DAMPING_N_S_PER_M / TICK_S / ticks
        axes.axhline(level, color="0.6", linewidth=0.8, linestyle="--", zorder=0)
        axes.text(2.52, level, text, fontsize=9, va="center", color="0.4")
    axes.set_xticks(range(len(NAMES)), NAMES.values())
    axes.set_ylabel("largest stable wall [N/m]")
    axes.set_xlim(-0.5, 2.5)
    axes.set_ylim(0.0, 11500.0)
    axes.legend(frameon=False, fontsize=9)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"loop_delay": draw})
