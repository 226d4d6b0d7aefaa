#!/usr/bin/python3
"""Draws docs/charts/{detection_speed,voxel_ratio}.png from the tables that measure_detection.py writes."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

STYLES = {  # method: label, colour, line and marker
    "ours": ("ours", "#0072B2", "o-"),
    "ours, and shown": ("ours, snapshots shown too", "#56B4E9", "o:"),
    "ours, in a step": ("ours, contacts of a step", "#CC79A7", "o-"),
    "ours, SCALAR": ("ours, no vectors", "#0072B2", "o--"),
    "paper's grid": ("the paper's grid, stamps", "#009E73", "s-"),
    "Bullet axis sweep": ("Bullet, axis sweep", "#888888", "^-"),
    "Bullet tree, margin R/4": ("Bullet, tree with a margin", "#888888", "v-"),
    "Bullet tree": ("Bullet, tree", "#BBBBBB", "v--"),
    "FCL tree": ("FCL, tree", "#D55E00", "d-"),
}
MOTIONS = {"slow": "slow: R/20 a step, straight on", "far": "far: 3 R a step, a full search each"}
DIMENSION = {"volume": 3, "sheet": 2, "thread": 1}


def draw_speed(charts):
    rows = read_rows(charts / "detection_speed.csv")
    figure, panels = plt.subplots(1, 2, figsize=(11, 5.2), sharey=True)
    for axes, (motion, title) in zip(panels, MOTIONS.items()):
        for method, (label, colour, style) in STYLES.items():
            of = [row for row in rows if row["motion"] == motion and row["method"] == method]
            n = [int(row["spheres"]) for row in of]
            ns = [float(row["ns"]) for row in of]
            spread = [0.5 * float(row["iqr_ns"]) for row in of]
            axes.errorbar(n, ns, yerr=spread, fmt=style, color=colour, label=label, markersize=5,
                          capsize=2)
            if method == "ours":
                for x, y in zip(n, ns):
                    axes.annotate(f"{y:.3g}", (x, y), textcoords="offset points", xytext=(0, -13),
                                  ha="center", fontsize=8.5, color=colour)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(title, fontsize=10, loc="left")
        axes.set_xlabel("moving spheres of mixed radii, 0.95 pairs each" if "pairs_each" in rows[0] else
                        "moving spheres, equal, 0.475 pairs each")
        axes.xaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda x, _: f"{x:,.0f}"))
        axes.grid(axis="y", color="0.93")
    panels[0].set_ylim(bottom=min(float(row["ns"]) for row in rows) / 2)
    panels[0].set_ylabel("processor time per sphere and step [ns]")
    panels[0].legend(loc="upper left", frameon=False, fontsize=8.5, ncols=2)
    panels[0].set_ylim(top=40.0 * max(float(row["ns"]) for row in rows
                                      if row["motion"] == "slow"))
    figure.suptitle("All pairs of N moving spheres that overlap", x=0.02, ha="left", fontsize=13,
                    fontweight="bold")
    figure.tight_layout()
    return figure


def column(rows, name):
    return [float(row[name]) for row in rows]


def draw_ratio(charts):
    rows = read_rows(charts / "voxel_ratio.csv")
    figure, panels = plt.subplots(2, 3, figsize=(11, 6.4), sharex=True, sharey="row")
    for i, (shape, dimension) in enumerate(DIMENSION.items()):
        of = [row for row in rows if row["shape"] == shape]
        paper = [row for row in of if row["engine"] == "paper"]
        ours = [row for row in of if row["engine"] == "ours"]
        chosen = next(row for row in of if row["engine"] == "ours automatic")
        time, count = panels[0][i], panels[1][i]
        time.plot(column(paper, "ratio"), column(paper, "ns"), "s-", color="#009E73",
                  label="the paper's grid")
        time.plot(column(ours, "ratio"), column(ours, "ns"), "o-", color="#0072B2", label="ours")
        time.plot(column([chosen], "ratio"), column([chosen], "ns"), "*", color="#D55E00",
                  markersize=14, zorder=5, label="ours, voxel chosen")
        best = min(paper, key=lambda row: float(row["ns"]))
        time.annotate(f"{float(best['ratio']):.3g}", (float(best["ratio"]), float(best["ns"])),
                      textcoords="offset points", xytext=(0, 8), ha="center", fontsize=9,
                      color="#009E73")
        for name, colour, marker in (("entries", "#CC79A7", "o"), ("visits", "#E69F00", "s"),
                                     ("tests", "#0072B2", "^")):
            count.plot(column(paper, "ratio"), column(paper, f"expected_{name}"), "-",
                       color=colour, linewidth=1.0)
            count.plot(column(paper, "ratio"), column(paper, name), marker, color=colour,
                       markersize=4, label=name)
        for axes in (time, count):
            axes.axvline(3.0 / dimension, color="0.7", linestyle=":", zorder=0)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.grid(axis="y", color="0.93")
        time.set_title(f"{shape}: 3/D = {3.0 / dimension:g}", fontsize=10, loc="left")
        count.set_xlabel("voxel / sphere diameter")
        count.set_xticks([0.5, 1, 2, 4], ["0.5", "1", "2", "4"])
        count.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    panels[0][0].set_ylabel("processor time per sphere [ns]")
    panels[1][0].set_ylabel("the paper's grid, per sphere;\nlines: formulas")
    panels[0][2].legend(frameon=False, fontsize=8.5)
    panels[1][2].legend(frameon=False, fontsize=8.5)
    figure.suptitle("Fig. 4 redrawn: what a voxel's size costs, full searches of 4,000 spheres",
                    x=0.02, ha="left", fontsize=13, fontweight="bold")
    figure.tight_layout()
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"detection_speed": draw_speed, "voxel_ratio": draw_ratio})
