#!/usr/bin/python3
"""Draws what measure_work_precision.py measured: error against time of every method early, where small
differences have not grown yet (docs/charts/work_precision.png), and late (work_precision_late.png), and
slopes of the error over the step against theory (integrator_slopes.png)."""
import math

import numpy

from drawing import draw_charts, matplotlib, plt
import tables

TITLES = {
    "cloth_8x8_1e3": "Cloth 8 x 8, 1e3 N/m", "cloth_8x8_1e4": "Cloth 8 x 8, 1e4 N/m",
    "cloth_8x8_1e5": "Cloth 8 x 8, 1e5 N/m", "hanging_chain": "Hanging chain, let go at 30°",
    "cloth_32x32_1e3": "Cloth 32 x 32, 1e3 N/m", "cloth_32x32_1e4": "Cloth 32 x 32, 1e4 N/m",
    "cloth_32x32_1e5": "Cloth 32 x 32, 1e5 N/m", "threads": "Forty threads, swinging",
    "cloth_100x100_1e4": "Cloth 100 x 100, 1e4 N/m",
    "tissue_and_blocks": "Tissue and blocks (contacts)",
}
METHODS = {  # integrator, variant: label, colour, line and marker
    ("velocity_verlet", ""): ("velocity Verlet, substeps", "#6B8E23", "o-"),
    ("implicit_euler", ""): ("implicit Euler", "#D55E00", "^--"),
    ("broyden", ""): ("implicit Euler by the paper's Broyden", "#8C564B", "D:"),
    ("cvode_bdf", ""): ("SUNDIALS CVODE, BDF", "black", "P-"),
    ("bullet", "implicit"): ("Bullet deformable, implicit", "#CC2E8E", "X-"),
    ("bullet", "explicit"): ("Bullet deformable, explicit", "#CC2E8E", "X:"),
    ("mujoco", "euler"): ("MuJoCo tendons, Euler", "#00B5C8", "h:"),
    ("mujoco", "rk4"): ("MuJoCo tendons, RK4", "#00B5C8", "h-"),
    ("mujoco", "implicit"): ("MuJoCo tendons, implicit", "#00B5C8", "h--"),
}
FLOORS = ("reference", "disturbance")
AUTO = "auto"  # what integrator = "auto" chose, not a method of its own
CLOTHS = [scene for scene in TITLES if scene.startswith("cloth")]
TIMES_S = {"tissue_and_blocks": (0.1, 0.3), "cloth_100x100_1e4": (0.1, 0.25)}  # others: 0.25, 1
DIVERGED_M = 1.0
THEORY = {"velocity_verlet": 2.0, "implicit_euler": 0.96}


def read_rows(charts):
    rows = tables.read_rows(charts / "work_precision.csv")
    for row in rows:
        for column in ("value", "early_m", "error_m", "rest_m", "ms_per_10ms", "p25_ms", "p75_ms"):
            row[column] = float(row[column] or "nan")
    return rows


def of_method(rows, scene, method):
    return [row for row in rows if row["scene"] == scene
            and (row["integrator"], row["solver"]) == method]


def is_good(row, error="error_m"):
    """Also of a run that was broken off as too slow, but after the time of that error."""
    return (row["status"] in ("done", "too_slow") and row[error] < DIVERGED_M
            and row["integrator"] not in (*FLOORS, AUTO))


def front(rows, error="error_m"):
    """Those that no other beats in both error and time, by falling error."""
    best, chosen = math.inf, []
    for row in sorted(rows, key=lambda row: (row["ms_per_10ms"], row[error])):
        if row[error] < best:
            best = row[error]
            chosen.append(row)
    return chosen


