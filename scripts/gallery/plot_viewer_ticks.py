#!/usr/bin/python3
"""Draws docs/charts/viewer_ticks.png from the table that measure_viewer.py writes."""
import statistics

from drawing import draw_charts, matplotlib, plt
from tables import read_notes, read_rows

BESIDE = {"nothing": ("alone", "#0072B2"), "viewer": ("beside the viewer", "#D55E00"),
          "machine": ("cyclictest", "#888888")}
SHARES = (("p50", "p50"), ("p99", "p99"), ("p999", "p99.9"))


def draw_runs(axes, rows, column, places):
    """A dot a run and a bar for the median, side by side at each place."""
    for i, (beside, (_, colour)) in enumerate(BESIDE.items()):
        for place, name in enumerate(places):
            values = [float(row[column(name)]) for row in rows
                      if row["beside"] == beside and row[column(name)]]
            if not values:
                continue
            x = place + 0.27 * (i - 1)
            spread = [x + 0.07 * ((k % 5) / 2.0 - 1.0) for k in range(len(values))]
            axes.plot(spread, values, "o", color=colour, alpha=0.35, markersize=4, markeredgewidth=0)
            median = statistics.median(values)
            axes.plot([x - 0.1, x + 0.1], [median, median], color=colour, linewidth=2.2)
            text = f"{median:.0f}" if median >= 100.0 else f"{median:.2g}"
            axes.annotate(text, (x, median), textcoords="offset points", xytext=(0, 5),
                          ha="center", fontsize=8, color=colour,
                          bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.6})
    axes.set_xticks(range(len(places)))
    axes.grid(axis="y", color="0.93")


def draw(charts):
    rows = read_rows(charts / "viewer_ticks.csv")
    figure, (work, wake, missed) = plt.subplots(1, 3, figsize=(10.4, 4.4), width_ratios=(3, 3, 1.3))
    names = [name for name, _ in SHARES]
    for axes, quantity, title in ((work, "tick", "a tick's work [µs]"),
                                  (wake, "wake", "how late a tick woke [µs]")):
        draw_runs(axes, rows, lambda name, of=quantity: f"{of}_{name}_us", names)
        axes.set_xticklabels([label for _, label in SHARES])
        axes.set_yscale("log")
        axes.margins(y=0.12)
        axes.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda us, _: f"{us:,.0f}"))
        axes.yaxis.set_minor_locator(matplotlib.ticker.NullLocator())
        axes.set_title(title, fontsize=10, loc="left")
    for row in rows:
        row["missed_percent"] = str(100.0 * float(row["missed_share"]))
    draw_runs(missed, rows, lambda name: name, ["missed_percent"])
    missed.set_xticklabels([""])
    missed.set_xlim(-0.5, 0.5)
    missed.set_ylim(bottom=0.0)
    missed.set_title("deadlines missed [%]", fontsize=10, loc="left")
    handles = [plt.Line2D([], [], color=colour, marker="o", label=label)
               for label, colour in BESIDE.values()]
    figure.legend(handles=handles, loc="upper right", frameon=False, ncols=3, fontsize=9)
    figure.suptitle("The 1 kHz loop with and without the viewer", x=0.02, ha="left", fontsize=13,
                    fontweight="bold")
    figure.text(0.02, 0.015, " ".join(read_notes(charts / "viewer_ticks.csv")[:1]), fontsize=7.5,
                color="0.45")
    figure.tight_layout(rect=(0.0, 0.035, 1.0, 0.97))
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"viewer_ticks": draw})
