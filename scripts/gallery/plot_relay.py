#!/usr/bin/python3
"""Draws what measure_relay_*.py wrote into docs/charts: how old what comes over a network is, what it
needs of a link, and what it feels like."""
import numpy

from drawing import draw_charts, matplotlib, plt, show_plain_numbers
from tables import read_rows

BLUE, ORANGE, GREEN, PINK, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "0.55"
WAYS = {"relay": (BLUE, "scene_relay"), "plain best effort": (ORANGE, "Cyclone DDS, best effort"),
        "plain reliable": (GREEN, "Cyclone DDS, reliable")}
LEAST_SHARE = 0.3  # of an error that is drawn, %: less is nothing


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


def times_of(row, key):
    """How many snapshots were sent."""
    of = {"whole_kB_s": "whole", "deltas_kB_s": "delta"}.get(key)
    return f" ({row[f'{of}_snapshots_s']} /s)" if of else ""


def draw_bandwidth(charts):
    rows = read_rows(charts / "relay_bandwidth.csv")
    rows.sort(key=lambda row: float(row["whole_kB_s"]))
    figure, axes = plt.subplots(figsize=(8.4, 0.52 * len(rows) + 1.2), constrained_layout=True)
    bars = (("whole_kB_s", "0.78", "scene, every snapshot whole"), ("deltas_kB_s", BLUE, "scene, as it ships: deltas"),
            ("tool_kB_s", ORANGE, "tool and answers"), ("tool_deadband_kB_s", PINK, "the same, --deadband 0.07"))
    bars = [bar for bar in bars if bar[0] in rows[0]]
    for place, row in enumerate(rows):
        for number, (key, colour, name) in enumerate(bars):
            at = place + 0.2 * (0.5 * (len(bars) - 1) - number)
            value = float(row[key])
            axes.barh(at, value, 0.18, color=colour, label=name if place == 0 else None)
            axes.text(max(value, 5.0) * 1.04, at, f"{value:,.0f}{times_of(row, key)}", va="center", fontsize=7.5,
                      color="0.25")
    axes.set_xscale("log")
    axes.set_xlim(5.0, 2.5 * max(float(row["whole_kB_s"]) for row in rows))
    axes.set_yticks(range(len(rows)), [f"{row['scene']}, {float(row['rate_hz']):.3g} Hz"
                                       + (f", {row['hands']} hands" if row["hands"] != "1" else "") for row in rows])
    axes.set_xlabel("on the link [kB/s]")
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    return figure


def draw_felt(charts):
    """A column a scene and rate: pose, force on one machine and over the link, age."""
    rows = read_rows(charts / "relay_felt.csv")
    columns = list(dict.fromkeys((row["scene"], row["rate_hz"]) for row in rows))
    figure, panels = plt.subplots(3, len(columns), figsize=(3.6 * len(columns), 6.0), sharex="col", sharey="row",
                                  squeeze=False, constrained_layout=True, height_ratios=(2, 3, 2))
    for column, (scene, rate_hz) in enumerate(columns):
        place, force, age = panels[:, column]
        for where, colour in (("one machine", "0.25"), ("relay", BLUE)):
            some = [row for row in rows if (row["scene"], row["rate_hz"], row["where"]) == (scene, rate_hz, where)]
            time_s = numpy.array([float(row["time_s"]) for row in some])
            width = 1.6 if where == "one machine" else 1.0
            force.plot(time_s, [float(row["force_N"]) for row in some], color=colour, linewidth=width,
                       label={"relay": "over the link"}.get(where, where))
            age.plot(time_s, [float(row["age_ms"]) for row in some], color=colour, linewidth=0.7)
            if where == "relay":
                for axis, tint in zip("xyz", (ORANGE, GREEN, PINK)):
                    place.plot(time_s, [float(row[f"{axis}_mm"]) for row in some], color=tint, label=axis,
                               linewidth=1.1)
                faded = numpy.array([row["faded"] == "1" for row in some])
                force.fill_between(time_s, 0, 1, where=faded, transform=force.get_xaxis_transform(), color="#F5D9D0",
                                   linewidth=0, label="faded" if faded.any() else None, zorder=-1)
        place.set_title(f"{scene}, {rate_hz} Hz", loc="left", fontsize=9.5, fontweight="bold")
        age.set_xlabel("time [s]")
        force.legend(frameon=False, fontsize=7.5, loc="upper left")
        for axes in (place, force, age):
            grid_y(axes)
    panels[0][0].set_ylabel("tool [mm]")
    panels[0][0].legend(frameon=False, fontsize=7.5, ncol=3)
    panels[1][0].set_ylabel("force on the hand [N]")
    panels[2][0].set_ylabel("age of the state [ms]")
    panels[2][0].set_ylim(0.0, 130.0)
    return figure


def draw_rates(charts):
    """A panel a scene: the force's error over the rate, a line a delay, the best rate a star where one is best."""
    rows = read_rows(charts / "relay_rates.csv")
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    delays = list(dict.fromkeys(row["delay_ms"] for row in rows))
    far = [delay for delay in delays if delay != "0"]
    colours = {"0": "0.25", **dict(zip(far, plt.cm.viridis(numpy.linspace(0.0, 0.82, max(2, len(far))))))}
    figure, panels = plt.subplots(1, len(scenes), figsize=(3.5 * len(scenes), 3.7), squeeze=False,
                                  constrained_layout=True)
    for axes, scene in zip(panels[0], scenes):
        for delay in delays:
            some = [row for row in rows if row["scene"] == scene and row["delay_ms"] == delay]
            rates = [float(row["rate_hz"]) for row in some]
            shares = [max(LEAST_SHARE, 100 * float(row["rms_N"]) / float(row["force_rms_N"])) for row in some]
            axes.plot(rates, shares, "--s" if delay == "0" else "-o", color=colours[delay], markersize=4, linewidth=1.3,
                      label="no network" if delay == "0" else f"{delay} ms, 1 % lost")
            best = int(numpy.argmin(shares))
            if shares[best] > LEAST_SHARE:
                axes.plot(rates[best], shares[best], "*", color=colours[delay], markersize=11)
        axes.set_xscale("log")
        axes.set_yscale("log")
        show_plain_numbers(axes.yaxis)
        axes.set_xticks([float(rate) for rate in dict.fromkeys(row["rate_hz"] for row in rows)])
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
        axes.tick_params(axis="x", labelsize=8)
        axes.set_title(scene, loc="left", fontsize=10, fontweight="bold")
        axes.set_xlabel("rate of the simulation [Hz]")
        grid_y(axes)
    panels[0][0].set_ylabel("rms error of the force [%]")
    panels[0][0].legend(frameon=False, fontsize=7.5)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"relay_streams": draw_streams, "relay_age": draw_age, "relay_bandwidth": draw_bandwidth,
                          "relay_felt": draw_felt, "relay_rates": draw_rates})
