#!/usr/bin/python3
"""Draws docs/charts/mujoco_ball.png and bullet_pile.png from the tables that measure_engines.py writes."""
from drawing import draw_charts, plt
from tables import read_rows

OURS, THEIRS, DIFFERENCE = "#0072B2", "#D55E00", "0.4"


def columns(file):
    rows = read_rows(file)
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def ball(charts):
    felt, killed = columns(charts / "mujoco_ball.csv"), columns(charts / "mujoco_killed.csv")
    figure, (both, alone) = plt.subplots(2, 1, figsize=(9, 5.2), constrained_layout=True)
    both.plot(felt["time_s"], felt["sim_server_N"], color=OURS, label="sim_server", linewidth=1.4)
    both.plot(felt["time_s"], felt["mujoco_N"], "--", color=THEIRS, label="MuJoCo", linewidth=1.2)
    both.plot(felt["time_s"], [b - a for a, b in zip(felt["sim_server_N"], felt["mujoco_N"])], color=DIFFERENCE,
              label="difference", linewidth=0.8)
    both.set_title("A ball on a floor, 30 states a second, the same hand", loc="left")
    alone.plot(killed["time_s"], killed["force_N"], color=THEIRS, linewidth=1.4)
    alone.set_title("MuJoCo killed at about 1.5 s and started again half a second later", loc="left")
    alone.set_xlabel("time [s]")
    for axes in (both, alone):
        axes.set_ylabel("force on the hand [N]")
    both.legend(frameon=False)
    return figure


def pile(charts):
    felt = columns(charts / "bullet_pile.csv")
    figure, axes = plt.subplots(figsize=(9, 3.2), constrained_layout=True)
    for axis, colour in zip("xyz", (THEIRS, DIFFERENCE, OURS)):
        axes.plot(felt["time_s"], felt[f"f{axis}_N"], color=colour, linewidth=1, label=axis)
    axes.set(xlabel="time [s]", ylabel="force on the hand [N]")
    axes.legend(frameon=False)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"mujoco_ball": ball, "bullet_pile": pile})
