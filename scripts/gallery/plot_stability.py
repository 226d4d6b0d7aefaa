#!/usr/bin/python3
"""Draws docs/charts/stability_period.png from stability.csv, which measure_stability.py writes."""
import collections
import statistics

import numpy

from drawing import draw_charts, plt
from tables import read_rows

WALL_N_PER_M = {"light": 10084.9, "hand": 14928.6}  # what a rigid wall bears at 1 kHz, exactly
DEVICES = {"light": "light device", "hand": "with the hand"}
# A law, as the charts name it, and its colour.
LAWS = {"local": ("local (default)", "#009E73"), "linear": ("linear (the paper)", "#D55E00"),
        "hold": ("hold", "#0072B2"), "force_held": ("force held (CHAI3D)", "black")}
PERIODS_S = (0.01, 0.033, 0.1)
GOAL = 0.5  # of a wall
Cell = collections.namedtuple("Cell", "scene tool device limits start law period_s cost")


def read_limits(charts):
    """Limits by cell, N/m, and those by other seeds. Where the lowest stiffness was lost: that one."""
    limits, others = {}, {}
    for row in read_rows(charts / "stability.csv"):
        law = row["transition"] if row["model"] == "grid" else row["model"]
        cell = Cell(row["scene"], row["tool"], row["device"], row["limits"], row["from"], law,
                    float(row["period_s"]), float(row["latency_share"]))
        lowest = float(row["lowest_N_per_m"])
        limits[cell] = float(row["limit_N_per_m"] or lowest)
        others[cell] = float(row["other_seeds_N_per_m"] or 0.7 * limits[cell])
    return limits, others


def of_bodies(limits, device, law, period_s):
    """Of bodies that give way, what was measured: limit by body."""
    return {cell.scene: limit for cell, limit in limits.items() if cell.scene != "wall"
            and cell == Cell(cell.scene, "1x1", device, "none", "inside", law, period_s, 0.1)}


def compared(limits, device, period_s):
    """By law, the limits of those bodies that were measured by every law."""
    found = {law: of_bodies(limits, device, law, period_s) for law in LAWS}
    found = {law: bodies for law, bodies in found.items() if bodies}  # of a small grid
    common = set.intersection(*map(set, found.values())) if found else set()
    return {law: [bodies[body] for body in common] for law, bodies in found.items() if common}


def draw_period(charts):
    limits, _ = read_limits(charts)
    figure, panels = plt.subplots(2, 2, figsize=(10, 7.6), sharex=True, sharey=True)
    rows = (("the body that bears least", min), ("the median body", statistics.median))
    for row, (name, choose) in zip(panels, rows):
        for axes, device in zip(row, DEVICES):
            for law, (label, colour) in LAWS.items():
                found = [compared(limits, device, period_s).get(law) for period_s in PERIODS_S]
                if not any(found):
                    continue
                axes.plot([1e3 * p for p in PERIODS_S], [choose(f) if f else numpy.nan for f in found],
                          "o-", color=colour, linewidth=2.2 if law == "local" else 1.5, label=label)
            axes.axhline(WALL_N_PER_M[device], color="0.3", linewidth=1, label="a rigid wall at 1 kHz")
            axes.axhline(GOAL * WALL_N_PER_M[device], color="0.3", linewidth=1, linestyle="--",
                         label="half of that")
            axes.set(xscale="log", yscale="log")
            axes.set_xticks([1e3 * p for p in PERIODS_S], [f"{1e3 * p:g}" for p in PERIODS_S])
            axes.minorticks_off()
            axes.grid(True, color="0.92")
            axes.set_title(f"{DEVICES[device]}, {name}", loc="left", fontsize=10, fontweight="bold")
        row[0].set_ylabel("stiffness borne [N/m]")
    for axes in panels[1]:
        axes.set_xlabel("period of snapshots [ms]")
    figure.tight_layout(rect=(0, 0.07, 1, 0.96))
    figure.legend(*panels[0][0].get_legend_handles_labels(), frameon=False, ncol=4, loc="lower center")
    figure.suptitle("Stiffness borne against the period of snapshots: a step costs P/10, 30 % jitter, 30 µm encoders",
                    x=0.01, ha="left", fontsize=12, fontweight="bold")
    return figure


def print_goals(charts):
    """By law, device limits, start and cost: how many cells bear half a wall, the same of those cells that were
    measured with linear too, the worst of all, and how many change by less than 15 % with other seeds."""
    limits, others = read_limits(charts)
    groups = collections.defaultdict(list)
    for cell, limit in limits.items():
        if cell.scene != "wall":
            groups[cell.law, cell.limits, cell.start, round(cell.cost, 2), cell.tool].append(cell)
    print("law,limits,from,cost,tool,cells,half_a_wall,beside_linear,half_a_wall_there,worst_share,worst_cell,same_within_15_percent")
    share = {cell: limits[cell] / WALL_N_PER_M[cell.device] for cell in limits if cell.device in WALL_N_PER_M}
    for group, cells in sorted(groups.items()):
        cells = [cell for cell in cells if cell in share]
        if not cells:
            continue
        worst = min(cells, key=share.get)
        same = sum(abs(others[cell] / limits[cell] - 1.0) < 0.15 for cell in cells)
        beside = [cell for cell in cells if cell._replace(law="linear") in limits]
        print(*group, len(cells), sum(share[cell] >= GOAL for cell in cells), len(beside),
              sum(share[cell] >= GOAL for cell in beside), f"{share[worst]:.3f}",
              f"{worst.scene} {worst.device} {1e3 * worst.period_s:g} ms {limits[worst]:.0f} N/m", same, sep=",")


def main():
    charts, prints = draw_charts(__doc__, {"stability_period": draw_period}, dpi=120, flag=("--goals", "print what share of the cells meets the goal too"))
    if prints:
        print_goals(charts)


if __name__ == "__main__":
    main()
