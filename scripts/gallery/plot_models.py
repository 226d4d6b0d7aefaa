#!/usr/bin/python3
"""Draws docs/charts/{model_table,model_pareto,paper_figures}.png from the tables that measure_models.py
writes."""
import math

from drawing import draw_charts, matplotlib, plt, show_plain_numbers
import tables

TRANSITIONS = ("hold", "linear", "local")
RIVALS = ("force_held", "force_jacobian", "plane", "sphere", "proxy", "crossfade")
FAST = ("hold at 250 Hz", "hold at 500 Hz", "hold at 1000 Hz")
COLOURS = {"local": "#D55E00", "hold": "#0072B2", "linear": "#009E73"}
WHOLE = "tissue and blocks, all"
def read_rows(file):
    rows = tables.read_rows(file)
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


COLUMNS = (
    ("jump_max_N", "largest jump [N]", "log"),
    ("stage_felt_share", "time in stages\nabove 7 %", "linear"),
    ("error_share", "rms error, of the\nforce's rms", "log"),
    ("lag_ms", "effective latency [ms]", "linear"),
    ("vibration_N2", "vibration 20-500 Hz [N²]", "log"),
    ("tick_median_us", "tick, median [µs]", "log"),
    ("stable_stiffness_N_per_m", "stable stiffness [N/m]", "log"),
)
FLOOR = {"jump_max_N": 1e-5, "vibration_N2": 1e-7, "error_share": 1e-4}


def reference_rms_N(row, rows, path):
    """Of the true force: the run's own is what a late or wrong model made of it."""
    return of(rows, path, row["jitter"])["reference"]["force_rms_N"]


def draw_table(charts):
    rows = read_rows(charts / "model_table.csv")
    models = (*TRANSITIONS, *RIVALS, *FAST)
    paths = paths_of(rows)
    markers = dict(zip(paths, "osD^vP*X"))
    figure, panels = plt.subplots(1, len(COLUMNS), figsize=(15, 6.6), sharey=True)
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
        if key in FLOOR:
            axes.axvline(FLOOR[key], color="0.6", linewidth=0.8, linestyle=":")
    for path in paths:
        panels[0].plot([], [], markers[path], color="0.3", label=path)
    figure.suptitle("One path through all models: 33 Hz, a step costs a tenth, periods vary by 30 %",
                    x=0.01, ha="left", y=0.985,
                    fontsize=12, fontweight="bold")
    figure.text(0.01, 0.925, "Left edge (dotted): that or less. Error against the true state at 1 kHz; "
                "last three rows: held snapshots of a simulation that is that fast.", fontsize=9,
                color="0.3")
    figure.tight_layout(rect=(0, 0.05, 1, 0.92))
    figure.legend(loc="lower center", ncols=len(paths), frameon=False)
    return figure


def front(rows, x, y):
    """Those that no other beats in both."""
    best, chosen = math.inf, []
    for row in sorted(rows, key=lambda row: (row[x], row[y])):
        if row[y] < best:
            best = row[y]
            chosen.append(row)
    return chosen


# Of the Pareto charts: each model its own marker, for names would lie over each other.
MARKERS = {"hold": "o", "linear": "o", "local": "*", "force_held": "o", "force_jacobian": "s", "plane": "D",
           "sphere": "h", "proxy": "P", "crossfade": "X"}
FLOOR_N = 1e-6


def mark(axes, name, x, y, is_pale=False):
    axes.plot(x, max(y, FLOOR_N), MARKERS[name], color=colour_of(name), alpha=0.35 if is_pale else 1.0,
              markersize=13 if name == "local" else 7, markeredgewidth=0, clip_on=False)


