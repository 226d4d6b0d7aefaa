#!/usr/bin/python3
"""Draws docs/charts/faults.png from the two tables of tests/integration/fault_table.py.

Drivers that end the program and signals are in the table alone: there is only a cut to be seen."""
import re
import textwrap

from drawing import draw_charts, plt
from tables import read_rows

COLOURS = {"device": "#0072B2", "simulation": "#009E73", "memory": "#CC79A7", "clock": "#E69F00",
           "disk": "#888888", "operator": "#D55E00", "force": "#56B4E9"}
MAX_FORCE_N = 3.3  # of the device
COLUMNS = 8


def draw_fault(axes, row, trace):
    colour = COLOURS[row["kind"]]
    axes.axhline(MAX_FORCE_N, color="0.75", linewidth=0.8, linestyle="--")
    axes.axvline(0.0, color="0.8", linewidth=0.8)
    if row["limit_ms"] and float(row["limit_ms"]) < 600.0:
        axes.axvline(float(row["limit_ms"]), color="#D55E00", linewidth=0.8, linestyle=":")
    axes.plot([float(point["time_ms"]) for point in trace],
              [float(point["force_N"]) for point in trace], color=colour, linewidth=1.3)
    name = re.sub(r"(\d) (\w)", "\\1\u00a0\\2", row["fault"])
    axes.set_title("\n".join(textwrap.wrap(name, 27)), fontsize=7.5, loc="left", pad=3)
    axes.tick_params(labelsize=7, length=2)


def draw(charts):
    rows = [row for row in read_rows(charts / "faults.csv") if row["kind"] in COLOURS]
    traces = read_rows(charts / "fault_traces.csv")
    lines = -(-len(rows) // COLUMNS)
    lines += len(rows) > COLUMNS * lines - 3  # room for the legend
    figure, panels = plt.subplots(lines, COLUMNS, figsize=(14.0, 1.5 * lines + 0.5), sharex=True,
                                  sharey=True, squeeze=False)
    for axes, row in zip(panels.flat, rows):
        draw_fault(axes, row, [point for point in traces
                               if (point["kind"], point["fault"]) == (row["kind"], row["fault"])])
    for axes in panels.flat[len(rows):]:
        axes.axis("off")
    panels.flat[0].set(xlim=(-50, 650), ylim=(-0.1, 3.7), xticks=(0, 200, 400, 600),
                       yticks=(0, 1, 2, 3))
    for axes in panels.flat[max(0, len(rows) - COLUMNS):len(rows)]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("ms", fontsize=7.5, labelpad=1)
    for axes in panels[:, 0]:
        axes.set_ylabel("N", fontsize=7.5, labelpad=2)
    handles = [plt.Line2D([], [], color=colour) for colour in COLOURS.values()]
    handles.append(plt.Line2D([], [], color="0.75", linestyle="--", linewidth=0.8))
    handles.append(plt.Line2D([], [], color="#D55E00", linestyle=":", linewidth=0.8))
    figure.legend(handles, [*COLOURS, "device's limit", "no force by then"], ncol=3,
                  loc="lower right", frameon=False, fontsize=9, bbox_to_anchor=(0.99, 0.03))
    figure.suptitle("What the device is told after a fault, at 0 ms", x=0.01, y=0.995, ha="left",
                    fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.99), h_pad=0.5, w_pad=0.6)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"faults": draw}, dpi=100)
