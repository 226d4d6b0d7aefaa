#!/usr/bin/python3
"""Draws docs/charts/pile_steps.png from the table that measure_piles.py writes."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

STYLES = {  # engine: colour, line and marker
    "ours": ("#0072B2", "o-"),
    "ours, predicting": ("#56B4E9", "o--"),
    "ours, two threads": ("#009E73", "s-"),
    "Bullet": ("#888888", "^-"),
    "MuJoCo": ("#D55E00", "d-"),
}
STATES = {"awake": "awake: ten layers, fallen into a bin", "sleeping": "sleeping: one layer, lying"}


def draw(charts):
    rows = read_rows(charts / "pile_steps.csv")
    figure, panels = plt.subplots(1, 2, figsize=(10.5, 4.4), constrained_layout=True)
    for axes, (state, title) in zip(panels, STATES.items()):
        for engine, (colour, style) in STYLES.items():
            of = [row for row in rows if row["state"] == state and row["engine"] == engine]
            if not of:
                continue
            n = [int(row["spheres"]) for row in of]
            us = [1e-3 * float(row["ns"]) for row in of]
            axes.errorbar(n, us, yerr=[5e-4 * float(row["iqr_ns"]) for row in of], fmt=style,
                          color=colour, label=engine, markersize=5, capsize=2)
            if engine == "ours":
                for x, y in zip(n, us):
                    axes.annotate(f"{y:.2g}", (x, y), textcoords="offset points", xytext=(0, -13),
                                  ha="center", fontsize=8.5, color=colour)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(title, fontsize=10, loc="left")
        axes.set_xlabel("rigid spheres")
        axes.xaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda x, _: f"{x:,.0f}"))
        axes.grid(axis="y", color="0.93")
        axes.margins(y=0.15)
    panels[0].set_ylabel("time per sphere and step [µs]")
    panels[0].legend(frameon=False, fontsize=8.5)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"pile_steps": draw})