def draw_pareto_panel(axes, mine):
    same = [mine[name] for name in MARKERS if name in mine]
    best = front(same, "tick_median_us", "rms_error_N")
    for row in same:
        mark(axes, row["model"], row["tick_median_us"], row["rms_error_N"], row not in best)
    axes.step([row["tick_median_us"] for row in best], [row["rms_error_N"] for row in best], "k-",
              where="post", linewidth=0.9, zorder=0)
    for name in FAST:
        axes.plot(mine[name]["tick_median_us"], mine[name]["rms_error_N"], "s", color="white", markersize=2)
        axes.text(mine[name]["tick_median_us"], mine[name]["rms_error_N"],
                  name.removeprefix("hold at ").removesuffix(" Hz"), ha="center", va="center",
                  fontsize=8.5, fontweight="bold", color="0.3")
    axes.set(xscale="log", yscale="log")
    show_plain_numbers(axes.xaxis)
    axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.set_xlabel("tick in contact, median [µs]")


def draw_jump_panel(axes, mine):
    for name in MARKERS:
        if name in mine:
            mark(axes, name, mine[name]["lag_ms"], mine[name]["jump_max_N"])
    axes.axhline(0.01 * mine["hold"]["jump_max_N"], color=COLOURS["hold"], linewidth=0.9,
                 linestyle="--")
    axes.axvline(mine["linear"]["longest_period_ms"], color="0.5", linewidth=0.9, linestyle=":")
    axes.set_yscale("log")
    axes.set_xlim(-3, None)
    axes.set_xlabel("effective latency [ms]")


