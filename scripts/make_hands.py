#!/usr/bin/python3
"""Makes the hands of the scenes that ship: where a user's hand goes in each, for 2 s, in the device's frame; of
scenes with two hands where each goes, for 10 s.

A scene names its own in [hand]: for it scene_fit fits, and `sim_server --try` judges. The same files on every run: sim_server/scene/scenes/*.hand.csv and those that end in a hand's
name are what this writes.
"""
import argparse
import math
import pathlib

SECONDS, ROWS_PER_S = 2.0, 200
PIVOT_Z_M = -0.11  # of the laparoscopy's trocar


def ease(t, start, end):
    """From 0 to 1 without a kink."""
    s = min(max((t - start) / (end - start), 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


def press_tissue(t):
    """Comes down between the blocks in 0.4 s, presses twice a second, stroking in a circle of 4 mm."""
    depth_m = 0.024 + 0.004 * math.sin(4.0 * math.pi * t)
    return 0.004 * math.cos(math.pi * t), 0.004 * math.sin(math.pi * t), 0.02 - ease(t, 0.0, 0.4) * (0.02 + depth_m)


def sweep_threads(t):
    """Along the fixed ends of a row of threads and back, once in 2 s, up and down between the first two spheres."""
    return (0.03 * math.sin(math.pi * t), -0.01 * ease(t, 0.0, 0.2) + 0.003 * math.sin(2.0 * math.pi * t),
            0.042 + 0.002 * math.sin(2.6 * math.pi * t))


def press_organ(t):
    """Presses the soft organ in its middle once a second, moving by 6 mm."""
    depth_m = 0.034 + 0.003 * math.sin(2.0 * math.pi * t)
    return 0.006 * math.sin(math.pi * t), 0.004 * math.cos(math.pi * t), -ease(t, 0.0, 0.4) * depth_m


def stroke_laparoscopy(t):
    """Lowers the instrument into the organ in 0.4 s and strokes across it nearly once a second."""
    return (0.008 * math.sin(1.8 * math.pi * t), 0.003 * math.sin(2.0 * math.pi * t),
            0.02 - ease(t, 0.0, 0.4) * (0.026 + 0.003 * math.sin(3.0 * math.pi * t)))


def push_chain(t):
    """Comes from the side, pushes the hanging links 15 mm out and lets them swing back, once in 2 s."""
    return -0.02 + 0.025 * (ease(t, 0.2, 0.8) - ease(t, 1.2, 1.4)), 0.001 * t, 0.0


def push_ball(t):
    """Pushes the hanging ball 15 mm to the side and back, going round by 2 mm, once in 2 s."""
    return (-0.022 + 0.024 * (ease(t, 0.2, 0.8) - ease(t, 1.2, 1.8)), 0.002 * math.sin(2.0 * math.pi * t),
            0.002 - 0.002 * math.cos(2.0 * math.pi * t))


def meet_sphere(t):
    """Stays where the sphere comes to."""
    return 0.0, 0.0, 0.001 * t


def tap_wall(t):
    """Taps the wall twice a second, 3 mm deep."""
    return 0.001 * t, 0.0, 0.005 + 0.003 * math.cos(4.0 * math.pi * t)


def pinch_block(t, side):
    """side: -1 left, 1 right. Pinches the block, lifts it by 25 mm, carries it along y and back, sets it down."""
    inward_m = 0.0433 * (ease(t, 0.3, 1.3) - ease(t, 8.2, 9.2))
    return (-side * inward_m, 0.015 * (ease(t, 3.0, 4.0) - ease(t, 5.5, 6.5)),
            0.025 * (ease(t, 1.6, 2.6) - ease(t, 7.0, 8.0)))


def hold_cloth(t, side):
    """Comes from behind the hanging cloth, holds it out and up, carries it along x and back, drops away below it."""
    out = ease(t, 0.5, 2.5)
    return (0.015 * (ease(t, 3.0, 4.0) - ease(t, 5.5, 6.5)), 0.045 - 0.09 * out,
            0.02 + 0.03 * out - 0.105 * ease(t, 7.0, 8.5))


HANDS = {"tissue_and_blocks": press_tissue, "threads": sweep_threads, "organ": press_organ,
         "laparoscopy": stroke_laparoscopy, "moving_sphere": meet_sphere, "wall": tap_wall,
         "pendulum_chain": push_chain, "sewn_ball": push_ball}

PAIRS = {"block_pinched": pinch_block, "cloth_held_by_two": hold_cloth}
PAIR_SECONDS, PAIR_ROWS_PER_S = 10.0, 50


def turned_to_pivot(position_m):
    """The orientation that takes a shaft along -z the short way through the trocar: qx, qy, qz, qw."""
    x, y, z = (-coordinate for coordinate in position_m)
    z += PIVOT_Z_M
    length = math.hypot(x, y, z)
    q = (y / length, -x / length, 0.0, 1.0 - z / length)  # of -z and the shaft: cross product, 1 + dot product
    norm = math.hypot(*q)
    return tuple(part / norm for part in q)


def rows_of(path, seconds, rows_per_s, turns=False):
    """A hand as CSV."""
    rows = ["time_s,x_m,y_m,z_m" + (",qx,qy,qz,qw" if turns else "")]
    for i in range(int(rows_per_s * seconds) + 1):
        position_m = path(i / rows_per_s)
        values = (*position_m, *(turned_to_pivot(position_m) if turns else ()))
        rows.append(f"{i / rows_per_s:g}," + ",".join(f"{round(value, 7) + 0.0:g}" for value in values))
    return "\n".join(rows) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    shipped = pathlib.Path(__file__).resolve().parents[1] / "sim_server/scene/scenes"
    parser.add_argument("folder", type=pathlib.Path, nargs="?", default=shipped, help="default: where they ship")
    folder = parser.parse_args().folder
    for scene, path in HANDS.items():
        (folder / f"{scene}.hand.csv").write_text(rows_of(path, SECONDS, ROWS_PER_S, scene == "laparoscopy"))
    for scene, path in PAIRS.items():
        for name, side in ("left", -1), ("right", 1):
            text = rows_of(lambda t: path(t, side), PAIR_SECONDS, PAIR_ROWS_PER_S)
            (folder / f"{scene}.{name}.csv").write_text(text)


if __name__ == "__main__":
    main()
