#!/usr/bin/python3
"""Draws docs/charts/{relay_streams,relay_age}.png from the tables that measure_relay_age.py writes."""
import numpy

from drawing import draw_charts, plt
from tables import read_rows

BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "0.55"
WAYS = {"relay": (BLUE, "scene_relay"), "plain best effort": (ORANGE, "Cyclone DDS, best effort"),
        "plain reliable": (GREEN, "Cyclone DDS, reliable")}
def grid_y(axes):
    axes.grid(True, axis="y", which="major", color="0.92")
    axes.set_axisbelow(True)


def draw_streams(charts):
    """A group a stream, a mark a way: from half over 99 % to the longest."""
    rows = read_rows(charts / "relay_streams.csv")
    figure, (ages, shares) = plt.subplots(1, 2, figsize=(9.6, 3.7), constrained_layout=True, width_ratios=(3, 2))
    streams = list(dict.fromkeys(row["stream"] for row in rows))
    for number, (way, (colour, name)) in enumerate(WAYS.items()):
        for place, stream in enumerate(streams):
            row = next(row for row in rows if row["stream"] == stream and row["way"] == way)
            at = place + 0.22 * (number - 1)
            p50, p99, longest = (float(row[key]) for key in ("p50_ms", "p99_ms", "longest_ms"))
            ages.plot([at, at], [p50, longest], color=colour, linewidth=0.8)
            ages.plot([at, at], [p50, p99], color=colour, linewidth=3.0)
            ages.plot(at, p50, "o", color=colour, markersize=6, label=name if place == 0 else None)
            ages.plot(at, longest, "_", color=colour, markersize=9)
            ages.text(at + 0.05 * (number - 1), longest * 1.09, f"{p99:.3g}", color=colour, ha="center", fontsize=7.5)
            if stream != "tool":
                shares.bar(at, 100 * float(row["over_100_ms"]), 0.2, color=colour)
                shares.text(at + 0.05 * (number - 1), 100 * float(row["over_100_ms"]), f"{100 * float(row['over_100_ms']):.2g}", color=colour,
                            ha="center", va="bottom", fontsize=7.5)
    names = []
    for stream in streams:
        row = next(row for row in rows if row["stream"] == stream)
        what = "1 kHz, 192 B" if stream == "tool" else f"30 Hz, {stream}"
        names.append(f"{what}\n{row['delay_ms']} ms, {100 * float(row['loss']):g} %")
    ages.set_yscale("log")
    ages.axhline(100.0, color=GREY, linewidth=0.8, linestyle="--")
    ages.set_xticks(range(len(streams)), names, fontsize=8)
    ages.set_ylabel("age of the newest [ms]")
    ages.set_title("half, 99 % (number), longest", loc="left", fontsize=9)
    ages.legend(frameon=False, fontsize=8, loc="upper left")
    shown = [place for place, stream in enumerate(streams) if stream != "tool"]
    shares.set_xticks(shown, [names[place] for place in shown], fontsize=8)
    shares.set_ylabel("of the time older than 100 ms [%]")
    grid_y(ages)
    grid_y(shares)
    return figure


def draw_age(charts):
    """A panel a size, a line a loss, over the delay."""
    rows = [row for row in read_rows(charts / "relay_age.csv") if not row["link_Mbit_s"]]
    sizes = list(dict.fromkeys(row["stream"] for row in rows))
    losses = sorted({float(row["loss"]) for row in rows})
    figure, panels = plt.subplots(2, len(sizes), figsize=(3.4 * len(sizes), 5.4), sharex=True, sharey="row",
                                  squeeze=False, constrained_layout=True)
    colours = dict(zip(losses, plt.cm.viridis(numpy.linspace(0.0, 0.82, max(2, len(losses))))))
    for column, size in enumerate(sizes):
        for loss in losses:
            some = sorted((row for row in rows if row["stream"] == size and float(row["loss"]) == loss),
                          key=lambda row: float(row["delay_ms"]))
            delays = [float(row["delay_ms"]) for row in some]
            for key, style in (("p50_ms", ":"), ("p99_ms", "-"), ("longest_ms", "none")):
                panels[0][column].plot(delays, [float(row[key]) for row in some], linestyle=style, color=colours[loss],
                                       marker={"longest_ms": "_"}.get(key, "o"), markersize=4, linewidth=1.3)
            panels[1][column].plot(delays, [100 * float(row["over_100_ms"]) for row in some], "-o", markersize=4,
                                   color=colours[loss], label=f"{100 * loss:g} % lost", linewidth=1.3)
        panels[0][column].plot([0, 50], [33.3 + 0, 33.3 + 50], "--", color=GREY, linewidth=0.9)
        panels[0][column].set_title(size, loc="left", fontsize=10, fontweight="bold")
        panels[1][column].set_xlabel("delay each way [ms]")
        for axes in panels[:, column]:
            grid_y(axes)
    panels[0][0].set_yscale("log")
    panels[0][0].set_yticks([10, 20, 50, 100, 200, 500, 1000], ["10", "20", "50", "100", "200", "500", "1000"])
    panels[0][0].set_ylabel("age of the snapshot [ms]")
    panels[1][0].set_ylabel("of the time older than 100 ms [%]")
    panels[1][0].set_yscale("symlog", linthresh=0.1)
    panels[1][0].set_ylim(0.0, 110.0)
    panels[1][0].set_yticks([0, 0.1, 1, 10, 100], ["0", "0.1", "1", "10", "100"])
    panels[0][0].plot([], [], ":o", color="0.3", markersize=4, label="half")
    panels[0][0].plot([], [], "-o", color="0.3", markersize=4, label="99 %")
    panels[0][0].plot([], [], "_", color="0.3", markersize=6, label="longest")
    panels[0][0].plot([], [], "--", color=GREY, label="delay and a period")
    panels[0][0].legend(frameon=False, fontsize=7.5)
    panels[1][0].legend(frameon=False, fontsize=7.5)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"relay_streams": draw_streams, "relay_age": draw_age})
