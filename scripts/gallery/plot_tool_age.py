#!/usr/bin/python3
"""Draws docs/charts/tool_age.png from the table that measure_tool_age.py writes."""
from drawing import draw_charts, plt
from tables import read_rows

COLOURS = ("#D55E00", "#0072B2", "#009E73")


def draw_panel(axes, rows, method, builds):
    rates = sorted({float(row["rate_hz"]) for row in rows if row["method"] == method})
    for number, build in enumerate(builds):
        for row in rows:
            if row["method"] != method or row["build"] != build:
                continue
            place = rates.index(float(row["rate_hz"])) + 0.22 * (number - 0.5 * (len(builds) - 1))
            half, most = float(row["age_p50_ms"]), float(row["age_p99_ms"])
            axes.plot([place, place], [half, most], color=COLOURS[number], linewidth=1.6)
            axes.plot(place, half, "o", color=COLOURS[number], markersize=7)
            axes.plot(place, most, "_", color=COLOURS[number], markersize=11)
            axes.plot(place, float(row["step_p50_ms"]), "x", color="0.45", markersize=6)
    for place, rate_hz in enumerate(rates):
        axes.plot([place - 0.35, place + 0.35], [1e3 / rate_hz] * 2, "--", color="0.6", linewidth=1)
    axes.set_yscale("log")
    axes.set_xticks(range(len(rates)), [f"{rate_hz:g} Hz" for rate_hz in rates])
    axes.set_title(method, loc="left", fontsize=10, fontweight="bold")
    axes.grid(True, axis="y", which="major", color="0.92")


def draw(charts):
    rows = read_rows(charts / "tool_age.csv")
    methods = list(dict.fromkeys(row["method"] for row in rows))
    builds = list(dict.fromkeys(row["build"] for row in rows))
    figure, panels = plt.subplots(1, len(methods), figsize=(4.9 * len(methods), 3.9), sharey=True,
                                  squeeze=False, constrained_layout=True)
    for axes, method in zip(panels[0], methods):
        draw_panel(axes, rows, method, builds)
    panels[0][0].set_ylabel("age of the tool's sample at publication [ms]")
    for number, build in enumerate(builds):
        panels[0][0].plot([], [], "o-", color=COLOURS[number], label=f"{build}: half, 99 %")
    panels[0][0].plot([], [], "x", color="0.45", label="whole step, half")
    panels[0][0].plot([], [], "--", color="0.6", label="period")
    panels[0][-1].legend(*panels[0][0].get_legend_handles_labels(), frameon=False, fontsize=8)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"tool_age": draw})
