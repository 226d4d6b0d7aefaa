#!/usr/bin/python3
"""Draws docs/charts/blobs_vs_spheres.png from the table that measure_blobs.py writes."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

STYLES = {"spheres": ("#888888", "s"), "blobs": ("#0072B2", "o")}
# quantity, how it is called, whether logarithmic
PANELS = (("ripple", "force ripple\n(std / mean)", True),
          ("holes", "share of surface\nin holes", False),
          ("stiffness", "effective stiffness\n(material: 1)", True),
          ("error_mm", "surface error [mm]\n(Hausdorff)", True),
          ("ns_median", "one force [ns]", True))


def draw_curve(axes, rows, quantity, model):
    colour, marker = STYLES[model]
    rows = sorted((row for row in rows if row["model"] == model),
                  key=lambda row: float(row["spheres"]))
    x = [float(row["spheres"]) for row in rows]
    y = [float(row[quantity]) for row in rows]
    axes.plot(x, y, marker=marker, color=colour, markersize=5)
    if quantity == "ns_median":
        spread = [[abs(float(row["ns_median"]) - float(row[end])) for row in rows]
                  for end in ("ns_least", "ns_most")]
        axes.errorbar(x, y, yerr=spread, color=colour, capsize=2, linewidth=1.0)


def draw(charts):
    rows = read_rows(charts / "blobs_vs_spheres.csv")
    meshes = list(dict.fromkeys(row["mesh"] for row in rows))
    figure, grid = plt.subplots(len(PANELS), len(meshes), sharex="col", sharey="row",
                                figsize=(2.8 * len(meshes) + 1.0, 10.5), squeeze=False)
    for line, (quantity, label, is_log) in zip(grid, PANELS):
        for axes, mesh in zip(line, meshes):
            for model in STYLES:
                draw_curve(axes, [row for row in rows if row["mesh"] == mesh], quantity, model)
            axes.set_xscale("log")
            if is_log:
                axes.set_yscale("log")
                axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
                axes.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
            counts = sorted({int(float(row["spheres"])) for row in rows if row["mesh"] == mesh})
            axes.set_xticks(counts, [str(count) for count in counts])
            axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
            axes.grid(axis="y", color="0.93")
            if quantity == "stiffness":
                axes.axhline(1.0, color="0.7", linewidth=1.0, zorder=0)
                axes.set_yticks((0.3, 0.5, 1.0, 2.0))
        line[0].set_ylabel(label)
    for axes, mesh in zip(grid[0], meshes):
        axes.set_title(mesh, loc="left", fontsize=10, fontweight="bold")
    for axes in grid[-1]:
        axes.set_xlabel("spheres")
    handles = [plt.Line2D([], [], color=colour, marker=marker) for colour, marker in STYLES.values()]
    figure.legend(handles, ["spheres, contacts summed", "the same number of blobs"], ncol=2,
                  loc="upper right", frameon=False, bbox_to_anchor=(0.99, 0.985))
    figure.suptitle("Blobs beside plain spheres", x=0.01, y=0.985, ha="left", fontsize=12.5,
                    fontweight="bold")
    figure.text(0.01, 0.952, "Box diagonal 200 mm, tool of 4 mm radius pressed 1 mm deep all over",
                color="0.35", fontsize=9.5)
    figure.align_ylabels()
    figure.tight_layout(rect=(0, 0, 1, 0.955))
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"blobs_vs_spheres": draw})
