#!/usr/bin/python3
"""Draws docs/charts/model_table.png, model_pareto.png, spacing_rate.png and paper_figures.png from the
CSV that measure_models.py writes, and prints the tables of docs/algorithms/model_comparison.md."""
import argparse
import csv
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

CHARTS = pathlib.Path(__file__).resolve().parents[2] / "docs/charts"
TRANSITIONS = ("hold", "linear", "restart", "hermite", "extrapolate", "playout", "answer")
RIVALS = ("force_held", "force_jacobian", "plane", "sphere", "proxy", "crossfade")
FAST = ("hold at 250 Hz", "hold at 500 Hz", "hold at 1000 Hz")
COLOURS = {"answer": "#D55E00", "hold": "#0072B2", "linear": "#009E73"}
WHOLE = "tissue and blocks, all"
TOLERANCE = 0.07


def read_rows(file):
    with open(file) as stream:
        rows = list(csv.DictReader(stream))
    for row in rows:
        for key, value in row.items():
            try:
                row[key] = float(value)
            except ValueError:
                pass
    return rows


def paths_of(rows):
    return [path for path in dict.fromkeys(row["path"] for row in rows) if path != WHOLE]


def of(rows, path, jitter):
    return {row["model"]: row for row in rows if row["path"] == path and row["jitter"] == jitter}


def colour_of(model):
    return COLOURS.get(model, "#7A5BC7" if model in RIVALS else "0.35")


def label_of(model):
    return model.replace("hold at ", "").replace("1000 Hz", "1 kHz")


COLUMNS = (
    ("jump_max_N", "largest jump [N]", "log"),
    ("stage_felt_share", "time in stages\nabove 7 %", "linear"),
    ("error_share", "rms error, of the\nforce's rms", "log"),
    ("lag_ms", "effective latency [ms]", "linear"),
    ("vibration_N2", "vibration 20-500 Hz [N²]", "log"),
    ("tick_median_us", "tick, median [µs]", "log"),
    ("stable_stiffness_N_m", "stable stiffness [N/m]", "log"),
)
FLOOR = {"jump_max_N": 1e-5, "vibration_N2": 1e-7, "error_share": 1e-4}


def reference_rms_N(row, rows, path):
    """Of the true force: the run's own is what a late or wrong model made of it."""
    return of(rows, path, row["jitter"])["reference"]["force_rms_N"]


def draw_table(rows):
    models = (*TRANSITIONS, *RIVALS, *FAST)
    paths = paths_of(rows)
    markers = dict(zip(paths, "osD^vP*X"))
    figure, panels = plt.subplots(1, len(COLUMNS), figsize=(19, 6.6), sharey=True)
    for axes, (key, title, scale) in zip(panels, COLUMNS):
        for place, model in enumerate(models):
            for number, path in enumerate(paths):
                row = of(rows, path, 0.3).get(model)
                if row is None or row[key if key in row else "lag_ms"] == "":  # not searched
                    continue
                value = (row["rms_error_N"] / reference_rms_N(row, rows, path)
                         if key == "error_share" else row[key])
                value = max(value, FLOOR.get(key, 0.0))
                axes.plot(value, place + 0.1 * (number - 2.5), markers[path], markersize=5,
                          color=colour_of(model), alpha=0.85)
        axes.set_xscale(scale)
        axes.set_title(title, fontsize=9.5, loc="left")
        axes.set_yticks(range(len(models)), models)
        axes.set_ylim(len(models) - 0.4, -0.6)
        for edge in (len(TRANSITIONS) - 0.5, len(TRANSITIONS) + len(RIVALS) - 0.5):
            axes.axhline(edge, color="0.7", linewidth=0.8)
        axes.grid(color="0.93")
        axes.tick_params(labelsize=8.5)
        axes.spines[["top", "right"]].set_visible(False)
        if key in FLOOR:
            axes.axvline(FLOOR[key], color="0.6", linewidth=0.8, linestyle=":")
    for path in paths:
        panels[0].plot([], [], markers[path], color="0.3", label=path)
    figure.legend(loc="upper right", ncols=len(paths), frameon=False, fontsize=9)
    figure.suptitle("One path through all models: 33 Hz, a step costs a tenth, periods vary by 30 %",
                    x=0.01, ha="left", y=0.985,
                    fontsize=12, fontweight="bold")
    figure.text(0.01, 0.01, "Left edge (dotted): that or less. Error against the true state at 1 kHz; "
                "last three rows: held images of a simulation that is that fast.", fontsize=9,
                color="0.3")
    figure.tight_layout(rect=(0, 0.03, 1, 0.95))
    return figure


