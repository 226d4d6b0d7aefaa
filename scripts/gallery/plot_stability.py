#!/usr/bin/python3
"""Draws docs/charts/stability_{map,mass,jitter,linear}.png from stability.csv (measure_stability.py)
and two_rate.csv (measure_printed.py two_rate)."""
import numpy

from drawing import draw_charts, plt
from tables import read_rows

WALL_N_PER_M = {"light": 10084.0, "hand": 14928.0}  # what a rigid wall bears at 1 kHz, exactly
DEVICES = {"light": "light device", "hand": "with the hand"}
LAWS = {"hold": "#0072B2", "linear": "#D55E00", "predict": "#009E73"}
OTHERS = {"restart": "#E69F00", "hermite": "#CC79A7", "extrapolate": "#56B4E9",
          "playout": "#8C564B", "force_held": "black"}
FREE = ("free:0.05", "free:0.1", "free:0.5", "free:1", "free:5")
BODIES = (*FREE, "chain", "block")
PERIODS_S = (0.01, 0.033, 0.1)
COSTS = (0.0, 0.1, 0.333333, 1.0)
COST_NAMES = ("0", "P/10", "P/3", "P")
UNSTABLE_N_PER_M = 50.0  # drawn where the lowest stiffness was unstable
MOST_N_PER_M = 28000.0   # nothing was lost up to here


def read_limits(charts):
    """Limits by scene, device, law, period, cost, jitter, device friction: of eight seeds where they were
    measured, else of the first."""
    limits = {}
    rows = [row for row in read_rows(charts / "stability.csv") if row["seed"] in ("1", "1-8")]
    for row in sorted(rows, key=lambda row: row["seed"]):
        law = row["transition"] if row["model"] == "grid" else row["model"]
        key = (row["scene"], row["device"], law, float(row["period_s"]), float(row["latency_share"]),
               float(row["jitter"]), float(row["device_friction_N"]))
        limits[key] = float(row["limit_N_per_m"] or UNSTABLE_N_PER_M)
    return limits


def limit(limits, scene, device, law, period_s, cost, jitter=0.3, friction_N=0.0):
    return limits.get((scene, device, law, period_s, cost, jitter, friction_N))


def worst(limits, device, law, period_s, cost):
    """The least limit over all bodies but the wall, and whose it is."""
    found = [(limit(limits, body, device, law, period_s, cost), body) for body in BODIES]
    found = [pair for pair in found if pair[0] is not None]
    return min(found) if found else (numpy.nan, "")


def thousands(value):
    return "≥28 k" if value > MOST_N_PER_M else f"{1e-3 * value:.1f} k"


def draw_map(charts):
    limits = read_limits(charts)
    figure, panels = plt.subplots(2, 3, figsize=(10.5, 6.2), constrained_layout=True)
    for row, device in zip(panels, DEVICES):
        for axes, law in zip(row, LAWS):
            cells = [[worst(limits, device, law, p, c) for c in COSTS] for p in PERIODS_S]
            ratio = numpy.array([[cell[0] / WALL_N_PER_M[device] for cell in line] for line in cells])
            # White is the goal, half of what a wall bears.
            image = axes.imshow(numpy.log2(2.0 * ratio), cmap="RdBu", vmin=-4, vmax=4,
                                aspect="auto")
            for i, line in enumerate(cells):
                for j, (value, body) in enumerate(line):
                    if numpy.isnan(value):  # of a small grid
                        continue
                    dark = abs(numpy.log2(2.0 * ratio[i, j])) > 2.6
                    wall = ratio[i, j] >= 0.88
                    axes.text(j, i, f"{thousands(value)}\n{body.replace('free:', '')}"
                              f"{' kg' if 'free' in body else ''}", ha="center", va="center",
                              fontsize=9, color="white" if dark else "black",
                              fontweight="bold" if wall else "normal")
            axes.set_xticks(range(len(COSTS)), COST_NAMES)
            axes.set_yticks(range(len(PERIODS_S)), [f"{1e3 * p:g}" for p in PERIODS_S])
            axes.set_title(f"{law}, {DEVICES[device]}", loc="left", fontsize=10,
                           fontweight="bold")
            axes.set_xlabel("cost of a step")
        row[0].set_ylabel("period P [ms]")
    bar = figure.colorbar(image, ax=panels, shrink=0.75)
    bar.set_ticks([-4, -2, 0, 1, 2, 4], labels=["1/32", "1/8", "1/2: goal", "1: wall", "2", "8"])
    bar.set_label("largest stable stiffness over a rigid wall's at 1 kHz")
    figure.suptitle("Largest stable stiffness [N/m] and the body that sets it; bold: a wall's own", x=0.01, ha="left", fontsize=12,
                    fontweight="bold")
    return figure


