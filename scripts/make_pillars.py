#!/usr/bin/python3
"""Makes the scene `pillars`: a tissue with bricks on it, and round it a field of pillars and soft blocks.

The same file on every run: sim_server/scene/scenes/pillars.toml is what it writes.
"""
import argparse
import pathlib

# What one core sustains; measured by scripts/launch pillars --report-dir, of which sim.json tells.
RATE_HZ = 100.0

HEAD = """# Written by scripts/make_pillars.py. Shows a scene that needs two rates: a tissue of 24 x 24 nodes with
# bricks on it, and round it a field of pillars and soft blocks, which sleep until something falls on them.
#
# {count} moving spheres:
#   tissue        41 * 41
#   {bricks:4} bricks   3 * 3 * 2 each
#   {pillars:4} pillars  3 * 3 * 15 each
#   {soft:4} soft blocks, 6 * 6 * 6 each
# The floor is a plane: static, without spheres.
format = 2

[world]
gravity_m_s2 = [0.0, 0.0, -9.81]

[simulation]
rate_hz = {rate}

[tool]
radius_m = 0.01

# The device's origin is above the middle of the tissue, between four bricks.
[device]
position_m = [0.0, 0.0, 0.1]

[[material]]
name = "tissue"
contact_stiffness_N_per_m = 500.0
contact_damping_N_s_per_m = 2.0
friction = 0.4

[[material]]
name = "brick"
contact_stiffness_N_per_m = 1000.0
contact_damping_N_s_per_m = 2.0
friction = 0.5

[[body]]
name = "floor"
kind = "plane"
point_m = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
material = "brick"

[[body]]
name = "tissue"
kind = "sheet"
position_m = [0.0, 0.0, 0.08]
nodes = [24, 24]
size_m = [0.4, 0.4]
mass_kg = 2.0
spring_stiffness_N_per_m = {{ structural = 2000.0, shear = 1000.0, bend = 200.0 }}
spring_damping_N_s_per_m = 1.0
spheres = {{ spacing_m = 0.01, radius_m = 0.0065 }}
pinned = "edges"
material = "tissue"
"""
BRICK = """
[[body]]
name = "{kind}_{number}"
kind = "rigid_box"
position_m = [{x:.4f}, {y:.4f}, {z:.4f}]
size_m = [0.03, 0.03, {height}]
mass_kg = {height:g}
spheres = {{ spacing_m = 0.01, radius_m = 0.005 }}
material = "brick"
"""
SOFT = """
[[body]]
name = "soft_{number}"
kind = "soft_block"
position_m = [{x:.4f}, {y:.4f}, 0.0305]
size_m = [0.06, 0.06, 0.06]
nodes = [4, 4, 4]
mass_kg = 0.1
spring_stiffness_N_per_m = {{ structural = 300.0, shear = 150.0 }}
spring_damping_N_s_per_m = 0.5
spheres = {{ spacing_m = 0.01, radius_m = 0.006 }}
material = "tissue"
"""
PITCH_M, REACH, INNER_M = 0.09, 6, 0.25
SOFT_M = ((-0.3, -0.3), (0.3, -0.3), (-0.3, 0.3), (0.3, 0.3))
REST_M = 2e-5  # into the floor: about what weight presses


def pillars():
    """Places of pillars round the tissue, apart from the soft blocks."""
    for row in range(-REACH, REACH + 1):
        for column in range(-REACH, REACH + 1):
            x, y = PITCH_M * column, PITCH_M * row
            if max(abs(x), abs(y)) >= INNER_M and all(max(abs(x - a), abs(y - b)) >= 0.055 for a, b in SOFT_M):
                yield x, y


def bricks():
    """Places on the tissue, five by five; the hand comes where the middle one is not."""
    for row in range(-2, 3):
        for column in range(-2, 3):
            if (row, column) != (0, 0):
                yield 0.06 * column, 0.06 * row


def bodies(template, places, **same):
    return "".join(template.format(number=i, x=x, y=y, **same) for i, (x, y) in enumerate(places))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path, metavar="OUT.toml")
    on_tissue, on_floor = list(bricks()), list(pillars())
    count = 41 * 41 + 18 * len(on_tissue) + 135 * len(on_floor) + 216 * len(SOFT_M)
    text = HEAD.format(rate=RATE_HZ, count=f"{count:,}", bricks=len(on_tissue),
                       pillars=len(on_floor), soft=len(SOFT_M))
    text += bodies(SOFT, SOFT_M)
    text += bodies(BRICK, on_tissue, kind="brick", z=0.0965, height=0.02)
    text += bodies(BRICK, on_floor, kind="pillar", z=0.075 - REST_M, height=0.15)
    parser.parse_args().out.write_text(text)


if __name__ == "__main__":
    main()