def front(rows, x, y):
    """Those that no other beats in both."""
    best, chosen = math.inf, []
    for row in sorted(rows, key=lambda row: (row[x], row[y])):
        if row[y] < best:
            best = row[y]
            chosen.append(row)
    return chosen


def annotate(axes, row, x, y, colour, floor=0.0):
    axes.annotate(label_of(row["model"]), (row[x], max(row[y], floor)), textcoords="offset points",
                  xytext=(4, 3), fontsize=7.5, color=colour)


def draw_pareto_panel(axes, mine):
    same = [row for name, row in mine.items() if name in TRANSITIONS + RIVALS]
    best = front(same, "tick_median_us", "rms_error_N")
    for row in same:
        is_best = row in best
        colour = colour_of(row["model"]) if is_best else "0.6"
        axes.plot(row["tick_median_us"], row["rms_error_N"], "o", color=colour,
                  markersize=7 if is_best else 4.5)
        annotate(axes, row, "tick_median_us", "rms_error_N", colour)
    axes.step([row["tick_median_us"] for row in best], [row["rms_error_N"] for row in best], "k-",
              where="post", linewidth=0.9, zorder=0)
    for name in FAST:
        row = mine[name]
        axes.plot(row["tick_median_us"], row["rms_error_N"], "s", color="0.3", markersize=5,
                  markerfacecolor="none")
        annotate(axes, row, "tick_median_us", "rms_error_N", "0.3")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("tick in contact, median [µs]", fontsize=8.5)
    axes.set_ylabel("force error, rms [N]", fontsize=8.5)


def draw_jump_panel(axes, mine):
    floor = 1e-6
    for name in TRANSITIONS + RIVALS:
        row = mine[name]
        axes.plot(row["lag_ms"], max(row["jump_max_N"], floor), "o", color=colour_of(name),
                  markersize=7 if name in COLOURS else 4.5)
        annotate(axes, row, "lag_ms", "jump_max_N", colour_of(name), floor)
    axes.axhline(0.01 * mine["hold"]["jump_max_N"], color=COLOURS["hold"], linewidth=0.9,
                 linestyle="--")
    axes.axvline(mine["answer"]["longest_period_ms"], color="0.5", linewidth=0.9, linestyle=":")
    axes.set_yscale("log")
    axes.set_xlim(-3, None)
    axes.set_xlabel("effective latency [ms]", fontsize=8.5)
    axes.set_ylabel("largest jump [N]", fontsize=8.5)


