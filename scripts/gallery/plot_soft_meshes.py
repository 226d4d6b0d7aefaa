#!/usr/bin/python3
"""Draws docs/charts/soft_meshes.png from the table that measure_printed.py writes."""
from drawing import draw_charts, plt
from tables import read_rows

METHODS = (("velocity_verlet", "velocity Verlet", "#0072B2"),
           ("implicit_euler, newton_cg", "implicit Euler, newton_cg", "#009E73"),
           ("implicit_euler, newton_bicgstab", "implicit Euler, newton_bicgstab", "#56B4E9"),
           ("implicit_euler, newton", "implicit Euler, newton", "#E69F00"),
           ("implicit_euler, newton_lu", "implicit Euler, newton_lu", "#D55E00"),
           ("cvode_bdf", "CVODE", "#CC79A7"))
PANELS = (("sagging", "Mesh sags on a table, 33 Hz", 1e3 / 33.0),
          ("pressed", "Mesh pressed by a tool, 33 Hz", 1e3 / 33.0),
          ("cloth", "Cloth swings, 100 Hz", 10.0))


def draw_panel(axes, rows, title, period_ms):
    for method, label, colour in METHODS:
        points = sorted((int(row["nodes"]), float(row["median_ms"]), float(row["p90_ms"]))
                        for row in rows if row["method"] == method)
        if points:
            nodes, median, slow = zip(*points)
            axes.plot(nodes, median, "o-", color=colour, label=label, linewidth=1.6, markersize=4)
            axes.vlines(nodes, median, slow, color=colour, linewidth=1.0)
    axes.axhline(period_ms, color="0.6", linestyle="--", linewidth=1.0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    sizes = sorted({int(row["nodes"]) for row in rows})
    axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
    axes.minorticks_off()
    axes.set_xlabel("nodes")
    axes.set_title(title, loc="left", fontsize=10.5, fontweight="bold")
    axes.grid(True, which="major", color="0.92")


def draw(charts):
    rows = read_rows(charts / "soft_meshes.csv")
    figure, panels = plt.subplots(1, 3, figsize=(12, 4.7), sharey=True)
    for axes, (load, title, period_ms) in zip(panels, PANELS):
        draw_panel(axes, [row for row in rows if row["load"] == load], title, period_ms)
    panels[0].set_ylabel("processor time a step [ms]")
    figure.tight_layout(rect=(0, 0.11, 1, 1), w_pad=1.5)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncol=6, frameon=False,
                  fontsize=9)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"soft_meshes": draw})