def draw_mass(charts):
    limits = read_limits(charts)
    figure, panels = plt.subplots(2, 2, figsize=(10.5, 7.6), sharex=True, sharey=True)
    masses = [float(body.split(":")[1]) for body in FREE]
    for row, device in zip(panels, DEVICES):
        for axes, cost, name in zip(row, (0.1, 1.0), ("a step costs P/10", "late: a step costs P")):
            for law, colour in {**LAWS, **OTHERS}.items():
                values = [limit(limits, body, device, law, 0.033, cost) for body in FREE]
                bold = law in LAWS
                axes.plot(masses, [numpy.nan if v is None else v for v in values],
                          "o-" if bold else ".--", color=colour, linewidth=2 if bold else 1,
                          label=law.replace("_", " "), zorder=3 if bold else 2)
            axes.axhline(WALL_N_PER_M[device], color="0.3", linewidth=1, label="a rigid wall")
            axes.axhline(0.5 * WALL_N_PER_M[device], color="0.3", linewidth=1, linestyle="--",
                         label="half of that: the goal")
            axes.set(xscale="log", yscale="log")
            axes.set_title(f"{DEVICES[device]}, {name}", loc="left", fontsize=10,
                           fontweight="bold")
            axes.grid(True, which="major", color="0.92")
        row[0].set_ylabel("largest stable stiffness [N/m]")
    for axes in panels[1]:
        axes.set_xlabel("mass of a free body [kg]")
        axes.set_xticks(masses, [f"{mass:g}" for mass in masses])
        axes.minorticks_off()
    figure.tight_layout(rect=(0, 0.06, 1, 0.97))
    figure.legend(*panels[0][0].get_legend_handles_labels(), frameon=False, ncol=5,
                  loc="lower center")
    figure.suptitle("Stiffness borne, by the mass of what is touched: P = 33 ms, 30 % jitter, 30 µm encoders",
                    x=0.01, ha="left", fontsize=12, fontweight="bold")
    return figure


def draw_jitter(charts):
    limits = read_limits(charts)
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.6), sharey=True, sharex=True,
                                  constrained_layout=True)
    for axes, device in zip(panels, DEVICES):
        for law, colour in LAWS.items():
            pairs = [(limit(limits, *key[:5], 0.0), value) for key, value in limits.items()
                     if key[1:3] == (device, law) and key[5:] == (0.3, 0.0) and key[0] != "wall"]
            pairs = [pair for pair in pairs if pair[0] is not None]
            if pairs:
                axes.plot(*zip(*pairs), "o", color=colour, alpha=0.6, markersize=5, label=law)
        axes.plot([100, 3e4], [100, 3e4], color="0.5", linewidth=1)
        axes.set(xscale="log", yscale="log", xlabel="regular periods [N/m]")
        axes.set_title(DEVICES[device], loc="left", fontsize=10, fontweight="bold")
        axes.grid(True, which="major", color="0.92")
    panels[0].set_ylabel("periods of 30 % jitter [N/m]")
    panels[0].legend(frameon=False, fontsize=9)
    figure.suptitle("Largest stable stiffness with and without jitter, a point a cell", x=0.01, ha="left",
                    fontsize=12, fontweight="bold")
    return figure


def read_linear(charts):
    return {(row["body"], row["device"], row["law"], float(row["period_ms"]), float(row["cost_share"])):
            float(row["limit_N_per_m"]) for row in read_rows(charts / "two_rate.csv")}


def draw_linear(charts):
    """Where both know the cell: free bodies, regular periods."""
    limits, linear = read_limits(charts), read_linear(charts)
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.8), sharey=True, sharex=True,
                                  constrained_layout=True)
    top = 29e3
    for axes, device in zip(panels, DEVICES):
        for law, colour in LAWS.items():
            for cost, marker in zip(COSTS, "ov^s"):
                pairs = []
                for body in FREE:
                    for period_s in PERIODS_S:
                        measured = limit(limits, body, device, law, period_s, cost, 0.0)
                        exact = linear.get((f"free {body.split(':')[1]} kg", device, law,
                                            1e3 * period_s, round(cost, 3)))
                        if measured is not None and exact is not None:
                            pairs.append((min(exact, top), measured))
                if pairs:
                    axes.plot(*zip(*pairs), marker, color=colour, alpha=0.65, markersize=5)
        axes.plot([200, top], [200, top], color="0.5", linewidth=1)
        axes.set(xscale="log", yscale="log", xlabel="linear analysis, exact encoders [N/m]")
        axes.set_title(DEVICES[device], loc="left", fontsize=10, fontweight="bold")
        axes.grid(True, which="major", color="0.92")
    for law, colour in LAWS.items():
        panels[0].plot([], [], "o", color=colour, label=law)
    for name, marker in zip(COST_NAMES, "ov^s"):
        panels[0].plot([], [], marker, color="0.5", label=f"cost {name}")
    panels[0].legend(frameon=False, fontsize=8)
    panels[0].set_ylabel("product code, 30 µm encoders [N/m]")
    figure.suptitle("Largest stable stiffness of free bodies, regular periods, both ended at 29 kN/m",
                    x=0.01, ha="left", fontsize=12, fontweight="bold")
    return figure


def print_goals(limits):
    """Half of the wall's at up to a tenth of the period; nowhere 15 % under the better of both."""
    print("goal,scene,device,period_s,cost,hold,linear,predict,met")
    for device in DEVICES:
        for period_s in PERIODS_S:
            for cost in COSTS:
                for body in BODIES:
                    hold, linear, predict = (limit(limits, body, device, law, period_s, cost)
                                            for law in LAWS)
                    if None in (hold, linear, predict):
                        continue
                    cell = (f"{body},{device},{period_s:g},{cost:.2g},{hold:.0f},{linear:.0f},"
                            f"{predict:.0f}")
                    if cost <= 0.1:
                        print(f"half,{cell},{'yes' if predict >= 0.5 * WALL_N_PER_M[device] else 'NO'}")
                    print(f"better,{cell},{'yes' if predict >= 0.85 * max(hold, linear) else 'NO'}")


def main():
    charts, prints = draw_charts(__doc__, {"stability_map": draw_map, "stability_mass": draw_mass,
                                           "stability_jitter": draw_jitter, "stability_linear": draw_linear},
                                 dpi=120, flag=("--goals", "print every cell against the goals too"))
    if prints:
        print_goals(read_limits(charts))


if __name__ == "__main__":
    main()
