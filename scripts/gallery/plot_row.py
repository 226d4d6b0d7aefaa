#!/usr/bin/python3
"""Draws docs/charts/row_ripple.png, Fig. 5 of the paper, from the table that measure_printed.py writes."""
import math

from drawing import draw_charts, plt
from tables import read_rows

COLOURS = ("#0072B2", "#009E73", "#E69F00", "#D55E00")
HOLE_MM = 2.0 * math.sqrt(15.0**2 - 13.0**2)  # spacing from which a row has holes


def read_curves(file):
    """quantity -> spacing in mm -> rows of x, measured, formula"""
    curves = {}
    for row in read_rows(file):
        of_spacing = curves.setdefault(row["quantity"], {})
        of_spacing.setdefault(float(row["spacing_mm"]), []).append(
            tuple(float(row[key]) for key in ("x", "measured", "formula")))
    return curves


def draw_lines(axes, curves):
    for colour, (spacing, rows) in zip(COLOURS, sorted(curves.items())):
        axes.plot([x for x, _, _ in rows], [y for _, y, _ in rows], color=colour,
                  label=f"{spacing:g} mm")
    axes.set_xlabel("place along the row [mm]")
    axes.set_ylabel("normal force [N]")
    axes.set_xlim(-20, 20)
    axes.set_ylim(0, 2.75)
    axes.legend(title="spacing", frameon=False, ncol=4, loc="upper center", fontsize=8.5,
                bbox_to_anchor=(0.5, 1.0), columnspacing=1.0, handlelength=1.3)
    axes.set_title("A tool drawn along a row", loc="left", fontsize=10.5, fontweight="bold")


def draw_ripple(axes, curves):
    for (name, label), colour in zip((("least_over_most", "least / most"),
                                      ("ripple", "standard deviation / mean"),
                                      ("holes", "share of the row in holes")), COLOURS):
        points = [(spacing, rows[0][1]) for spacing, rows in sorted(curves[name].items())]
        axes.plot(*zip(*points), color=colour, label=label)
    axes.axvline(HOLE_MM, color="0.75", linewidth=1.0, zorder=0)
    axes.text(HOLE_MM + 0.2, 0.93, "holes", color="0.5", fontsize=8.5)
    axes.set_xlabel("spacing [mm]")
    axes.set_ylabel("of the normal force")
    axes.set_ylim(0, 1)
    axes.legend(frameon=False, loc="center left", fontsize=8.5)
    axes.set_title("Ripple is not monotonic in spacing", loc="left", fontsize=10.5,
                   fontweight="bold")


def draw_against_formula(axes, curves, mark_every):
    for colour, (spacing, rows) in zip(COLOURS, sorted(curves.items())):
        x, measured, formula = zip(*rows)
        axes.plot(x, formula, color=colour, label=f"{spacing:g} mm" if len(curves) > 1 else None)
        axes.plot(x[::mark_every], measured[::mark_every], "o", color=colour, markersize=4,
                  markerfacecolor="white")


def worst(rows):
    """The largest difference, of the largest value."""
    largest = max(formula for _, _, formula in rows)
    return max(abs(measured - formula) for _, measured, formula in rows) / largest


def draw(charts):
    curves = read_curves(charts / "row_ripple.csv")
    figure, ((lines, ripple), (mean, sheet)) = plt.subplots(2, 2, figsize=(10.4, 7.4))
    draw_lines(lines, curves["force_N_along_mm"])
    draw_ripple(ripple, curves)

    means = [rows[0] for _, rows in sorted(curves["mean_N"].items())]
    draw_against_formula(mean, {0.0: means}, 3)
    mean.set_xlabel("spacing [mm]")
    mean.set_ylabel("mean normal force [N]")
    mean.set_ylim(bottom=0)
    mean.set_title("Mean along a row: formula (line), measured (rings)", loc="left",
                   fontsize=10.5, fontweight="bold")
    mean.text(0.97, 0.9, f"largest difference {worst(means):.1e} of the largest", ha="right",
              transform=mean.transAxes, color="0.35")

    sheets = curves["sheet_N_per_m_by_mm"]
    draw_against_formula(sheet, sheets, 2)
    sheet.axhline(0.0, color="0.75", linewidth=1.0, zorder=0)
    sheet.set_xlabel("depth [mm]")
    sheet.set_ylabel("effective stiffness [N/m]")
    sheet.legend(title="spacing", frameon=False, loc="upper right", fontsize=8.5)
    sheet.set_title("A square sheet: stiffness grows with density", loc="left", fontsize=10.5,
                    fontweight="bold")
    difference = max(worst(rows) for rows in sheets.values())
    sheet.text(0.03, 0.03, f"largest difference {difference:.1e} of the peak", transform=sheet.transAxes,
               color="0.35")
    figure.suptitle("Force over spheres in a row and in a sheet "
                    "(radii 10 and 5 mm, 500 N/m; rows at 2 mm depth)",
                    x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.97), h_pad=2.0, w_pad=2.0)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"row_ripple": draw})
