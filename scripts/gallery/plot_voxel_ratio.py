#!/usr/bin/python3
"""Draws docs/charts/voxel_ratio.png, Fig. 4 of the paper, from the table that measure_printed.py writes."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

DIMENSION = {"volume": 3, "sheet": 2, "thread": 1}


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
    draw_charts(__doc__, {"voxel_ratio": draw_ratio})
