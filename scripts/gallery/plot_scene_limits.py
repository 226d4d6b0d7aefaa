#!/usr/bin/python3
"""Draws docs/charts/scene_limits.png from the table that measure_scene_limits.py writes."""
from drawing import draw_charts, plt
from tables import read_rows

SCENES = (("bodies", "each sphere a body", "#000000", "o"), ("box at rest", "a rigid box", "#0072B2", "s"),
          ("box at 2 m/s", "the same at 2 m/s", "#D55E00", "^"), ("sheet", "a sheet", "#009E73", "v"))
PANELS = (("processor_s", "load and first step [s]"), ("memory_MB", "most memory held [MB]"))


def draw(charts):
    rows = read_rows(charts / "scene_limits.csv")
    figure, panels = plt.subplots(1, 2, figsize=(10.0, 3.9), constrained_layout=True)
    for axes, (column, label) in zip(panels, PANELS):
        for scene, name, colour, marker in SCENES:
            of_scene = [row for row in rows if row["scene"] == scene]
            axes.plot([float(row["spheres"]) for row in of_scene],
                      [float(row[column]) for row in of_scene], marker=marker, color=colour,
                      label=name, linewidth=1.4, markersize=5)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("spheres")
        axes.set_ylabel(label)
        axes.grid(True, which="major", color="0.92")
    panels[0].legend(frameon=False, fontsize=9, loc="upper left")
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"scene_limits": draw})