def draw_pareto(charts):
    rows = read_rows(charts / "model_table.csv")
    paths = paths_of(rows)
    columns = min(3, len(paths))
    lines = -(-len(paths) // columns)
    figure, panels = plt.subplots(2 * lines, columns, figsize=(4.1 * columns, 6.4 * lines), squeeze=False)
    for first, draw, label in ((0, draw_pareto_panel, "force error, rms [N]"),
                               (lines, draw_jump_panel, "largest jump [N]")):
        for number, axes in enumerate(panels[first:first + lines].flat):
            if number >= len(paths):
                axes.axis("off")
                continue
            draw(axes, of(rows, paths[number], 0.3))
            axes.set_title(paths[number], fontsize=10.5, loc="left", fontweight="bold")
            axes.grid(color="0.94")
            axes.tick_params(which="both", labelsize=9)
            if number % columns == 0:
                axes.set_ylabel(label)
    handles = [plt.Line2D([], [], color=colour_of(name), marker=marker, linestyle="", markeredgewidth=0,
                          markersize=12 if name == "local" else 7) for name, marker in MARKERS.items()]
    handles += [plt.Line2D([], [], color=COLOURS["hold"], linestyle="--", linewidth=0.9),
                plt.Line2D([], [], color="0.5", linestyle=":", linewidth=0.9)]
    figure.suptitle("Speed against accuracy (above), and jump against lag (below)", x=0.01, y=0.99,
                    ha="left", fontsize=13, fontweight="bold")
    height_in = 6.4 * lines
    figure.text(0.01, 1.0 - 0.75 / height_in,
                "33 Hz, a step costs a tenth, jitter 30 %. Above: pale is beaten in both; numbers: held snapshots "
                "of a simulation\nat so many Hz. Below: at the bottom edge no jump.", color="0.3")
    figure.tight_layout(rect=(0, 0.9 / height_in, 1, 1.0 - 0.8 / height_in), h_pad=1.2)
    figure.legend(handles, [name.replace("_", " ") for name in MARKERS]
                  + ["1 % of hold's jump", "longest period"], loc="lower center", ncol=5, frameon=False)
    return figure


FIGURES = (("hold", "Fig. 6: a discontinuity at each switch (hold)"),
           ("linear", "Figs. 7 and 8: a progressive transition, continuous if snapshots are regular "
                      "(linear)"),
           ("local", "Beside them: the simulation itself, which goes on in each tick (local)"))


def draw_figures(charts):
    rows = read_rows(charts / "paper_figures.csv")
    figure, panels = plt.subplots(len(FIGURES), 1, figsize=(11, 8), sharex=True, sharey=True)
    true = [row for row in rows if row["model"] == "reference"]
    for axes, (model, title) in zip(panels, FIGURES):
        mine = [row for row in rows if row["model"] == model]
        for before, row in zip(mine, mine[1:]):
            if row["snapshot"] != before["snapshot"]:
                axes.axvline(row["time_s"], color="0.75", linewidth=0.8, linestyle="--")
        axes.plot([row["time_s"] for row in true], [abs(row["force_N"]) for row in true], "k-",
                  linewidth=0.9, label="true state, 1 kHz")
        axes.plot([row["time_s"] for row in mine], [abs(row["force_N"]) for row in mine],
                  color=COLOURS[model], linewidth=1.6, label=model)
        axes.set_title(title, fontsize=10, loc="left", fontweight="bold")
        axes.set_ylabel("force [N]")
        axes.legend(frameon=False, fontsize=8.5, loc="upper right")
    panels[-1].set_xlabel("time [s]; dashed lines: switches of snapshots, 33 Hz with 30 % jitter, "
                          "a step costs a tenth")
    figure.suptitle("The paper's figures of continuity, from our own runs: a tool that goes with a "
                    "sphere at 0.1 m/s", x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    return figure


PRINTED = ((("jump_max_N", "jump max N"), ("jump_p99_N", "p99 N"), ("jump_max_jnd", "max JND"),
            ("slew_p99_N_per_ms", "slew p99 N/ms"), ("stage_max_jnd", "stage max JND"),
            ("stage_felt_share", "felt share")),
           (("rms_error_N", "rms error N"), ("rms_error_at_lag_N", "at lag N"), ("lag_ms", "lag ms"),
            ("plateau_share", "plateau"), ("vibration_N2", "vibration N²"), ("energy_given_mJ", "energy mJ"),
            ("tick_median_us", "tick us"), ("stable_stiffness_N_per_m", "stable N/m")))


def short(value):
    if value == "":
        return "-"
    if value != 0 and abs(value) < 1e-9:
        value = 0.0
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.2g}"


def print_tables(rows, jitter):
    for path in paths_of(rows):
        mine = of(rows, path, jitter)
        print(f"\n### {path[0].upper() + path[1:]}\n")
        print(f"Rms of the true force: {mine['reference']['force_rms_N']:.3g} N.")
        for columns in PRINTED:
            print("\n| model | " + " | ".join(title for _, title in columns) + " |")
            print("|---" * (len(columns) + 1) + "|")
            for model, row in mine.items():
                print(f"| {model} | " + " | ".join(short(row[key]) for key, _ in columns) + " |")


def print_goals(rows):
    for path in dict.fromkeys(row["path"] for row in rows):
        mine = of(rows, path, 0.3)
        local, hold, true = mine["local"], mine["hold"], mine["reference"]
        print(f"{path}: jump {local['jump_max_N'] / hold['jump_max_N']:.2g} of hold's; stages above "
              f"7 %: {local['stage_felt_share']:.1%} of contact (true {true['stage_felt_share']:.1%},"
              f" hold {hold['stage_felt_share']:.1%}, linear {mine['linear']['stage_felt_share']:.1%}"
              f"); lag {local['lag_ms']:.0f} ms of {local['longest_period_ms']:.0f}; error "
              f"{local['rms_error_N']:.3g} N (hold {hold['rms_error_N']:.3g}, linear "
              f"{mine['linear']['rms_error_N']:.3g}, 1 kHz {mine[FAST[-1]]['rms_error_N']:.3g})")


def print_all(charts):
    """The figures of docs/algorithms/model_comparison.md."""
    rows = read_rows(charts / "model_table.csv")
    print_goals(rows)
    print_tables(rows, 0.3)


def main():
    charts, prints = draw_charts(__doc__, {"model_table": draw_table, "model_pareto": draw_pareto,
                                           "paper_figures": draw_figures},
                                 dpi=100, flag=("--tables", "print the tables of "
                                                "docs/algorithms/model_comparison.md too"))
    if prints:
        print_all(charts)


if __name__ == "__main__":
    main()
