#!/usr/bin/python3
"""Draws docs/charts/engine_peers.png from the table that measure_engine.py writes."""
from drawing import draw_charts, label_logarithmic, plt
from tables import read_rows

COLOURS = {"ours": "#0072B2", "bullet": "#D55E00", "mujoco": "#009E73"}
NAMES = {"ours": "Stillgrid", "bullet": "Bullet 3.24", "mujoco": "MuJoCo 2.2.2"}
MARKS = {"400": "o", "4000": "s", "40000": "D", "": "o"}
PANELS = (("balls", "overlap_mm", "Piles of balls", "us per ball and 10 ms", "mean overlap in mm"),
          ("boxes", "overlap_mm", "Piles of boxes", "us per box and 10 ms", "mean overlap in mm"),
          ("chain", "error_mm", "A chain of 100 links", "us per 10 ms", "rms error after 0.5 s in mm"))


def draw_panel(axes, rows, error, title, label_y, label_x):
    for row in rows:
        engine, _, how = row["engine"].partition("_")
        if how == "two_threads":
            continue
        axes.plot(float(row[error]), float(row["us"]), MARKS[row["bodies"]], color=COLOURS[engine])
        axes.annotate(how.replace("_N_per_m", " N/m").replace("_", " "), (float(row[error]), float(row["us"])),
                      textcoords="offset points", xytext=(5, 3), fontsize=7, color="0.4")
    label_logarithmic(axes, title, label_x, label_y)
    axes.margins(0.2)


def draw(charts):
    rows = read_rows(charts / "engine_peers.csv")
    figure, panels = plt.subplots(1, 3, figsize=(13, 4.6))
    for axes, (scene, *words) in zip(panels, PANELS):
        draw_panel(axes, [row for row in rows if row["scene"] == scene], *words)
    for engine, name in NAMES.items():
        panels[0].plot([], [], "o", color=COLOURS[engine], label=name)
    for bodies in ("400", "4000", "40000"):
        panels[0].plot([], [], MARKS[bodies], color="0.5", label=f"{int(bodies):,} bodies")
    figure.tight_layout(rect=(0, 0.08, 1, 1), w_pad=2.0)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncol=6, frameon=False, fontsize=9)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"engine_peers": draw})
