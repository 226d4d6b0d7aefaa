"""fit.png: what each run of a fit costs and how far it errs."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from report import JUST_NOTICEABLE

LEAST_ERROR = 1e-3  # what errs less is drawn there
STAGES = (("rates and transitions", "rate and transition", "#0072B2"),
          ("other displays", "transition", "#56B4E9"),
          ("levels of detail", "level of detail", "#D55E00"), ("methods", "integrator", "#009E73"),
          ("voxel sizes", "voxel size", "#CC79A7"), ("round", "around the best", "0.35"))
UNUSABLE = "#999999"


def points_of(rows):
    return [row for row in rows if row["cost_us_per_ms"] and row["error_share"] is not None]


def front(rows):
    """Those that no other beats in both."""
    least, chosen = float("inf"), []
    for row in sorted(rows, key=lambda row: (row["cost_us_per_ms"], row["error_share"])):
        if row["error_share"] < least:
            least = row["error_share"]
            chosen.append(row)
    return chosen


def place(row):
    return row["cost_us_per_ms"], max(100 * row["error_share"], 100 * LEAST_ERROR)


def is_dead(row):
    """Useless whatever it costs or errs."""
    return row["stable"] is False or any(word in row["verdict"] for word in ("cannot keep", "unstable"))


def draw_runs(axes, rows):
    for stage, label, colour in STAGES:
        mine = [place(row) for row in rows if row["stage"].startswith(stage) and not is_dead(row)]
        if mine:
            axes.plot(*zip(*mine), "o", color=colour, markersize=4.5, alpha=0.7, markeredgewidth=0, label=label)
    dead = [place(row) for row in rows if is_dead(row)]
    if dead:
        axes.plot(*zip(*dead), "x", color=UNUSABLE, markersize=5.5, label="unstable, or cannot keep its rate")
    best = [place(row) for row in front([row for row in rows if not is_dead(row)])]
    axes.plot(*zip(*best), "-", color="0.2", linewidth=0.9, drawstyle="steps-post", label="Pareto front", zorder=1)


def label(axes, row, text, colour, offset):
    x, y = place(row)
    axes.plot(x, y, "o", markersize=12, markerfacecolor="none", markeredgecolor=colour, markeredgewidth=2)
    axes.annotate(text, (x, y), textcoords="offset points", xytext=offset, fontsize=9, color=colour,
                  fontweight="bold", ha="center", arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.7})


def draw_panel(axes, fit):
    """One fit; rows of runs in fit["runs"]."""
    rows = points_of(fit["runs"])
    draw_runs(axes, rows)
    tolerance = 100 * fit["force_error"]
    axes.axhline(tolerance, color="#B00020", linewidth=1.2)
    axes.axhline(100 * JUST_NOTICEABLE, color="0.5", linewidth=1.0, linestyle="--")
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
    right = axes.get_yaxis_transform()
    axes.text(0.99, tolerance, f"tolerance {tolerance:.3g} %", transform=right, ha="right", va="top", fontsize=8.5,
              color="#B00020")
    axes.text(0.99, 100 * JUST_NOTICEABLE, "just noticeable 7 %", transform=right, ha="right", va="bottom",
              fontsize=8.5, color="0.4")
    if fit["budget_us"]:
        axes.axvline(fit["budget_us"], color="#B00020", linewidth=1.0, linestyle=":", label="budget")
    for row, text, colour, offset in ((fit["given"], "as given", "0.1", (26, 26)),
                                      (fit["choice"], "choice", "#B00020", (-22, -30))):
        if row in points_of([row]):
            label(axes, row, text, colour, offset)
    axes.margins(0.08)
    axes.set_xlabel("processor time of both sides [µs per ms simulated]")
    axes.set_ylabel("rms error of the force [% of its rms]")
    axes.grid(color="0.92", which="both", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def draw(fit, file):
    figure, axes = plt.subplots(figsize=(9.5, 6.2))
    draw_panel(axes, fit)
    axes.set_title(f"{fit['scene']}: {fit['choice']['description']}", fontsize=10,
                   loc="left")
    axes.legend(fontsize=8.5, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.tight_layout()
    part = file.with_name(file.stem + ".part.png")
    figure.savefig(part, dpi=120, facecolor="white")
    part.replace(file)
