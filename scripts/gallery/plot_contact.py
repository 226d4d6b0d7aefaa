#!/usr/bin/python3
"""Draws docs/charts/ku_contact.png from the table that measure_printed.py writes."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

MODELS = {"spheres": ("#D55E00", "decomposition"),
          "even spheres": ("#E69F00", "even spheres under the surface"),
          "penetration volume": ("#CC79A7", "their penetration volume"),
          "field": ("#009E73", "distance field")}
PANELS = (("mean_cosine", "mean cosine with the measured force"),
          ("in_contact", "share of samples in contact"),
          ("correlation", "correlation of its size with the measured one's"))


def draw_model(axes, rows, quantity, colour):
    """All demonstrations as dots, their mean as a line over the fineness."""
    sizes = sorted({float(row["step_mm"]) for row in rows})
    values = {size: [float(row[quantity]) for row in rows if float(row["step_mm"]) == size]
              for size in sizes}
    axes.plot(sizes, [sum(values[size]) / len(values[size]) for size in sizes], color=colour)
    for size in sizes:
        axes.plot([size] * len(values[size]), values[size], "o", color=colour, markersize=4,
                  alpha=0.55, markeredgewidth=0)


def draw(charts):
    rows = read_rows(charts / "ku_contact.csv")
    figure, panels = plt.subplots(1, 3, figsize=(14.0, 4.6))
    for axes, (quantity, label) in zip(panels, PANELS):
        baseline = [float(row[quantity]) for row in rows if row["model"] == "nearest face"]
        axes.axhspan(min(baseline), max(baseline), color="0.9", zorder=0)
        for model, (colour, _) in MODELS.items():
            draw_model(axes, [row for row in rows if row["model"] == model], quantity, colour)
        axes.set_xscale("log")
        axes.set_xlim(9.5, 0.85)
        axes.set_xticks((8, 4, 2, 1), ("8", "4", "2", "1"))
        axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
        axes.set_xlabel("tolerance, spacing or cell [mm]")
        axes.set_ylabel(label)
        axes.set_ylim(*((-1.01, 1.01) if quantity == "correlation" else (None, 1.01)))
    handles = [plt.Line2D([], [], color=colour, marker="o", markersize=4)
               for colour, _ in MODELS.values()]
    handles.append(plt.Rectangle((0, 0), 1, 1, color="0.9"))
    figure.legend(handles, [label for _, label in MODELS.values()] + ["normal of the nearest face"],
                  ncol=3,
                  frameon=False, loc="lower right", bbox_to_anchor=(0.99, 0.0))
    figure.suptitle("Recorded contact with a contour: eight demonstrations (dots) and their mean",
                    x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0.1, 1, 1), w_pad=3.0)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"ku_contact": draw})
