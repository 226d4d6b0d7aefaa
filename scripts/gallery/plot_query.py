#!/usr/bin/python3
"""Draws docs/charts/query_speed.png from the table that measure_query.py writes: time of one query
against N, a panel a state of the caches."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

TITLES = {"query_hot": "The same few spheres again and again", "query_anywhere": "Anywhere in the scene",
          "query_flushed": "Caches flushed before each query"}
# How it is called, colour, marker, where its numbers stand: off the bar's lower end, beside, off the upper.
METHODS = {"lists": ("Stillgrid, lists of static spheres", "#0072B2", "o", (0, -13), -1),
           "grid": ("Stillgrid, grid of moving spheres", "#009E73", "D", (0, -13), -1),
           "nanoflann": ("nanoflann", "#D55E00", "s", (22, -4), 0),
           "Bullet_dbvt": ("Bullet, dynamic tree", "#777777", "^", (-10, 7), 1)}


def draw_panel(axes, question, rows):
    for method, (name, colour, marker, offset, side) in METHODS.items():
        mine = [row for row in rows if (row["question"], row["method"]) == (question, method)]
        n = [int(row["spheres"]) for row in mine]
        median = [float(row["median_ns"]) for row in mine]
        half = [float(row["spread_ns"]) / 2 for row in mine]
        axes.errorbar(n, median, yerr=[[min(bar, 0.9 * y) for bar, y in zip(half, median)], half], color=colour, marker=marker, capsize=3, label=name)
        axes.plot(n, [float(row["published_ns"]) for row in mine], color=colour, marker=marker,
                  linestyle=":", alpha=0.45, markerfacecolor="none")
        for x, y, bar in zip(n, median, half):
            end = {-1: max(y - bar, 0.7 * y), 0: y, 1: min(y + bar, 1.4 * y)}[side]
            axes.annotate(f"{y:,.0f}", (x, end), textcoords="offset points", xytext=offset, ha="center",
                          fontsize=8.5, color=colour)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(150, 1800000)
    shown = [float(row[column]) for row in rows if row["question"] == question
             for column in ("median_ns", "published_ns")]
    # A run that lost the processor may spread beyond all measure: its bar ends at the frame.
    axes.set_ylim(0.6 * min(shown), 2.0 * max(shown))
    axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.set_xlabel("static spheres N")
    axes.grid(alpha=0.25)
    axes.set_title(TITLES[question], loc="left", fontsize=10.5)


def draw(charts):
    rows = read_rows(charts / "query_speed.csv")
    figure, panels = plt.subplots(1, 3, figsize=(14, 4.8))
    for axes, question in zip(panels, TITLES):
        draw_panel(axes, question, rows)
    panels[0].set_ylabel("time of one query [ns]")
    handles, labels = panels[0].get_legend_handles_labels()
    handles.append(plt.Line2D([], [], color="black", linestyle=":", alpha=0.45))
    labels.append("another machine")
    figure.suptitle("The force on one probe among N static spheres", x=0.01, ha="left", fontsize=13,
                    fontweight="bold")
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 0.98), w_pad=2.5)
    figure.legend(handles, labels, loc="lower center", ncol=5, frameon=False)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"query_speed": draw})
