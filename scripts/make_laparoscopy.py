#!/usr/bin/python3
"""Writes the scene `laparoscopy` with another organ: any closed mesh in an OBJ file, such as a liver.

  scripts/make_laparoscopy.py liver.obj build/liver.toml
  scripts/launch build/liver.toml --device phantom:profile=premium15,pivot_x_m=0,pivot_y_m=0,pivot_z_m=-0.11

The mesh is scaled to lie on the floor under the trocar, at most 90 mm long and 50 mm high; spheres,
lattice, mass and what is pinned go by its size. All else is the scene that ships. Exit status: 0
written, 1 bad input, one line.
"""
import argparse
import pathlib
import re
import sys

MOST_LENGTH_M, MOST_HEIGHT_M = 0.09, 0.05
DENSITY_KG_M3 = 500.0  # of the box round it
SHIPPED = pathlib.Path(__file__).resolve().parents[1] / "sim_server/scene/scenes/laparoscopy.toml"

ORGAN = """[[body]]
name = "organ"
kind = "mesh"
file = "{file}"
scale = {scale:.6g}
position_m = [{x:.5f}, {y:.5f}, {z:.5f}]
mass_kg = {mass:.3f}
spheres = {{ surface_spacing_m = {spacing:.4f} }}
lattice_m = {lattice:.4f}
spring_stiffness_N_per_m = {{ structural = 80.0, shear = 40.0, bend = 10.0 }}
spring_damping_N_s_per_m = 0.2
pinned = {{ low_m = [-1.0, -1.0, -1.0], high_m = [1.0, 1.0, {pinned:.4f}] }}
material = "organ"

"""


def box_of(mesh):
    """Lowest and highest x, y and z of the vertices."""
    try:
        lines = mesh.read_text(errors="replace").splitlines()
    except OSError as error:
        raise ValueError(f"{mesh}: {error.strerror}: expected an OBJ file") from None
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.startswith("v ")]
    if not rows:
        raise ValueError(f"{mesh}: no line begins with 'v ': expected an OBJ file")
    points = []
    for number, line in rows:
        try:
            x, y, z = map(float, line.split()[1:4])
        except ValueError:
            raise ValueError(f"{mesh}:{number}: value '{line}': expected v x y z") from None
        points.append((x, y, z))
    low, high = ([extreme(axis) for axis in zip(*points)] for extreme in (min, max))
    if not all(0.0 < b - a < float("inf") for a, b in zip(low, high)):
        raise ValueError(f"{mesh}: its box is {low} to {high}: expected a solid")
    return low, high


def organ_of(mesh):
    low, high = box_of(mesh)
    size = [b - a for a, b in zip(low, high)]
    scale = min(MOST_LENGTH_M / max(size), MOST_HEIGHT_M / size[2])
    size_m = [scale * length for length in size]
    longest_m = max(size_m)
    return ORGAN.format(file=mesh.resolve(), scale=scale, x=-0.5 * scale * (low[0] + high[0]),
                        y=-0.5 * scale * (low[1] + high[1]), z=-scale * low[2],
                        mass=DENSITY_KG_M3 * size_m[0] * size_m[1] * size_m[2],
                        spacing=longest_m / 15.0, lattice=longest_m / 6.0, pinned=0.17 * size_m[2])


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=pathlib.Path, metavar="MESH.obj", help="z up, any unit")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT.toml")
    arguments = parser.parse_args()
    try:
        scene = re.sub(r'\[\[body\]\]\nname = "organ"\n.*?(?=\[\[body\]\])',
                       lambda _: organ_of(arguments.mesh), SHIPPED.read_text(), flags=re.DOTALL)
        scene = re.sub(r"(?:#.*\n)+", f"# Written by scripts/make_laparoscopy.py: `laparoscopy` with "
                       f"{arguments.mesh.name}.\n", scene, count=1)
        part = arguments.out.with_name(arguments.out.name + ".part")
        part.write_text(scene)
        part.replace(arguments.out)
    except (OSError, ValueError) as error:
        sys.exit(f"make_laparoscopy: {error}")


if __name__ == "__main__":
    main()
