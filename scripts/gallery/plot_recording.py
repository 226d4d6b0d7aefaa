#!/usr/bin/python3
"""Draws a recording of haptic_server: path of the tool, force, transition, age of the snapshot.

The left column shows the whole run; the right one a window of it, in which the switches from
snapshot to snapshot can be told apart.
"""
import argparse
import pathlib
import sys

import numpy

from drawing import plt, save
from recording import load

# Okabe and Ito's, which the colour-blind can tell apart.
X_COLOUR, Y_COLOUR, Z_COLOUR = "#E69F00", "#009E73", "#0072B2"
NORM_COLOUR, ALPHA_COLOUR, AGE_COLOUR = "#222222", "#CC79A7", "#D55E00"
FADED_COLOUR, WINDOW_COLOUR, SWITCH_COLOUR = "#F5D9D0", "#EEF3F7", "#9AA7B1"


def find_window(recording, length_s):
    """Start and end of a window that shows contact: from just before the strongest force's onset."""
    time_s, force_N = recording["time_s"], recording.force_norm_N()
    last_s = max(time_s[-1] - length_s, time_s[0])
    if force_N.max() == 0.0:
        return time_s[0], time_s[0] + length_s
    peak = int(force_N.argmax())
    free = numpy.flatnonzero(recording["contacts"][:peak] == 0)
    onset_s = time_s[free[-1]] if len(free) else time_s[0]
    start_s = min(max(onset_s - 0.15 * length_s, time_s[0]), last_s)
    return start_s, start_s + length_s


def legend_above(axes):
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=6, frameon=False,
                fontsize=8.5, handlelength=1.3, columnspacing=1.1, borderaxespad=0.1)


def draw_path(axes, recording):
    time_s = recording["time_s"]
    for axis, colour in (("x", X_COLOUR), ("y", Y_COLOUR), ("z", Z_COLOUR)):
        axes.plot(time_s, 1e3 * recording[f"{axis}_m"], color=colour, label=axis,
                  linewidth=1.8 if axis == "z" else 1.1)
    axes.set_ylabel("tool position [mm]")


def draw_force(axes, recording):
    time_s = recording["time_s"]
    axes.axhline(0.0, color="#CCCCCC", linewidth=0.8, zorder=0)
    for axis, colour in (("x", X_COLOUR), ("y", Y_COLOUR), ("z", Z_COLOUR)):
        axes.plot(time_s, recording[f"f{axis}_N"], color=colour, label=axis,
                  linewidth=1.2 if axis == "z" else 0.7)
    axes.plot(time_s, recording.force_norm_N(), color=NORM_COLOUR, linewidth=1.8, label="norm",
              zorder=1.9)  # behind the component that makes most of it
    axes.set_ylabel("force on the hand [N]")
    shade_faded(axes, recording)


def shade_faded(axes, recording):
    """Where the safety chain faded the force, a band behind it."""
    faded = numpy.array(["faded" in flags for flags in recording["flags"]])
    edges = numpy.flatnonzero(numpy.diff(numpy.concatenate(([False], faded, [False])).astype(int)))
    time_s, label = recording["time_s"], "faded"
    for first, after in zip(edges[::2], edges[1::2]):
        axes.axvspan(time_s[first], time_s[after - 1], color=FADED_COLOUR, linewidth=0, zorder=-1,
                     label=label)
        label = None


def draw_age(axes, recording):
    axes.plot(recording["time_s"], 1e3 * recording["age_s"], color=AGE_COLOUR, linewidth=0.9,
              label="age")
    axes.set_ylabel("age of the snapshot [ms]")
    axes.set_ylim(bottom=0.0)


def draw_alpha(axes, recording):
    axes.plot(recording["time_s"], recording["alpha"], color=ALPHA_COLOUR, linewidth=1.4,
              label="alpha")
    axes.set_ylabel("transition α [1]")
    axes.set_ylim(-0.05, 1.05)


def mark_switches(axes, recording, window):
    time_s = recording["time_s"]
    switches = numpy.flatnonzero(numpy.diff(recording["snapshot_id"]) != 0) + 1
    label = "switch of snapshots"
    for switch in switches:
        if window[0] <= time_s[switch] <= window[1]:
            axes.axvline(time_s[switch], color=SWITCH_COLOUR, linewidth=0.7, zorder=0, label=label)
            label = None


def fit_height(axes, window):
    """Scales the vertical axis to what the window shows."""
    shown = []
    for line in axes.get_lines():
        if line.get_label().startswith("_") or line.get_label() == "switch of snapshots":
            continue
        time_s, values = line.get_data()
        shown.append(values[(time_s >= window[0]) & (time_s <= window[1])])
    low, high = (f(numpy.concatenate(shown)) for f in (numpy.min, numpy.max))
    margin = 0.06 * max(high - low, 1e-3)
    axes.set_ylim(low - margin, high + margin)


def draw(recording, title, window_s):
    plt.rcParams.update({"font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False,
                         "axes.titleweight": "bold", "axes.linewidth": 0.8})
    figure, grid = plt.subplots(3, 2, figsize=(12.0, 7.6), sharex="col",
                                gridspec_kw={"width_ratios": (3, 2), "height_ratios": (1, 1.25, 0.8),
                                             "hspace": 0.24, "wspace": 0.17, "left": 0.06,
                                             "right": 0.985, "bottom": 0.075, "top": 0.885})
    window = find_window(recording, window_s)
    whole, zoomed = grid[:, 0], grid[:, 1]

    for axes, draw_panel in zip(whole, (draw_path, draw_force, draw_age)):
        draw_panel(axes, recording)
        axes.axvspan(*window, color=WINDOW_COLOUR, linewidth=0, zorder=-2)
    for axes, draw_panel in zip(zoomed, (draw_path, draw_force, draw_alpha)):
        draw_panel(axes, recording)
        mark_switches(axes, recording, window)
        axes.set_facecolor(WINDOW_COLOUR)
        if draw_panel is not draw_alpha:
            fit_height(axes, window)
    for axes in (whole[0], whole[1], zoomed[2]):
        legend_above(axes)

    whole[0].set_title("Whole run", loc="left", fontsize=10.5)
    zoomed[0].set_title(f"{window_s:g} s of it: contact begins", loc="left", fontsize=10.5)
    time_s = recording["time_s"]
    whole[-1].set_xlim(time_s[0], time_s[-1])
    zoomed[-1].set_xlim(*window)
    for axes in (whole[-1], zoomed[-1]):
        axes.set_xlabel("time [s]")
    figure.align_ylabels()
    figure.suptitle(title, x=0.01, y=0.985, ha="left", fontsize=13, fontweight="bold")
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", metavar="RECORDING.csv")
    parser.add_argument("picture", metavar="OUT.png")
    parser.add_argument("--title", help="default: scene and device of the recording")
    parser.add_argument("--window", type=float, default=0.5, metavar="S",
                        help="length of the right column, s; default 0.5")
    arguments = parser.parse_args()
    try:
        recording = load(arguments.recording)
    except (OSError, ValueError) as error:
        sys.exit(f"plot_recording: {error}")
    known = [recording.metadata[key] for key in ("scene", "device") if key in recording.metadata]
    figure = draw(recording, arguments.title or ", ".join(known), arguments.window)
    save(figure, pathlib.Path(arguments.picture), dpi=120)


if __name__ == "__main__":
    main()