def draw_points(axes, rows, scene, error, left, right):
    best = front([row for row in rows if row["scene"] == scene and is_good(row, error)], error)
    for method, (_, colour, style) in METHODS.items():
        points = of_method(rows, scene, method)
        good = [row for row in points if is_good(row, error)]
        axes.plot([row[error] for row in good], [row["ms_per_10ms"] for row in good], style[1:],
                  color=colour, linewidth=1.1, alpha=0.6, zorder=2)
        for row in good:
            on_front = row in best
            axes.plot(row[error], row["ms_per_10ms"], style[0], color=colour,
                      alpha=1.0 if on_front else 0.6, markersize=6.5 if on_front else 4.0,
                      markeredgecolor="black" if on_front else "none", zorder=5 if on_front else 3)
        for row in points:
            if not is_good(row, error) and not row[error] < left:
                known = row[error] < right
                axes.plot(row[error] if known else right, row["ms_per_10ms"], "x", color=colour,
                          markersize=4.5 if known else 6, markeredgewidth=1.3, clip_on=False,
                          zorder=4)
    for row in rows:
        if row["scene"] == scene and row["integrator"] == AUTO and row["status"] == "done":
            axes.plot(max(row[error], left), row["ms_per_10ms"], "*", color="#D40000",
                      markersize=11, markeredgecolor="white", zorder=6)
    axes.plot([row[error] for row in best], [row["ms_per_10ms"] for row in best], "-",
              color="black", linewidth=0.9, zorder=4)
    for row in rows:
        if row["scene"] == scene and row["integrator"] == "disturbance":
            axes.axvspan(1e-12, row[error], color="0.92", zorder=0)


def draw_panel(axes, rows, scene, error):
    """Limits leave room for all that is finite, within reason."""
    mine = [row for row in rows if row["scene"] == scene and row["integrator"] not in FLOORS]
    errors = [row[error] for row in mine if is_good(row, error)]
    right = 10.0 ** math.ceil(math.log10(max(errors)) + 0.1)
    left = max(10.0 ** math.floor(math.log10(min(errors))), 1e-6 * right)
    times = [row["ms_per_10ms"] for row in mine if is_good(row, error)]
    low, high = 0.5 * min(times), 2.0 * max(times)
    for row in mine:  # a cross beyond the frame stands at its corner
        row["ms_per_10ms"] = min(max(row["ms_per_10ms"], low), high)
    draw_points(axes, rows, scene, error, left, right)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    axes.axhline(10.0, color="black", linewidth=1.2, linestyle="--", zorder=1.5)
    axes.axhline(1.0, color="black", linewidth=1.2, linestyle=":", zorder=1.5)
    axes.set_title(TITLES[scene], fontsize=10.5, loc="left")
    axes.grid(color="0.95", zorder=0)
    axes.tick_params(labelsize=8.5)
    time_s = TIMES_S.get(scene, (0.25, 1.0))[error == "error_m"]
    axes.set_xlabel(f"position error at {time_s:g} s, rms [m]", fontsize=9)


def draw_legend(axes, has_auto):
    axes.axis("off")
    handles = [plt.Line2D([], [], color=colour, marker=style[0], linestyle=style[1:], markersize=5,
                          label=label) for label, colour, style in METHODS.values()]
    handles += [
        plt.Line2D([], [], color="black", marker="o", markerfacecolor="white", markersize=6,
                   label="on the Pareto front; others are pale"),
        *([plt.Line2D([], [], color="#D40000", marker="*", linestyle="", markersize=10,
                      label='chosen by integrator = "auto" at steps of 20, 10, 5, 1 ms')] if has_auto else []),
        plt.Line2D([], [], color="0.3", marker="x", linestyle="", markersize=6,
                   label="diverged, not converged or too slow;\nat the border: nothing to compare"),
        plt.Line2D([], [], color="black", linestyle="--", linewidth=1.2,
                   label="real time: 10 ms per 10 ms"),
        plt.Line2D([], [], color="black", linestyle=":", linewidth=1.2,
                   label="a tenth of a core: 1 ms per 10 ms"),
        matplotlib.patches.Patch(color="0.92", label="what a shift of 1e-6 m grows to:\nerrors "
                                                     "below do not rank methods"),
    ]
    axes.legend(handles=handles, loc="center", frameon=False, fontsize=8.5, ncols=2,
                handlelength=2.4, columnspacing=1.2, labelspacing=0.55)


