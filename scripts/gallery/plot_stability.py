#!/usr/bin/python3
"""Draws docs/charts/stability_{period,map}.png from stability.csv, which measure_stability.py writes."""
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
FREE_KG = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)
BODIES = {"wall": "wall", **{f"free:{mass:g}": f"free {mass:g} kg" for mass in FREE_KG},
          "row": "two in a row", "chain": "chain", "spring:0.1": "0.1 kg on a spring",
          "spring": "5 kg on a spring", "pinch": "pinched", "floor": "block on floor",
          "floor:0.5": "0.5 kg on floor", "block": "block on tissue", "soft": "soft block"}
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


def of_bodies(limits, device, law, period_s, cost=0.1, start="inside"):
    """Of bodies that give way, what was measured: limit by body."""
    cells = {body: Cell(body, "1x1", device, "none", start, law, period_s, cost) for body in BODIES}
    return {body: limits[cell] for body, cell in cells.items() if cell in limits and body != "wall"}


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


def columns():
    """Of the map: what varies, as it is named, and the cell's fields."""
    for cost, name in ((0.0, "cost 0"), (0.1, "P/10")):
        yield f"inside\n{name}", ("none", "inside", cost)
        yield f"outside\n{name}", ("none", "outside", cost)
    yield "declared\ninside", ("declared", "inside", 0.1)
    yield "declared\noutside", ("declared", "outside", 0.1)


def draw_map(charts):
    limits, _ = read_limits(charts)
    figure, panels = plt.subplots(1, 2, figsize=(13, 8.4), sharey=True, constrained_layout=True)
    for axes, device in zip(panels, DEVICES):
        shares = numpy.full((len(BODIES), 3 * len(list(columns()))), numpy.nan)
        for i, body in enumerate(BODIES):
            for j, (_, (declared, start, cost)) in enumerate(columns()):
                for k, period_s in enumerate(PERIODS_S):
                    cell = Cell(body, "1x1", device, declared, start, "local", period_s, cost)
                    if cell in limits:
                        shares[i, 3 * j + k] = limits[cell] / WALL_N_PER_M[device]
        # White is the goal, half of what a wall bears.
        image = axes.imshow(numpy.log2(shares / GOAL), cmap="RdBu", vmin=-3, vmax=3, aspect="auto")
        for (i, j), share in numpy.ndenumerate(shares):
            if not numpy.isnan(share):
                axes.text(j, i, f"{share:.2g}", ha="center", va="center", fontsize=6.5,
                          color="white" if abs(numpy.log2(share / GOAL)) > 2 else "black")
        axes.set_xticks([3 * j + 1 for j in range(len(list(columns())))], [name for name, _ in columns()])
        for j in range(1, len(list(columns()))):
            axes.axvline(3 * j - 0.5, color="0.4", linewidth=0.8)
        axes.set_yticks(range(len(BODIES)), BODIES.values())
        axes.set_title(f"{DEVICES[device]}: 10, 33, 100 ms each", loc="left", fontsize=10, fontweight="bold")
    bar = figure.colorbar(image, ax=panels, shrink=0.6)
    bar.set_ticks([-3, -2, -1, 0, 1, 2], labels=["1/16", "1/8", "1/4", "1/2: goal", "1: wall", "2"])
    figure.suptitle("local: largest stable stiffness over a rigid wall's at 1 kHz; the search ends at 20 kN/m",
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
    charts, prints = draw_charts(__doc__, {"stability_period": draw_period, "stability_map": draw_map},
                                 dpi=120, flag=("--goals", "print what share of the cells meets the goal too"))
    if prints:
        print_goals(charts)


if __name__ == "__main__":
    main()
