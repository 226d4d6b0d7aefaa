"""Draws a trajectory over time, with its gaps and jumps."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

import look
from whole_file import whole

# Okabe and Ito's, which the colour-blind can tell apart.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7")
GAP_COLOUR, JUMP_COLOUR = "#F0C9B0", "#D55E00"


def draw(trajectory, faults, file):
    plt.rcParams.update({"font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False,
                         "axes.linewidth": 0.8})
    panels = [("position [mm]", 1e3 * trajectory.position_m, "xyz"), ("speed [m/s]", speeds_m_s(trajectory), [None])]
    if trajectory.turns is not None:
        panels.append(("orientation", trajectory.turns, ("qx", "qy", "qz", "qw")))
    if trajectory.force_N is not None:
        panels.append(("force [N]", trajectory.force_N, "xyz"))
    figure, axes = plt.subplots(len(panels), 1, sharex=True, figsize=(11.0, 2.1 * len(panels) + 0.6))
    for panel, (label, values, names) in zip(axes, panels):
        for name, column, colour in zip(names, values.T, COLOURS):
            panel.plot(*broken(trajectory.time_s, column, faults), color=colour, linewidth=1.1, label=name)
        panel.set_ylabel(label)
        mark(panel, faults)
        if names[0]:
            panel.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncol=4, frameon=False)
    axes[-1].set_xlabel("time [s]")
    figure.align_ylabels()
    figure.suptitle(headline(trajectory, faults), x=0.125, y=0.95, ha="left", fontweight="bold")
    with whole(file) as part:
        figure.savefig(part, format="png", dpi=110, bbox_inches="tight", facecolor="white")
    plt.close(figure)


def broken(time_s, column, faults):
    """No line across a gap, where nothing is known."""
    after = [fault.row + 1 for fault in faults if fault.kind == "gap"]
    return numpy.insert(time_s, after, numpy.nan), numpy.insert(column, after, numpy.nan)


def speeds_m_s(trajectory):
    """A row each, the last as the one before; over a stale reading 0."""
    speed_m_s = numpy.linalg.norm(numpy.diff(trajectory.position_m, axis=0), axis=1) / numpy.diff(trajectory.time_s)
    return numpy.append(speed_m_s, speed_m_s[-1])[:, None]


def mark(panel, faults):
    for fault in faults[:200]:
        if fault.kind == "gap":
            panel.axvspan(fault.start_s, fault.start_s + fault.duration_s, color=GAP_COLOUR, linewidth=0)
        else:
            panel.axvline(fault.start_s + fault.duration_s, color=JUMP_COLOUR, linewidth=1.0, linestyle="--")


def headline(trajectory, faults):
    told = f"{look.counted(faults)} (gaps shaded, others dashed)" if faults else "no gap, no jump"
    return f"{trajectory.table.file.name}: {trajectory.time_s[-1]:.4g} s, {told}"
