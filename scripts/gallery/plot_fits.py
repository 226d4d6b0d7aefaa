#!/usr/bin/python3
"""Draws docs/charts/fits.png from fits.csv, which measure_fits.py writes: what each run of each fit costs and errs."""
import pathlib
import sys

from drawing import draw_charts, plt
from tables import read_rows

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "fit"))
import picture  # after the path it needs

FLAGS = {"True": True, "False": False, "": None}


def number(text):
    try:
        return float(text)
    except ValueError:
        return FLAGS.get(text, text)


def fits_of(rows):
    """As picture draws them, by scene."""
    fits = {}
    for row in ({key: number(value) for key, value in row.items()} for row in rows):
        fit = fits.setdefault(row["scene"], {"runs": [], "force_error": row["force_error"], "budget_us": None,
                                             "choice": None})
        fit["runs"].append(row)
        for role in ("given", "choice"):
            if role in str(row["role"]):
                fit[role] = row
    return fits


def draw(charts):
    fits = fits_of(read_rows(charts / "fits.csv"))
    columns = min(len(fits), 2)
    rows = -(-len(fits) // columns)
    figure, panels = plt.subplots(rows, columns, figsize=(1.0 + 5.2 * columns, 0.8 + 4.8 * rows), squeeze=False)
    for axes, (scene, fit) in zip(panels.flat, fits.items()):
        picture.draw_panel(axes, fit)
        axes.set_title(scene.replace("_", " "), loc="left", fontsize=11, fontweight="bold")
    for axes in panels.flat[len(fits):]:
        axes.remove()
    for axes in panels[:, 1:].flat:
        axes.set_ylabel("")
    shown = {label: handle for axes in panels.flat[:len(fits)]
             for handle, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(shown.values(), shown.keys(), loc="lower center", ncols=4, frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.08 / rows + 0.01, 1, 1))
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"fits": draw}, dpi=120)
