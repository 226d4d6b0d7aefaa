#!/usr/bin/python3
"""Draws the axes in which the drivers of devices that people own give positions and take forces.

The user sits below, the device stands above; right, away and up are the user's.
"""
from drawing import draw_charts, plt

# The user's directions, seen obliquely from behind the right shoulder.
RIGHT, AWAY, UP = (1.0, -0.12), (0.5, 0.62), (0.0, 1.0)


def against(direction):
    return (-direction[0], -direction[1])


# A driver's axes x, y, z and the words on them.
DEVICES = {
    "openhaptics\nTouch, Omni, Premium": ((RIGHT, "x right"), (UP, "y up"), (against(AWAY), "z to the user")),
    "force_dimension\nomega, delta, sigma, Falcon": (
        (against(AWAY), "x depth, to the user"), (RIGHT, "y across"), (UP, "z up")),
    "haply\nInverse3": ((RIGHT, "x right"), (AWAY, "y away"), (UP, "z up")),
}
COLOURS = ("#c1272d", "#2e7d32", "#1f5fa8")


def draw_device(axes, name, directions):
    axes.set_title(name, fontsize=9.5)
    for (direction, words), colour in zip(directions, COLOURS):
        axes.annotate("", direction, (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2})
        axes.text(1.16 * direction[0], 1.16 * direction[1], words, color=colour,
                  ha="left" if direction is RIGHT else "center", va="center")
    axes.text(0.0, -1.35, "you", ha="center", color="#666666")
    axes.plot([0.0], [-1.12], marker="^", color="#666666")
    axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.35), aspect="equal")
    axes.axis("off")


def axes_of_devices(_folder):
    figure, panels = plt.subplots(1, 3, figsize=(10.5, 4.2))
    for axes, (name, directions) in zip(panels, DEVICES.items()):
        draw_device(axes, name, directions)
    figure.tight_layout()
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"axes": axes_of_devices})
