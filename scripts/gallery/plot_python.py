#!/usr/bin/python3
"""Draws docs/charts/python_pins.png from the tables that measure_python.py writes."""
from drawing import draw_charts, plt
from tables import read_rows

FELT, PUSHED, PIN, TOOL = "#0072B2", "#D55E00", "#B9C7D3", "#E69F00"


def draw(charts):
    cut, rows = read_rows(charts / "python_pins_cut.csv"), read_rows(charts / "python_pins.csv")
    figure, (bed, force) = plt.subplots(1, 2, figsize=(9.8, 3.6), width_ratios=(1, 1.5), constrained_layout=True)
    for row in cut:
        centre = 1e3 * float(row["x_m"]), 1e3 * float(row["z_m"])
        is_tool = row["what"] == "tool"
        bed.add_patch(plt.Circle(centre, 1e3 * float(row["radius_m"]), facecolor=TOOL if is_tool else PIN,
                                 edgecolor="white", zorder=2 if is_tool else 1))
    bed.set(xlim=(-62, 62), ylim=(-32, 32), aspect="equal", xlabel="x [mm]", ylabel="z [mm]")
    bed.set_title("a row of the bed under the tool, at 0.88 s", loc="left", fontsize=9.5)
    time_s = [float(row["time_s"]) for row in rows]
    force.step(time_s, [float(row["pushed_fz_N"]) for row in rows], where="post", color=PUSHED, linewidth=1.0,
               label="against the pins, told to the simulation at 50 Hz")
    force.plot(time_s, [float(row["felt_fz_N"]) for row in rows], color=FELT, linewidth=1.3,
               label="on the hand, at 1 kHz")
    force.set(xlabel="time [s]", ylabel="force along z [N]")
    force.set_ylim(top=1.25 * force.get_ylim()[1])
    force.legend(frameon=False, fontsize=8.5, loc="upper left")
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"python_pins": draw})
