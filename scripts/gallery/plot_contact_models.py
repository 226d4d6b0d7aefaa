#!/usr/bin/python3
"""Draws docs/charts/contact_models.png and contact_drawn.png from the tables that measure_contact_models.py writes."""
from drawing import draw_charts, plt, show_plain_numbers
from tables import read_rows

STYLES = {"spheres": ("#D55E00", "s", "decomposition"), "even spheres": ("#E69F00", "D", "even spheres"),
          "penetration volume": ("#CC79A7", "v", "penetration volume of even spheres"),
          "field": ("#009E73", "^", "distance field")}
# cost, how it is called, by what it is divided
COSTS = (("flushed_ns", "one query, caches flushed [us]", 1e3), ("hot_ns", "one query, hot [ns]", 1.0),
         ("bytes", "memory [kB]", 1e3))
WALLS = (("two meshes", "walls are two meshes"), ("one mesh", "walls are one mesh"))


def draw_models(axes, rows, cost, divisor):
    for model, (colour, marker, _) in STYLES.items():
        points = [(float(row[cost]) / divisor, float(row["best_jnd"])) for row in rows if row["model"] == model]
        if points:
            axes.plot(*zip(*points), color=colour, marker=marker, markersize=4.5, linewidth=1.2)
    for row in rows:
        if row["model"].startswith("chosen"):
            axes.plot(float(row[cost]) / divisor, float(row["best_jnd"]), "*", color="black", markersize=11,
                      markerfacecolor="none", zorder=5)
        if row["model"] == "nearest point":
            axes.axvline(float(row[cost]) / divisor, color="0.6", linestyle=":", linewidth=1.2)
    axes.axhline(1.0, color="0.7", linestyle="--", linewidth=1.0, zorder=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    show_plain_numbers(axes.yaxis)
    if cost == "flushed_ns":
        show_plain_numbers(axes.xaxis)
    else:
        axes.xaxis.set_major_formatter("{x:,g}")
    axes.grid(True, color="0.93")


def models(charts):
    rows = read_rows(charts / "contact_models.csv")
    meshes = list(dict.fromkeys(row["mesh"] for row in rows))
    figure, grid = plt.subplots(len(COSTS), len(meshes), sharey=True, sharex="row", squeeze=False,
                                figsize=(3.4 * len(meshes) + 0.8, 9.6))
    for line, (cost, label, divisor) in zip(grid, COSTS):
        for axes, mesh in zip(line, meshes):
            draw_models(axes, [row for row in rows if row["mesh"] == mesh], cost, divisor)
            axes.set_xlabel(label)
        line[0].set_ylabel("error of the force [JND]")
    for axes, mesh in zip(grid[0], meshes):
        axes.set_title(mesh, loc="left", fontsize=10.5, fontweight="bold")
    handles = [plt.Line2D([], [], color=colour, marker=marker, markersize=4.5) for colour, marker, _ in STYLES.values()]
    handles += [plt.Line2D([], [], color="black", marker="*", markersize=11, markerfacecolor="none", linestyle=""),
                plt.Line2D([], [], color="0.6", linestyle=":")]
    names = [name for _, _, name in STYLES.values()] + ['chosen by contact = "auto", 2 and 1 JND',
                                                         "nearest point of the exact mesh: no error"]
    figure.suptitle("Error of the force against what a query costs, each model coarse to fine", x=0.01, ha="left",
                    fontsize=12, fontweight="bold")
    figure.text(0.01, 0.952, "Box diagonal 200 mm, tool of 4 mm radius pressed 1 mm deep all over; each model as stiff "
                "as errs least", color="0.35", fontsize=9.5)
    figure.tight_layout(rect=(0, 0.075, 1, 0.955))
    figure.legend(handles, names, loc="lower center", ncol=3, frameon=False, fontsize=9)
    return figure


def finest(rows):
    """Of each model the rows of its finest."""
    least = {}
    for row in rows:
        least[row["model"]] = min(float(row["size_mm"]), least.get(row["model"], 1e9))
    return [row for row in rows if float(row["size_mm"]) == least[row["model"]]]


def draw_drawn(axes, rows):
    for model, (colour, _, name) in STYLES.items():
        points = [(float(row["along_mm"]), float(row["normal"])) for row in rows if row["model"] == model]
        mean = sum(y for _, y in points) / len(points)
        axes.plot([x for x, _ in points], [y / mean for _, y in points], color=colour, label=name, linewidth=1.3)
    axes.set_xlabel("along the face [mm]")
    axes.set_ylabel("normal force over its mean")
    axes.set_title("Tool drawn over a flat face", loc="left", fontsize=10.5, fontweight="bold")
    axes.set_ylim(bottom=0.0)
    axes.grid(True, color="0.93")


def norm(row, names):
    return sum(float(row[name]) ** 2 for name in names) ** 0.5


def draw_corner(axes, rows, walls, title):
    torque = ("tx_mm2", "ty_mm2", "tz_mm2")
    exact = [(float(row["depth_mm"]), norm(row, torque)) for row in rows if row["walls"] == "exact"]
    axes.plot(*zip(*exact), color="black", linewidth=3.0, alpha=0.35)
    for model, (colour, _, _) in STYLES.items():
        points = [(float(row["depth_mm"]), norm(row, torque)) for row in finest(rows[len(exact):])
                  if row["walls"] == walls and row["model"] == model]
        axes.plot(*zip(*points), color=colour, linewidth=1.3)
    axes.set_xlabel("depth in both walls [mm]")
    axes.set_ylabel("torque about the rod's middle [N mm for 1 N/mm]")
    axes.set_title(f"Rod in a corner: {title}", loc="left", fontsize=10.5, fontweight="bold")
    axes.set_ylim(0.0, 1.3 * max(y for _, y in exact))
    axes.grid(True, color="0.93")


def drawn(charts):
    figure, panels = plt.subplots(1, 3, figsize=(13.2, 4.6))
    draw_drawn(panels[0], finest(read_rows(charts / "contact_drawn.csv")))
    corner = sorted(read_rows(charts / "contact_corner.csv"), key=lambda row: row["walls"] != "exact")
    for axes, (walls, title) in zip(panels[1:], WALLS):
        draw_corner(axes, corner, walls, title)
    handles = panels[0].get_legend_handles_labels()
    handles[0].append(plt.Line2D([], [], color="black", linewidth=3.0, alpha=0.35))
    handles[1].append("exact: both walls push")
    figure.tight_layout(rect=(0, 0.11, 1, 1), w_pad=2.0)
    figure.legend(*handles, loc="lower center", ncol=6, frameon=False, fontsize=9)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"contact_models": models, "contact_drawn": drawn})
