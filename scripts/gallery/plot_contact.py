#!/usr/bin/python3
"""Draws docs/charts/ku_contact.png from the table that measure_printed.py writes."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

MODELS = {"spheres": ("#D55E00", "decomposition"),
          "even spheres": ("#E69F00", "even spheres under the surface"),
          "penetration volume": ("#009E73", "the same, by penetration volume"),
          "blobs": ("#0072B2", "blobs of the decomposition")}
PANELS = (("mean_cosine", "mean cosine with the measured force"),
          ("in_contact", "share of samples in contact"))


def draw_model(axes, rows, quantity, colour):
    """All demonstrations as dots, their mean as a line over the number of spheres."""
    counts = sorted({int(row["balls"]) for row in rows})
    values = {count: [float(row[quantity]) for row in rows if int(row["balls"]) == count]
              for count in counts}
    axes.plot(counts, [sum(values[count]) / len(values[count]) for count in counts], color=colour)
    for count in counts:
        axes.plot([count] * len(values[count]), values[count], "o", color=colour, markersize=4,
                  alpha=0.55, markeredgewidth=0)


def draw(charts):
    rows = read_rows(charts / "ku_contact.csv")
    figure, panels = plt.subplots(1, 2, figsize=(10.4, 4.4))
    for axes, (quantity, label) in zip(panels, PANELS):
        baseline = [float(row[quantity]) for row in rows if row["model"] == "nearest face"]
        axes.axhspan(min(baseline), max(baseline), color="0.9", zorder=0)
        for model, (colour, _) in MODELS.items():
            draw_model(axes, [row for row in rows if row["model"] == model], quantity, colour)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%d"))
        axes.set_xlabel("spheres")
        axes.set_ylabel(label)
        axes.set_ylim(top=1.01)
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
