#!/usr/bin/python3
"""Draws docs/charts/laparoscopy.png from the tables that measure_laparoscopy.py writes."""
import statistics

import numpy

from drawing import draw_charts, plt
from tables import read_rows

FORCE, FELT, TROCAR, PAPER = "#0072B2", "#D55E00", "#009E73", "#222222"


def arrow(axes, start, way, colour, text, offset):
    end = numpy.add(start, way)
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2})
    axes.annotate(text, end, textcoords="offset points", xytext=offset, color=colour, fontsize=10)


def draw_statics(axes):
    """The rod tilted, the scene's force F across it near the tip, what trocar and hand do about it."""
    shaft = numpy.array([0.35, -1.0]) / numpy.hypot(0.35, 1.0)
    across = numpy.array([-shaft[1], shaft[0]])
    handle, pivot, tip = (at * shaft for at in (0.0, 0.11, 0.25))
    touched = 0.22 * shaft
    axes.plot(*zip(handle, tip), color="0.45", linewidth=7, solid_capstyle="round", zorder=1)
    axes.plot([-0.09, pivot[0] - 0.012], [pivot[1]] * 2, color="#C9A38A", linewidth=9, zorder=0)
    axes.plot([pivot[0] + 0.012, 0.19], [pivot[1]] * 2, color="#C9A38A", linewidth=9, zorder=0)
    axes.add_patch(plt.Circle((0.17, -0.25), 0.085, color="#E8B9B0", zorder=-1))
    axes.plot(*handle, "o", color="black", markersize=9)
    axes.plot(*pivot, "o", color="white", markeredgecolor=TROCAR, markeredgewidth=2, markersize=9)
    axes.annotate("handle", handle, textcoords="offset points", xytext=(-48, 2))
    axes.annotate("trocar", pivot, textcoords="offset points", xytext=(-62, -20), color=TROCAR)
    axes.annotate("organ", (0.155, -0.3))
    arrow(axes, touched, -0.05 * across, FORCE, "F", (-14, -8))
    arrow(axes, pivot, 0.09 * across, TROCAR, "R", (3, 6))
    arrow(axes, handle, 0.05 * across, FELT, "F + R, felt", (4, 6))
    beside = 0.022 * across
    for name, end, out in (("d", pivot, 1.0), ("a", touched, 2.6)):
        from_m, to_m = handle - out * beside, end - out * beside
        axes.annotate("", to_m, from_m, arrowprops={"arrowstyle": "<->", "color": "0.5"})
        axes.annotate(name, 0.6 * from_m + 0.4 * to_m, textcoords="offset points", xytext=(-14, -4),
                      color="0.35")
    axes.set_title("A force across the rod: felt times (d - a) / d", loc="left", fontsize=10.5)
    axes.set_aspect("equal")
    axes.set_xlim(-0.11, 0.26)
    axes.set_ylim(-0.345, 0.075)
    axes.axis("off")


