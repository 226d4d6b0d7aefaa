"""Draws two forces over time, their difference, where it begins and where it is largest."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy
from verdict import largest_words

# Okabe and Ito's, which the colour-blind can tell apart; dashes tell them apart in grey.
EXPECTED_COLOUR, GOT_COLOUR = "#222222", "#D55E00"
TOLERANCE_COLOUR, FIRST_COLOUR = "#DCEBF5", "#0072B2"
AXES = {"fx_N": ("#E69F00", "-"), "fy_N": ("#009E73", "--"), "fz_N": ("#0072B2", ":")}
ZOOM_ROWS = 40


def drawn_names(comparison):
    """Forces that change or differ; all of them where none does."""
    flat = [name for k, name in enumerate(comparison.names)
            if not numpy.ptp(comparison.expected_N[:, k]) and not comparison.difference_N[:, k].any()]
    return [name for name in comparison.names if name not in flat] or list(comparison.names)


def zoom_s(comparison):
    """From when to when the rows around the first difference go; None where there is none."""
    if not comparison.first:
        return None
    row, last = comparison.first[0], len(comparison.time_s) - 1
    return comparison.time_s[max(row - ZOOM_ROWS // 2, 0)], comparison.time_s[min(row + ZOOM_ROWS, last)]


def draw(comparison, file, hand):
    """hand: what was replayed, as it is called."""
    plt.rcParams.update({"font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False,
                         "axes.linewidth": 0.8})
    names, zoom = drawn_names(comparison), zoom_s(comparison)
    figure, panels = plt.subplots(len(names) + 1, 2 if zoom else 1, sharex="col", squeeze=False,
                                  figsize=(11.0, 2.0 * (len(names) + 1) + 1.0),
                                  width_ratios=[2, 1] if zoom else [1], constrained_layout=True)
    for column in range(panels.shape[1]):
        draw_column(panels[:, column], comparison, names)
    if zoom:
        for axes in panels[:, 1]:
            axes.set_xlim(*zoom)
        panels[0, 1].set_title("around the first difference", loc="left", fontsize=9.5)
        fit_to_zoom(panels, comparison, names, zoom)
    for axes, name in zip(panels[:, 0], names):
        axes.set_ylabel(f"{name.removesuffix('_N')} [N]")
    panels[-1, 0].set_ylabel("got - expected [N]")
    panels[0, 0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=3, frameon=False)
    panels[-1, 0].legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncol=5, frameon=False)
    figure.suptitle(title(comparison, hand, names), x=0.01, ha="left", fontsize=10)
    figure.savefig(file, dpi=110, facecolor="white")
    plt.close(figure)


def draw_column(panels, comparison, names):
    *force_panels, difference_panel = panels
    for axes, name in zip(force_panels, names):
        k = comparison.names.index(name)
        axes.plot(comparison.time_s, comparison.expected_N[:, k], color=EXPECTED_COLOUR, linewidth=2.2,
                  label="expected")
        axes.plot(comparison.time_s, comparison.got_N[:, k], color=GOT_COLOUR, linewidth=1.0, label="got")
    draw_difference(difference_panel, comparison, names)
    difference_panel.set_xlabel("time [s]")
    if comparison.first:
        for axes in panels:
            axes.axvline(comparison.time_s[comparison.first[0]], color=FIRST_COLOUR, linewidth=1.2, linestyle="--",
                         zorder=3)


def draw_difference(axes, comparison, names):
    tolerance_N = comparison.tolerance_N
    axes.axhspan(-tolerance_N, tolerance_N, color=TOLERANCE_COLOUR, linewidth=0, label=f"tolerance {tolerance_N:g} N")
    for name in names:
        colour, dashes = AXES[name]
        axes.plot(comparison.time_s, comparison.difference_N[:, comparison.names.index(name)], dashes, color=colour,
                  linewidth=1.3, label=name.removesuffix("_N"))
    row, column = comparison.largest
    axes.plot(comparison.time_s[row], comparison.difference_N[row, column], "v" if
              comparison.difference_N[row, column] > 0 else "^", color="black", markersize=6, zorder=4, label="largest")
    largest_N = max(numpy.abs(comparison.difference_N).max(), tolerance_N, 1e-12)
    axes.set_ylim(-1.25 * largest_N, 1.25 * largest_N)


def fit_to_zoom(panels, comparison, names, zoom):
    """The zoom's forces fill its height, where the whole's would leave a line of them."""
    inside = (comparison.time_s >= zoom[0]) & (comparison.time_s <= zoom[1])
    for axes, name in zip(panels[:, 1], names):
        k = comparison.names.index(name)
        both = numpy.concatenate([comparison.expected_N[inside, k], comparison.got_N[inside, k]])
        margin = 0.1 * numpy.ptp(both) or 1e-3
        axes.set_ylim(both.min() - margin, both.max() + margin)


def title(comparison, hand, names):
    about = comparison.got.about
    origin = ", ".join(filter(None, (f"scene {about.get('scene', 'unknown')}", f"hand {hand}", about.get("device_driver"),
                                     f"expected {comparison.expected.file.name}")))
    left_out = [name.removesuffix("_N") for name in comparison.names if name not in names]
    note = f"; not drawn, for flat and equal: {', '.join(left_out)}" if left_out else ""
    return f"{headline(comparison)}\n{origin}\n{largest_words(comparison)}{note}"


def headline(comparison):
    if comparison.first:
        row, column = comparison.first
        return f"First difference at {comparison.time_s[row]:.4f} s, {comparison.names[column]}"
    if not comparison.is_equal:
        return "Forces agree as far as both go" if not comparison.moved else "Positions differ"
    return "Equal within the tolerance"
