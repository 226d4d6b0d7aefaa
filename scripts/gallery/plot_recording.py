#!/usr/bin/python3
"""Draws a recording of haptic_server: path of the tool, force, transition, age of the snapshot.

The left column shows the whole run; the right one a window of it, in which the switches from
snapshot to snapshot can be told apart. Drawn by gnuplot, which the demo can have in a few seconds.
"""
import argparse
import os
import pathlib
import subprocess
import sys

import numpy

from recording import load

# Okabe and Ito's, which the colour-blind can tell apart.
X_COLOUR, Y_COLOUR, Z_COLOUR = "#E69F00", "#009E73", "#0072B2"
NORM_COLOUR, ALPHA_COLOUR, AGE_COLOUR = "#222222", "#CC79A7", "#D55E00"
FADED_COLOUR, WINDOW_COLOUR, SWITCH_COLOUR = "#F5D9D0", "#EEF3F7", "#9AA7B1"
# Columns of the table that gnuplot gets.
COLUMNS = ("time_s", "x_m", "y_m", "z_m", "fx_N", "fy_N", "fz_N", "norm_N", "alpha", "age_s")
WIDTH, HEIGHT = 1440, 912
LEFT, RIGHT = (0.07, 0.585), (0.665, 0.985)  # the two columns, as shares of the width
ROWS = ((0.69, 0.885), (0.375, 0.61), (0.08, 0.28))  # of the height, from below


class Panel:
    """A panel's lines: (label, column, factor, colour, width), drawn in this order."""

    def __init__(self, title, unit_label, lines, low=None, high=None):
        self.title, self.unit_label, self.lines = title, unit_label, lines
        self.low, self.high = low, high


PATH = Panel("path", "tool position [mm]",
             [("x", "x_m", 1e3, X_COLOUR, 1.3), ("y", "y_m", 1e3, Y_COLOUR, 1.3), ("z", "z_m", 1e3, Z_COLOUR, 2.2)])
FORCE = Panel("force", "force on the hand [N]",
              [("norm", "norm_N", 1.0, NORM_COLOUR, 2.2),  # behind the component that makes most of it
               ("x", "fx_N", 1.0, X_COLOUR, 0.9), ("y", "fy_N", 1.0, Y_COLOUR, 0.9), ("z", "fz_N", 1.0, Z_COLOUR, 1.5)])
AGE = Panel("age", "age of the snapshot [ms]", [("age", "age_s", 1e3, AGE_COLOUR, 1.1)], low=0.0)
ALPHA = Panel("alpha", "transition α [1]", [("alpha", "alpha", 1.0, ALPHA_COLOUR, 1.7)], low=-0.05, high=1.05)


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


def faded_spans(recording):
    """Start and end of each time that the safety chain faded the force, s."""
    faded = numpy.array(["faded" in flags for flags in recording["flags"]])
    edges = numpy.flatnonzero(numpy.diff(numpy.concatenate(([False], faded, [False])).astype(int)))
    return [(recording["time_s"][first], recording["time_s"][after - 1])
            for first, after in zip(edges[::2], edges[1::2])]


def switches_s(recording, window):
    """When a new snapshot was displayed, within the window."""
    time_s = recording["time_s"][1:][numpy.diff(recording["snapshot_id"]) != 0]
    return time_s[(time_s >= window[0]) & (time_s <= window[1])]


def limits(panel, table, span):
    """Of the vertical axis: what the span shows, with a margin, or what the panel asks for."""
    shown = table[(table[:, 0] >= span[0]) & (table[:, 0] <= span[1])]
    values = numpy.concatenate([factor * shown[:, COLUMNS.index(column)] for _, column, factor, _, _ in panel.lines])
    low, high = numpy.nanmin(values), numpy.nanmax(values)
    margin = 0.06 * max(high - low, 1e-3)
    return (low - margin if panel.low is None else panel.low), (high + margin if panel.high is None else panel.high)


def panel_commands(panel, place, span, low_high, marks, faded):
    """gnuplot's lines for a panel. marks: vertical lines, (times, label); faded: spans, told in the legend."""
    (left, right), (low, high) = place
    times, label = marks
    yield f"set lmargin at screen {left}; set rmargin at screen {right}"
    yield f"set bmargin at screen {low}; set tmargin at screen {high}"
    yield f"set xrange [{span[0]:.9g}:{span[1]:.9g}]; set yrange [{low_high[0]:.9g}:{low_high[1]:.9g}]"
    yield f'set ylabel "{panel.unit_label}"'
    yield "unset arrow"
    for time_s in times:
        yield (f'set arrow from first {time_s:.9g}, graph 0 to first {time_s:.9g}, graph 1 nohead back '
               f'lc rgb "{SWITCH_COLOUR}" lw 0.8')
    plots = [f'$table using 1:({factor:g} * ${COLUMNS.index(column) + 1}) with lines lc rgb "{colour}" lw {width} '
             f'title "{name}"' for name, column, factor, colour, width in panel.lines]
    if label:
        plots.append(f'NaN with lines lc rgb "{SWITCH_COLOUR}" lw 0.8 title "{label}"')
    if faded:
        plots.append(f'NaN with boxes fillstyle solid lc rgb "{FADED_COLOUR}" title "faded"')
    yield "plot " + ", ".join(plots)


