#!/usr/bin/python3
"""Draws docs/charts/network_*.png from the tables that measure_network.py writes: what a network between simulation
and hand costs."""
from drawing import draw_charts, plt
from tables import read_rows

STYLES = {"predict": ("#0072B2", "-", "o"), "predict_over_delay": ("#009E73", "--", "s"),
          "predict_untold": ("#56B4E9", ":", "v"), "linear": ("#D55E00", "-", "^"), "hold": ("0.45", "-", "D")}
NAMES = {"predict": "predict", "predict_over_delay": "predict, a step longer by half the delay",
         "predict_untold": "predict, the hand told no longer gap", "linear": "linear", "hold": "hold"}
BODIES = {"chain": "a chain, tied", "free:0.1": "0.1 kg, free", "free:1": "1 kg, free"}
LOWEST_N_PER_M = 100.0


def of(rows, **wanted):
    return sorted((row for row in rows if all(row[key] == value for key, value in wanted.items())),
                  key=lambda row: float(row["delay_s"]))


def networks_of(rows):
    return sorted({(float(row["loss"]), int(row["bytes"])) for row in rows})


def at_delays(rows, column, lowest):
    delays_ms = [1e3 * float(row["delay_s"]) for row in rows]
    return delays_ms, [float(row[column]) if row[column] else lowest for row in rows]


def plot_laws(axes, rows, column, lowest, **wanted):
    for law, (colour, line, mark) in STYLES.items():
        if mine := of(rows, law=law, **wanted):
            axes.plot(*at_delays(mine, column, lowest), linestyle=line, marker=mark, markersize=4, color=colour,
                      label=NAMES[law])


def plot_networks(axes, rows, column, lowest, **wanted):
    """Of predict alone; without a delay all are alike."""
    first = of(rows, law="predict", delay_s="0", **wanted)[:1]
    for number, (loss, size) in enumerate(networks_of(rows)):
        mine = of(rows, law="predict", loss=str(loss), bytes=str(size), **wanted)
        if mine and mine[0]["delay_s"] != "0":
            mine = first + mine
        axes.plot(*at_delays(mine, column, lowest), "o-", markersize=4, color=plt.cm.viridis(number / 4.5),
                  label=f"{100 * loss:g} %, {size // 1000} kB")


def finish(axes, title):
    axes.set_title(title, loc="left", fontsize=9.5)
    axes.set_xscale("symlog", linthresh=2.0, linscale=0.5)
    axes.set_xticks([0, 2, 5, 10, 20, 50, 100], ["0", "2", "5", "10", "20", "50", "100"])
    axes.minorticks_off()
    axes.grid(True, axis="y", color="0.92")


def panels_of(rows, scenes, column, lowest, label):
    figure, panels = plt.subplots(2, len(scenes), figsize=(10.5, 6.2), sharex=True, sharey=True,
                                  constrained_layout=True, squeeze=False)
    for (scene, name), above, below in zip(scenes.items(), *panels):
        plot_laws(above, rows, column, lowest, scene=scene, loss="0.01", bytes="1000")
        plot_networks(below, rows, column, lowest, scene=scene)
        for axes in (above, below):
            axes.set_yscale("log")
        finish(above, f"{name}: laws at 1 %, 1 kB")
        finish(below, f"{name}: predict by loss and size")
        below.set_xlabel("delay, one way [ms]")
    for axes in panels[:, 0]:
        axes.set_ylabel(label)
        axes.legend(frameon=False, fontsize=7)
    return figure


def draw_stability(charts):
    rows = read_rows(charts / "network_stability.csv")
    scenes = {scene: name for scene, name in BODIES.items() if of(rows, scene=scene)}
    return panels_of(rows, scenes, "limit_N_per_m", 0.8 * LOWEST_N_PER_M, "largest stable stiffness [N/m]")


def draw_error(charts):
    rows = read_rows(charts / "network_error.csv")
    scenes = {row["scene"]: row["scene"] for row in rows}
    for row in rows:
        row["rms_N"] = max(1e-4, float(row["rms_N"]))
    return panels_of(rows, scenes, "rms_N", 1e-4, "rms error of the force [N]")


def draw_deadband(charts):
    rows = [row for row in read_rows(charts / "network_deadband.csv") if float(row["deadband"]) > 0.0]
    every = {row["hand"]: float(row["rms_N"]) for row in read_rows(charts / "network_deadband.csv")
             if float(row["deadband"]) == 0.0}
    hands, bands = list(every), sorted({float(row["deadband"]) for row in rows})
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.2, 3.4), sharey=True, constrained_layout=True)
    for number, band in enumerate(bands):
        mine = {row["hand"]: row for row in rows if float(row["deadband"]) == band}
        places = [at + 0.26 * (number - 0.5 * (len(bands) - 1)) for at in range(len(hands))]
        colour = plt.cm.viridis(0.15 + 0.3 * number)
        left.barh(places, [100 * float(mine[hand]["sent_share"]) for hand in hands], 0.24, color=colour,
                  label=f"deadband of {100 * band:g} %")
        right.plot([1e3 * (float(mine[hand]["rms_N"]) - every[hand]) for hand in hands], places, "o", color=colour)
    left.set_yticks(range(len(hands)), hands)
    left.invert_yaxis()
    left.set_xlabel("tool samples sent [%]")
    left.legend(frameon=False, fontsize=8)
    right.axvline(0.0, color="0.6", linewidth=0.8)
    right.set_xlabel("rms error of the force that it adds [mN]")
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"network_stability": draw_stability, "network_error": draw_error,
                          "network_deadband": draw_deadband})
