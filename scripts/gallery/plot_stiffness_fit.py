#!/usr/bin/python3
"""Draws docs/charts/stiffness_fit.png from the tables that measure_stiffness_fit.py writes.

--table prints R2 by model, for docs/stiffness_fit.md."""
import numpy

from drawing import draw_charts, plt
from tables import read_rows

MODELS = (("field with map", "#D55E00"), ("linear map", "#E69F00"), ("field, one stiffness", "#0072B2"),
          ("even spheres", "#009E73"), ("decomposition", "#CC79A7"))
GOAL = 0.9


def palpations(charts):
    return [row for row in read_rows(charts / "stiffness_fit.csv") if row["recording"] == "palpation"]


def draw_R2(axes, rows):
    for i, (model, colour) in enumerate(MODELS):
        mine = [float(row["R2_predicted"]) for row in rows if row["model"] == model]
        shift = numpy.linspace(-0.25, 0.25, len(mine)) if len(mine) > 1 else (0.0,)
        axes.plot(mine, [i + s for s in shift], "o", color=colour, markersize=4.5)
    axes.axvline(GOAL, color="0.5", linewidth=1.0, linestyle="--")
    axes.text(GOAL - 0.01, -0.62, "goal 0.9", ha="right", va="center", color="0.4", fontsize=8.5)
    axes.set_yticks(range(len(MODELS)), [model for model, _ in MODELS])
    axes.set_ylim(len(MODELS) - 0.5, -0.8)
    axes.set_xlim(-0.25, 1.0)
    axes.set_xlabel("R2 on the run that the fit did not see")


def draw_force(axes, charts):
    rows = read_rows(charts / "stiffness_fit_force.csv")
    time_s = numpy.array([float(row["time_s"]) for row in rows])
    gaps = numpy.flatnonzero(numpy.diff(time_s) > 0.1) + 1
    for column, label, colour, width in (("measured_N", "measured (simulated)", "0.2", 1.7),
                                         ("field_one_stiffness_N", "one stiffness", "#0072B2", 0.9),
                                         ("field_with_map_N", "field with map", "#D55E00", 1.1)):
        force_N = numpy.array([float(row[column]) for row in rows])
        for i, part in enumerate(numpy.split(numpy.arange(len(rows)), gaps)):
            axes.plot(time_s[part], force_N[part], color=colour, linewidth=width, label=label if i == 0 else None)
    axes.set_xlim(time_s[0], time_s[-1])
    axes.set_xlabel("time [s]")
    axes.set_ylabel("force along the normal [N]")
    axes.legend(frameon=False, ncol=3, loc="lower right", bbox_to_anchor=(1.0, 1.0))


def draw_maps(figure, true_axes, fitted_axes, charts):
    rows = read_rows(charts / "stiffness_fit_map.csv")
    points = [row for row in rows if row["kind"] == "point"]
    places_mm = numpy.array([(float(row["y_mm"]), float(row["x_mm"])) for row in rows if row["kind"] == "place"])
    x, y = (sorted({float(row[key]) for row in points}) for key in ("x_mm", "y_mm"))
    extent = (y[0], y[-1], x[0], x[-1])
    for axes, key, title in ((true_axes, "true_N_per_m", "the truth"),
                             (fitted_axes, "fitted_N_per_m", f"fitted, {len(places_mm)} places")):
        picture = numpy.array([float(row[key]) for row in points]).reshape(len(x), len(y))
        drawn = axes.imshow(picture, origin="lower", extent=extent, cmap="viridis", vmin=150.0, vmax=1350.0)
        axes.set_title(title, loc="left", fontsize=9.5)
        axes.set_ylabel("[mm]")
    fitted_axes.plot(*places_mm.T, "o", color="white", markersize=3, markeredgecolor="black", markeredgewidth=0.4)
    fitted_axes.set_xlim(extent[:2])
    fitted_axes.set_ylim(extent[2:])
    fitted_axes.set_xlabel("along the liver [mm]")
    figure.colorbar(drawn, ax=[true_axes, fitted_axes], label="stiffness [N/m]", shrink=0.85)


def draw(charts):
    figure = plt.figure(figsize=(11.0, 7.2), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(1, 1.35))
    draw_force(top.subplots(), charts)
    left, right = bottom.subfigures(1, 2)
    draw_R2(left.subplots(), palpations(charts))
    draw_maps(right, *right.subplots(2, 1, sharex=True), charts)
    figure.suptitle("Simulated palpation of a liver with a hard place: fitted to one run, tried on another", x=0.01,
                    ha="left", fontsize=12, fontweight="bold")
    return figure


def print_table(charts):
    rows = palpations(charts)
    print("| model | first run: R2 | second run: R2 | least of both |\n|---|---|---|---|")
    for model, _ in MODELS:
        first, second = ([float(row[key]) for row in rows if row["model"] == model]
                         for key in ("R2_fitted", "R2_predicted"))
        print(f"| {model} | {numpy.mean(first):.3f} | {numpy.mean(second):.3f} | {min(first + second):.3f} |")
    maps = [row for row in rows if row["model"] == "field with map"]
    off_mm = [abs(float(row["offset_mm"]) - float(row["true_offset_mm"])) for row in maps]
    print(f"places {min(int(row['places']) for row in maps)} to {max(int(row['places']) for row in maps)}; offset "
          f"within {max(off_mm):.2f} mm; stiffness rms "
          f"{100 * min(float(row['stiffness_error']) for row in maps):.1f} to "
          f"{100 * max(float(row['stiffness_error']) for row in maps):.1f} %")
    for row in read_rows(charts / "stiffness_fit.csv"):
        if row["recording"] == "spring":
            print(f"spring, {row['model']}: {row['R2_fitted']} {row['R2_predicted']}")


if __name__ == "__main__":
    folder, wants_table = draw_charts(__doc__, {"stiffness_fit": draw},
                                      flag=("--table", "print R2 by model for the page"))
    if wants_table:
        print_table(folder)
