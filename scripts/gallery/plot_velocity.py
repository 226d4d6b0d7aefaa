#!/usr/bin/python3
"""Draws docs/charts/velocity.png from the table that measure_printed.py writes."""
import math

from drawing import draw_charts, matplotlib, plt
from tables import read_rows

STYLES = {"difference": ("black", "s"), "window": ("#E69F00", "s"), "low-pass": ("#D55E00", "o"),
          "two low-passes": ("#0072B2", "o"), "line fit": ("#009E73", "^"),
          "constant acceleration": ("#CC79A7", "v"), "adaptive end fit": ("#56B4E9", "d"),
          "adaptive best fit": ("0.45", "d")}
DAMPER = "1 ticks late"


def read_candidates(file):
    """(estimator, setting) -> (quantity, of) -> value"""
    candidates = {}
    for row in read_rows(file):
        values = candidates.setdefault((row["estimator"], float(row["setting_ms"])), {})
        values[row["quantity"], row["of"]] = float(row["value"])
    return candidates


def of_motions(values, quantity, timing):
    return [value for (name, of), value in values.items()
            if name == quantity and of.startswith(timing + "/")]


def noise_mm_s(values, timing):
    noises = of_motions(values, "noise_mm_s", timing)
    return math.sqrt(sum(noise * noise for noise in noises) / len(noises))


def lag_ms(values, timing):
    lags = of_motions(values, "lag_ms", timing)
    return sum(lags) / len(lags)


def front(points, better):
    """The points that no other beats in both, by x."""
    kept = [p for p in points
            if not any(q != p and better(q[0], p[0]) and q[1] <= p[1] for q in points)]
    return sorted(kept)


def draw_panel(axes, candidates, place, better):
    """One point a candidate, a line a family, the product as a star, the front in grey."""
    places = {candidate: place(values) for candidate, values in candidates.items()}
    axes.plot(*zip(*front(list(places.values()), better)), color="0.85", linewidth=7, zorder=0,
              solid_capstyle="round")
    for name, (colour, marker) in STYLES.items():
        points = [places[candidate] for candidate in sorted(places) if candidate[0] == name]
        axes.plot(*zip(*points), marker + "-", color=colour, markersize=4.5, linewidth=0.9,
                  label="plain difference" if name == "difference" else name)
    axes.plot(*places["product", 5.0], "*", color="#D55E00", markersize=17, markeredgecolor="black",
              markeredgewidth=0.8, zorder=5, label="ours: low-pass of 5 ms")
    axes.plot(*places["window", 15.0], "s", color="#E69F00", markersize=9, markeredgecolor="black",
              markeredgewidth=1.2, zorder=4, label="15 ms window")
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.set_yticks([0.5, 1, 2, 5, 10, 20])


def draw(charts):
    candidates = read_candidates(charts / "velocity.csv")
    figure, (even, recorded, loop) = plt.subplots(1, 3, figsize=(13.4, 5.2))
    for axes, timing, title in ((even, "even", "Ticks of 1 ms"),
                                (recorded, "recorded", "Stamps and stale rows of a real logger")):
        draw_panel(axes, candidates, lambda values, t=timing: (lag_ms(values, t), noise_mm_s(values, t)),
                   lambda a, b: a <= b)
        axes.set_xlabel("delay [ms]")
        axes.set_xlim(0, 13.5)
        axes.set_title(title, loc="left", fontsize=10.5, fontweight="bold")
    even.set_ylabel("noise [mm/s rms]")
    draw_panel(loop, candidates,
               lambda values: (values["damper_N_s_per_m", DAMPER], noise_mm_s(values, "even")),
               lambda a, b: a >= b)
    loop.set_xlim(85, 10)
    loop.set_xlabel("damper borne, one tick late [N s/m]")
    loop.set_title("In the loop: left is better", loc="left", fontsize=10.5, fontweight="bold")
    handles, labels = even.get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, ncol=10, loc="lower left", bbox_to_anchor=(0.01, 0.0),
                  fontsize=8.5, columnspacing=1.0, handletextpad=0.4)
    figure.suptitle("Velocity from four recorded motions, encoder steps of 30 µm "
                    "(grey: nothing is better in both)", x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0.05, 1, 0.98), w_pad=2.0)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"velocity": draw})
