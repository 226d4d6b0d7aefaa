#!/usr/bin/python3
"""Draws docs/charts/step_times.png from the table that measure_step_times.py writes."""
from drawing import draw_charts, plt
from tables import read_rows

PERCENTILES = (("p50", "half"), ("p99", "99 %"), ("p999", "99.9 %"), ("max", "all"))
PHASES = (("step", "whole step", "#000000"), ("detect", "find contacts", "#0072B2"),
          ("integrate", "integrate", "#D55E00"), ("publish", "publish", "#009E73"))


def draw_panel(axes, row):
    rate_hz, steps, late = (float(row[key]) for key in ("rate_hz", "steps", "late_steps"))
    period_ms = 1e3 / rate_hz
    places = range(len(PERCENTILES))
    for phase, label, colour in PHASES:
        axes.plot(places, [float(row[f"{phase}_{key}_ms"]) for key, _ in PERCENTILES], "o-",
                  color=colour, label=label, linewidth=1.4, markersize=5)
    axes.axhline(period_ms, color="0.6", linestyle="--", linewidth=1.2)
    axes.text(0.0, period_ms * 1.15, f"period, {period_ms:.0f} ms", color="0.4", fontsize=8.5)
    axes.set_yscale("log")
    axes.set_xticks(list(places), [f"{label}\nof steps" for _, label in PERCENTILES])
    axes.set_xlim(-0.2, len(PERCENTILES) - 0.8)
    axes.set_title(f"{rate_hz:g} Hz, {steps:,.0f} steps: {late:.0f} late ({late / steps:.2%}), "
                   f"stolen {float(row['stolen_share']):.1%}",
                   loc="left", fontsize=10, fontweight="bold")
    axes.grid(True, axis="y", which="major", color="0.92")


def draw(charts):
    rows = read_rows(charts / "step_times.csv")
    figure, panels = plt.subplots(1, len(rows), figsize=(5.4 * len(rows), 3.9), sharey=True,
                                  squeeze=False, constrained_layout=True)
    for axes, row in zip(panels[0], rows):
        draw_panel(axes, row)
    panels[0][0].set_ylabel("time a step is done within [ms]")
    panels[0][-1].legend(frameon=False, fontsize=9, loc="lower right")
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"step_times": draw})