def draw_chart(rows, error):
    shown = [scene for scene in TITLES
             if any(row["scene"] == scene and is_good(row, error) for row in rows)]
    # The legend takes two cells after the last panel, or the last line.
    lines = -(-(len(shown) + 2) // 4)
    figure = plt.figure(figsize=(15, 4.2 * lines + 0.9))
    grid = figure.add_gridspec(lines, 4, hspace=0.32, wspace=0.2, left=0.05, right=0.985,
                               top=1.0 - 1.15 / (4.2 * lines + 0.9), bottom=0.6 / (4.2 * lines + 0.9))
    for i, scene in enumerate(shown):
        axes = figure.add_subplot(grid[i // 4, i % 4])
        draw_panel(axes, rows, scene, error)
        if i % 4 == 0:
            axes.set_ylabel("processor time per simulated 10 ms [ms]")
    draw_legend(figure.add_subplot(grid[-1, 2:]), any(row["integrator"] == AUTO for row in rows))
    when = "early, before small differences grow" if error == "early_m" else "late"
    figure.suptitle(f"What a method costs and how far it errs: {when}", x=0.05, y=0.99, ha="left",
                    fontsize=15, fontweight="bold")
    figure.text(0.05, 1.0 - 0.72 / (4.2 * lines + 0.9), "Each curve is a method over its step or tolerance, against a converged "
                "reference; down and left is better.", fontsize=10.5, color="0.3")
    return figure


def fitted_slope(points):
    x = numpy.log([row["value"] for row in points])
    y = numpy.log([row["early_m"] for row in points])
    return numpy.polyfit(x, y, 1)[0]


def draw_slopes(rows):
    scenes = {"chain_modes": "Chain of ten masses, against its modes",
              "cloth_8x8_1e4": "Cloth 8 x 8, 1e4 N/m"}
    measured = {row["scene"] for row in rows}
    scenes = {scene: title for scene, title in scenes.items() if scene in measured}
    figure, panels = plt.subplots(1, len(scenes), figsize=(5.7 * len(scenes), 5.2), sharey=True,
                                  squeeze=False)
    for axes, (scene, title) in zip(panels[0], scenes.items()):
        for integrator, expected in THEORY.items():
            label, colour, style = METHODS[integrator, ""]
            points = [row for row in of_method(rows, scene, (integrator, ""))
                      if row["early_m"] < DIVERGED_M]
            fine = [row for row in points if row["value"] < 3e-3]
            if len(fine) < 2:
                continue
            slope = fitted_slope(fine)
            print(f"slope {scene} {integrator}: {slope:.3f}, catalogue {expected:g}")
            axes.plot([row["value"] for row in points], [row["early_m"] for row in points], style,
                      color=colour, markersize=5,
                      label=f"{label.split(':')[0].split(',')[0]}: {slope:.2f} ({expected:g})")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(title, fontsize=10.5, loc="left")
        axes.set_xlabel("step [s]")
        axes.grid(color="0.94")
        axes.legend(frameon=False, fontsize=9, loc="lower right",
                    title="slope below 3 ms (catalogue)", title_fontsize=9)
    panels[0][0].set_ylabel("position error at 0.25 s, rms [m]")
    figure.suptitle("Errors fall with the step as theory says", x=0.02, ha="left", fontsize=13,
                    fontweight="bold")
    figure.tight_layout()
    return figure


def time_at(points, error_m, error):
    """Time at which a curve reaches an error, between its points along straight lines of the chart;
    its cheapest point if that errs less yet, nothing if it never comes so far."""
    good = front([row for row in points if is_good(row, error)], error)
    if not good or good[-1][error] > error_m:
        return None
    if good[0][error] <= error_m:
        return good[0]["ms_per_10ms"]
    x = [math.log(row[error]) for row in reversed(good)]
    y = [math.log(row["ms_per_10ms"]) for row in reversed(good)]
    return math.exp(numpy.interp(math.log(error_m), x, y))


RIVALS = [method for method in METHODS
          if method[0] in ("cvode_bdf", "bullet", "mujoco")]
OURS = [method for method in METHODS if method not in RIVALS]


def print_ratios(rows, error):
    """Ours against each rival at the errors of the rival's own points: least and most ratio."""
    print(f"{error:19} {'rival':17} {'errors [m]':>19} {'times faster':>17}")
    for scene in CLOTHS:
        ours = [row for method in OURS for row in of_method(rows, scene, method)]
        for rival in RIVALS:
            points = [row for row in of_method(rows, scene, rival) if is_good(row, error)]
            ratios = [(row[error], row["ms_per_10ms"] / mine) for row in points
                      if (mine := time_at(ours, row[error], error))]
            if not ratios:
                continue
            errors, times = zip(*ratios)
            print(f"{scene:19} {' '.join(rival):17} {min(errors):9.2g}{max(errors):10.2g} "
                  f"{min(times):8.3g}{max(times):9.3g}")


def cheapest(rows, scene, most_m):
    good = [row for row in rows if row["scene"] == scene and is_good(row, "early_m")
            and row["early_m"] <= most_m and (row["integrator"], row["solver"]) in OURS]
    return min(good, key=lambda row: row["ms_per_10ms"], default=None)


def print_auto(rows):
    """What auto chose against the cheapest hand-picked method within the same target."""
    for row in rows:
        if row["integrator"] != AUTO:
            continue
        best = cheapest(rows, row["scene"], row["value"])
        against = "no other within it" if best is None else (
            f"{row['ms_per_10ms'] / best['ms_per_10ms']:.2f} times {best['integrator']} "
            f"{best['solver']} {best['knob']} {best['value']:g}")
        print(f"{row['scene']} auto for {row['value']:g} m: {row['solver']}, "
              f"{row['ms_per_10ms']:.3g} ms per 10 ms, {row['early_m']:.2g} m, {row['status']}: "
              f"{against}")


def print_goals(rows):
    print_auto(rows)
    print_ratios(rows, "early_m")
    print_ratios(rows, "error_m")
    for scene in TITLES:
        for most_m in (1e-2, 1e-3, 1e-4):
            row = cheapest(rows, scene, most_m)
            text = "none" if row is None else (
                f"{row['integrator']} {row['solver']} {row['knob']} {row['value']:g}: "
                f"{row['ms_per_10ms']:.3g} ms per 10 ms, {row['early_m']:.2g} m")
            print(f"{scene}: cheapest within {most_m:g} m early: {text}")
    for row in rows:
        if row["integrator"] not in FLOORS:
            continue
        text = f"{row['scene']} {row['integrator']}: moves places by {row['early_m']:.2g} m early, " \
               f"{row['error_m']:.2g} m late"
        if row["integrator"] == "reference":
            for error in ("early_m", "error_m"):
                of = [other for other in rows if other["scene"] == row["scene"]
                      and is_good(other, error)]
                moved = sum(row[error] > 0.1 * other[error] for other in of)
                text += f"; by more than a tenth of its error {moved} of {len(of)} points"
        print(text)


def main():
    charts, prints = draw_charts(
        __doc__, {"work_precision": lambda charts: draw_chart(read_rows(charts), "early_m"),
                  "work_precision_late": lambda charts: draw_chart(read_rows(charts), "error_m"),
                  "integrator_slopes": lambda charts: draw_slopes(read_rows(charts))},
        flag=("--goals", "print the figures of docs/algorithms/integrators.md too"))
    if prints:
        print_goals(read_rows(charts))


if __name__ == "__main__":
    main()