def draw_pareto(rows):
    paths = paths_of(rows)
    columns = 3
    lines = math.ceil(len(paths) / columns)
    figure, panels = plt.subplots(2 * lines, columns, figsize=(16, 7.6 * lines), squeeze=False)
    for number, path in enumerate(paths):
        mine = of(rows, path, 0.3)
        for line, draw in ((number // columns, draw_pareto_panel),
                           (lines + number // columns, draw_jump_panel)):
            axes = panels[line][number % columns]
            draw(axes, mine)
            axes.set_title(path, fontsize=10, loc="left", fontweight="bold")
            axes.grid(color="0.94")
            axes.tick_params(labelsize=8, which="both")
            axes.spines[["top", "right"]].set_visible(False)
    for axes in panels.flat[len(paths):lines * columns]:
        axes.axis("off")
    for axes in panels.flat[lines * columns + len(paths):]:
        axes.axis("off")
    figure.suptitle("Speed against accuracy, and jump against lag: 33 Hz, a step costs a tenth, "
                    "jitter 30 %", x=0.01, y=0.995, ha="left", fontsize=13, fontweight="bold")
    figure.text(0.01, 0.972, "Above: the Pareto front in colour, what it beats in grey; squares: held "
                "images of a faster simulation. Below: dashed, 1 % of hold's jump; dotted, the longest "
                "period; at the bottom edge no jump.", fontsize=10, color="0.3")
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    return figure


def cost_ms(row):
    return row["processor_ms_per_s"]


def draw_spacing(rows):
    paths = list(dict.fromkeys(row["path"] for row in rows))
    models = list(dict.fromkeys(row["model"] for row in rows))
    figure, panels = plt.subplots(len(paths), len(models), figsize=(5.2 * len(models),
                                  4.2 * len(paths)), sharex="row", sharey="row", squeeze=False)
    spacings = sorted({row["spacing_mm"] for row in rows})
    shades = dict(zip(spacings, plt.cm.viridis([0.0, 0.22, 0.44, 0.66, 0.88])))
    for line, path in enumerate(paths):
        mine = [row for row in rows if row["path"] == path]
        within = [row for row in mine if row["error_share"] <= TOLERANCE]
        cheapest = min(within, key=cost_ms, default=None)
        for axes, model in zip(panels[line], models):
            for spacing in spacings:
                curve = sorted((row for row in mine if row["model"] == model
                                and row["spacing_mm"] == spacing), key=lambda row: row["rate_hz"])
                axes.plot([cost_ms(row) for row in curve], [row["error_share"] for row in curve],
                          "o-", color=shades[spacing], markersize=5, label=f"{spacing:g} mm")
                for row in curve:
                    axes.annotate(f"{row['rate_hz']:g}", (cost_ms(row), row["error_share"]),
                                  textcoords="offset points", xytext=(4, 4), fontsize=7)
            axes.axhline(TOLERANCE, color="#D40000", linewidth=1, linestyle="--")
            if cheapest is not None and cheapest["model"] == model:
                axes.plot(cost_ms(cheapest), cheapest["error_share"], "*", color="#D40000",
                          markersize=15, zorder=5)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_title(f"{path}: {model}", fontsize=10, loc="left", fontweight="bold")
            axes.grid(color="0.94")
            axes.spines[["top", "right"]].set_visible(False)
            axes.set_xlabel("processor time a simulated second, both sides [ms]", fontsize=8.5)
        panels[line][0].set_ylabel("rms force error / rms force", fontsize=9)
        print_cheapest(path, mine, cheapest)
    panels[0][0].legend(title="sphere spacing", frameon=False, fontsize=8, title_fontsize=8)
    figure.suptitle("Spacing of the tissue's spheres and simulation rate (numbers, Hz) against 5 mm at "
                    "1 kHz; dashed 7 %", x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.96))
    return figure


def print_cheapest(path, rows, cheapest):
    if cheapest is None:
        best = min(rows, key=lambda row: row["error_share"])
        print(f"{path}: nothing within 7 %; least {best['error_share']:.1%}: {best['model']}, "
              f"{best['spacing_mm']:g} mm, {best['rate_hz']:g} Hz, {cost_ms(best):.3g} ms/s")
        return
    print(f"{path}: cheapest within 7 %: {cheapest['model']}, {cheapest['spacing_mm']:g} mm, "
          f"{cheapest['rate_hz']:g} Hz: {cheapest['error_share']:.1%}, {cost_ms(cheapest):.3g} ms/s")
    for model in dict.fromkeys(row["model"] for row in rows):
        mine = [row for row in rows if row["model"] == model]
        good = min((row for row in mine if row["error_share"] <= TOLERANCE), key=cost_ms,
                   default=None)
        least = min(mine, key=lambda row: row["error_share"])
        row = good or least
        print(f"  {model}: {'cheapest within' if good else 'none within; least'} "
              f"{row['spacing_mm']:g} mm, {row['rate_hz']:g} Hz: {row['error_share']:.1%}, "
              f"{cost_ms(row):.3g} ms/s")
    worse = [row for row in rows if row["error_share"] > TOLERANCE
             and cost_ms(row) < cost_ms(cheapest)]
    if worse:
        row = max(worse, key=cost_ms)
        print(f"  next cheaper, fails: {row['model']}, {row['spacing_mm']:g} mm, "
              f"{row['rate_hz']:g} Hz: {row['error_share']:.1%}, {cost_ms(row):.3g} ms/s")


FIGURES = (("hold", "Fig. 6: a discontinuity at each switch (hold)"),
           ("linear", "Figs. 7 and 8: a progressive transition, continuous if images are regular "
                      "(linear)"),
           ("answer", "Beside them: the simulation's next step, for the hand where it is (answer)"))


def draw_figures(rows):
    figure, panels = plt.subplots(len(FIGURES), 1, figsize=(11, 8), sharex=True, sharey=True)
    true = [row for row in rows if row["model"] == "reference"]
    for axes, (model, title) in zip(panels, FIGURES):
        mine = [row for row in rows if row["model"] == model]
        for before, row in zip(mine, mine[1:]):
            if row["image"] != before["image"]:
                axes.axvline(row["time_s"], color="0.75", linewidth=0.8, linestyle="--")
        axes.plot([row["time_s"] for row in true], [abs(row["force_N"]) for row in true], "k-",
                  linewidth=0.9, label="true state, 1 kHz")
        axes.plot([row["time_s"] for row in mine], [abs(row["force_N"]) for row in mine],
                  color=COLOURS[model], linewidth=1.6, label=model)
        axes.set_title(title, fontsize=10, loc="left", fontweight="bold")
        axes.set_ylabel("force [N]")
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8.5, loc="upper right")
    panels[-1].set_xlabel("time [s]; dashed lines: switches of images, 33 Hz with 30 % jitter, "
                          "a step costs a tenth")
    figure.suptitle("The paper's figures of continuity, from our own runs: a tool that goes with a "
                    "sphere at 0.1 m/s", x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    return figure


PRINTED = (("jump_max_N", "jump max N"), ("jump_p99_N", "p99 N"), ("jump_max_jnd", "max JND"),
           ("slew_p99_N_per_ms", "slew p99 N/ms"), ("stage_max_jnd", "stage max JND"),
           ("stage_felt_share", "felt share"), ("rms_error_N", "rms error N"),
           ("rms_error_at_lag_N", "at lag N"), ("lag_ms", "lag ms"), ("plateau_share", "plateau"),
           ("vibration_N2", "vibration N²"), ("energy_given_mJ", "energy mJ"),
           ("tick_median_us", "tick us"), ("stable_stiffness_N_m", "stable N/m"))


def short(value):
    if value == "":
        return "-"
    if value != 0 and abs(value) < 1e-9:
        value = 0.0
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.2g}"


def print_tables(rows, jitter):
    for path in dict.fromkeys(row["path"] for row in rows):
        mine = of(rows, path, jitter)
        print(f"\n**{path}** (rms of the true force {mine['reference']['force_rms_N']:.3g} N)\n")
        print("| model | " + " | ".join(title for _, title in PRINTED) + " |")
        print("|---" * (len(PRINTED) + 1) + "|")
        for model, row in mine.items():
            print(f"| {model} | " + " | ".join(short(row[key]) for key, _ in PRINTED) + " |")


def print_goals(rows):
    for path in dict.fromkeys(row["path"] for row in rows):
        mine = of(rows, path, 0.3)
        answer, hold, true = mine["answer"], mine["hold"], mine["reference"]
        print(f"{path}: jump {answer['jump_max_N'] / hold['jump_max_N']:.2g} of hold's; stages above "
              f"7 %: {answer['stage_felt_share']:.1%} of contact (true {true['stage_felt_share']:.1%},"
              f" hold {hold['stage_felt_share']:.1%}, linear {mine['linear']['stage_felt_share']:.1%}"
              f"); lag {answer['lag_ms']:.0f} ms of {answer['longest_period_ms']:.0f}; error "
              f"{answer['rms_error_N']:.3g} N (hold {hold['rms_error_N']:.3g}, linear "
              f"{mine['linear']['rms_error_N']:.3g}, 1 kHz {mine[FAST[-1]]['rms_error_N']:.3g})")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--charts", type=pathlib.Path, default=CHARTS, help="folder of CSV and PNG")
    parser.add_argument("--tables", action="store_true", help="print the tables too")
    arguments = parser.parse_args()
    charts = arguments.charts
    try:
        rows = read_rows(charts / "model_table.csv")
        draw_table(rows).savefig(charts / "model_table.png", dpi=90)
        draw_pareto(rows).savefig(charts / "model_pareto.png", dpi=85)
        draw_figures(read_rows(charts / "paper_figures.csv")).savefig(charts / "paper_figures.png",
                                                                     dpi=100)
        draw_spacing(read_rows(charts / "spacing_rate.csv")).savefig(charts / "spacing_rate.png",
                                                                     dpi=90)
        print_goals(rows)
        if arguments.tables:
            print_tables(rows, 0.3)
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"plot_models: {type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