def rectangle(span, colour):
    return (f'set object rectangle from first {span[0]:.9g}, graph 0 to first {span[1]:.9g}, graph 1 behind '
            f'fillcolor rgb "{colour}" fillstyle solid noborder')


def commands(recording, title, window_s):
    """What gnuplot is told, line by line; its last argument is the picture."""
    columns = dict(recording.columns, norm_N=recording.force_norm_N())
    table = numpy.stack([columns[name] for name in COLUMNS], axis=1)
    window, whole = find_window(recording, window_s), (table[0, 0], table[-1, 0])
    yield "$table << END"
    yield from (" ".join(f"{value:.9g}" for value in row) for row in table)
    yield "END"
    yield f'set terminal pngcairo size {WIDTH}, {HEIGHT} font "DejaVu Sans,12" background "white"'
    yield "set output ARG1; set encoding utf8; set border 3; set tics nomirror out"
    yield "set key at graph 1, graph 1.02 bottom right horizontal maxrows 1 reverse Left samplen 1.5; set xzeroaxis lc rgb \"#CCCCCC\""
    yield f"set multiplot; set label 1 {quoted(title)} at screen 0.01, 0.967 font \"DejaVu Sans:Bold,16\" noenhanced"
    for column, span in ((LEFT, whole), (RIGHT, window)):
        zoomed = column is RIGHT
        heading = f"{window_s:g} s of it: contact begins" if zoomed else "Whole run"
        for row, panel in zip(ROWS, (PATH, FORCE, ALPHA if zoomed else AGE)):
            last = row is ROWS[-1]
            yield "unset object"
            yield f'set xlabel "{"time [s]" if last else ""}"; set format x "{"%g" if last else ""}"'
            faded = faded_spans(recording) if panel is FORCE else []
            yield from (rectangle(times, FADED_COLOUR) for times in faded)
            yield rectangle(window, WINDOW_COLOUR)
            if row is ROWS[0]:
                yield f'set label 2 "{heading}" at graph 0, graph 1.08 font "DejaVu Sans:Bold,12.5"'
            yield "set key" if (last if zoomed else not last) else "unset key"
            marks = (switches_s(recording, window), "switch of snapshots" if last else "") if zoomed else ((), "")
            yield from panel_commands(panel, (column, row), span, limits(panel, table, span), marks, faded)
            yield "unset label 1; unset label 2"
    yield "unset multiplot"


def quoted(text):
    """A string of gnuplot's, in which nothing is a command."""
    return "'" + text.replace("'", "\'\'").replace("\n", " ") + "'"


def draw(recording, title, window_s, picture):
    """Writes the picture, whole or not at all. Raises OSError, or ValueError with what gnuplot said."""
    part = picture.with_name(f"{picture.stem}.part.png")
    script = "\n".join(commands(recording, title, window_s)).replace("ARG1", quoted(str(part)), 1)
    try:
        done = subprocess.run(["gnuplot", "-"], input=script, text=True, capture_output=True, check=False)
        if done.returncode or not part.is_file():
            raise ValueError(f"gnuplot: {' '.join(done.stderr.split()) or 'no picture'}")
        os.replace(part, picture)
    finally:
        part.unlink(missing_ok=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", metavar="RECORDING.csv")
    parser.add_argument("picture", metavar="OUT.png", type=pathlib.Path)
    parser.add_argument("--title", help="default: scene and device of the recording")
    parser.add_argument("--window", type=float, default=0.1, metavar="S",
                        help="length of the right column, s; default 0.1")
    arguments = parser.parse_args()
    try:
        recording = load(arguments.recording)
        known = [recording.metadata[key] for key in ("scene", "device") if key in recording.metadata]
        draw(recording, arguments.title or ", ".join(known), arguments.window, arguments.picture)
    except FileNotFoundError as error:
        missing = "no program gnuplot: expected Debian's gnuplot-nox, as scripts/setup --demo installs"
        sys.exit(f"plot_recording: {missing if error.filename == 'gnuplot' else error}")
    except (OSError, ValueError) as error:
        sys.exit(f"plot_recording: {error}")


if __name__ == "__main__":
    main()
