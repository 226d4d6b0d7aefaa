"""Draws two forces over time, their difference, and where it begins."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

# Okabe and Ito's, which the colour-blind can tell apart.
EXPECTED_COLOUR, GOT_COLOUR = "#222222", "#D55E00"
TOLERANCE_COLOUR, FIRST_COLOUR = "#DCEBF5", "#0072B2"


def draw(comparison, file):
    plt.rcParams.update({"font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False,
                         "axes.linewidth": 0.8})
    names = comparison.names
    figure, panels = plt.subplots(len(names) + 1, 1, sharex=True, squeeze=False,
                                  figsize=(11.0, 2.0 * (len(names) + 1) + 0.6))
    *force_panels, difference_panel = panels[:, 0]
    for k, (axes, name) in enumerate(zip(force_panels, names)):
        axes.plot(comparison.time_s, comparison.expected_N[:, k], color=EXPECTED_COLOUR,
                  linewidth=2.2, label="expected")
        axes.plot(comparison.time_s, comparison.got_N[:, k], color=GOT_COLOUR, linewidth=1.0,
                  label="got")
        axes.set_ylabel(f"{name.removesuffix('_N')} [N]")
    draw_difference(difference_panel, comparison)
    for axes in panels[:, 0]:
        mark_first(axes, comparison)
    force_panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=3, frameon=False)
    difference_panel.set_xlabel("time [s]")
    figure.align_ylabels()
    figure.suptitle(headline(comparison), x=0.125, y=0.93, ha="left", fontweight="bold")
    figure.savefig(file, dpi=110, bbox_inches="tight", facecolor="white")
    plt.close(figure)


def draw_difference(axes, comparison):
    tolerance_N = comparison.tolerance_N
    axes.axhspan(-tolerance_N, tolerance_N, color=TOLERANCE_COLOUR, linewidth=0,
                 label=f"tolerance {tolerance_N:g} N")
    colours = ("#E69F00", "#009E73", "#0072B2")
    for name, colour, column in zip(comparison.names, colours, comparison.difference_N.T):
        axes.plot(comparison.time_s, column, color=colour, linewidth=1.1,
                  label=name.removesuffix("_N"))
    axes.set_ylabel("got - expected [N]")
    largest_N = max(numpy.abs(comparison.difference_N).max(), tolerance_N, 1e-12)
    axes.set_ylim(-1.15 * largest_N, 1.15 * largest_N)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncol=5, frameon=False)


def mark_first(axes, comparison):
    if comparison.first:
        axes.axvline(comparison.time_s[comparison.first[0]], color=FIRST_COLOUR, linewidth=1.2,
                     linestyle="--", zorder=3)


def headline(comparison):
    if comparison.first:
        row, column = comparison.first
        return f"First difference at {comparison.time_s[row]:.4f} s, {comparison.names[column]}"
    if not comparison.is_equal:
        return "Forces agree as far as both go" if not comparison.moved else "Positions differ"
    return "Equal within the tolerance"