def draw_times(axes, rows):
    shown = [("detection", "offline", "detection,\nno instrument"), ("detection", "stroke", "detection, stroke"),
             ("detection", "circle", "detection, circle"), ("step", "stroke", "whole step, stroke"),
             ("tick", "stroke", "tick of 1 kHz, stroke")]
    for place, (what, mode, _) in enumerate(shown):
        runs = [row for row in rows if (row["what"], row["mode"]) == (what, mode)]
        values = [statistics.median(float(row[f"{p}_ms"]) for row in runs) for p in ("p50", "p99")]
        axes.plot(values, [place] * 2, color=FORCE, linewidth=5, alpha=0.35, solid_capstyle="butt")
        for value, marker, side in zip(values, "o|", (-1, 1)):
            axes.plot(value, place, marker, color=FORCE, markersize=8, markeredgewidth=2)
            axes.annotate(f"{value:.2g}", (value, place), textcoords="offset points", fontsize=8.5,
                          xytext=(-5 * side, 8), ha="left" if side > 0 else "right")
    axes.axvline(1.0, color=PAPER, linestyle="--", linewidth=1.2)
    axes.annotate("paper: detection\nbelow 1 ms", (1.0, -0.45), textcoords="offset points", xytext=(5, 0),
                  fontsize=8.5, va="top")
    axes.axvline(20.0, color="0.6", linestyle=":", linewidth=1.2)
    axes.annotate("period", (20.0, -0.45), textcoords="offset points", xytext=(4, 0), fontsize=8.5,
                  va="top", color="0.4")
    axes.set_xscale("log")
    axes.set_xlim(0.003, 60.0)
    axes.set_yticks(range(len(shown)), [name for *_, name in shown])
    axes.set_ylim(len(shown) - 0.5, -0.7)
    axes.set_xlabel("time [ms]: half of all, 99 % of all; medians of the runs")
    axes.grid(axis="x", alpha=0.25)
    axes.set_title("Time of a step's collision detection, and what else must be in time", loc="left",
                   fontsize=10.5)


def draw_stroke(axes, rows):
    time_s, scene_N, felt_N, torque_N_m = (
        numpy.array([float(row[name]) for row in rows])
        for name in ("time_s", "scene_x_N", "handle_x_N", "torque_y_N_m"))
    axes.axhline(0.0, color="0.8", linewidth=0.8)
    axes.plot(time_s, scene_N, color=FORCE, linewidth=1.4, label="scene on the rod, x [N]")
    axes.plot(time_s, felt_N, color=FELT, linewidth=1.4, label="felt at the handle, x [N]")
    axes.plot(time_s, 10.0 * torque_N_m, color="0.55", linewidth=1.0,
              label="torque about the handle, y [0.1 N m]")
    axes.set_xlabel("time [s]")
    axes.set_ylim(top=1.45 * max(abs(felt_N).max(), abs(10.0 * torque_N_m).max()))
    axes.legend(frameon=False, fontsize=8.5, loc="upper left")
    axes.grid(alpha=0.2)
    axes.set_title("A stroke to and fro over the organ", loc="left", fontsize=10.5)


def draw_lever(axes, rows):
    share = numpy.array([float(row["touched_mm"]) / float(row["distance_mm"]) for row in rows])
    ratio = numpy.array([float(row["hand_across_N"]) / float(row["rod_across_N"]) for row in rows])
    ends = numpy.array([0.0, 1.12 * share.max()])
    axes.axhline(0.0, color="0.8", linewidth=0.8)
    axes.axvline(1.0, color=TROCAR, linewidth=1.0, linestyle=":")
    axes.annotate("trocar", (1.0, 0.75), textcoords="offset points", xytext=(5, 0), color=TROCAR)
    axes.plot(ends, 1.0 - ends, color="0.5", linewidth=1.2, label="1 - a / d")
    axes.plot(share, ratio, "o", color=FELT, markersize=6, label="what the hand's spring holds, the rod at rest")
    axes.set_xlabel("where the rod is touched, a / d")
    axes.set_ylabel("force on the hand over force on the rod")
    axes.legend(frameon=False, fontsize=8.5, loc="lower left")
    axes.grid(alpha=0.2)
    axes.set_title("Beyond the trocar the force is reversed", loc="left", fontsize=10.5)


def draw(charts):
    figure, panels = plt.subplots(2, 2, figsize=(12.5, 8.4), constrained_layout=True)
    draw_statics(panels[0, 0])
    draw_times(panels[0, 1], read_rows(charts / "laparoscopy.csv"))
    draw_stroke(panels[1, 0], read_rows(charts / "laparoscopy_stroke.csv"))
    draw_lever(panels[1, 1], read_rows(charts / "laparoscopy_lever.csv"))
    figure.suptitle("Laparoscopy: a rod through a trocar, 290 spheres that move", x=0.01, ha="left",
                    fontsize=13, fontweight="bold")
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"laparoscopy": draw})
