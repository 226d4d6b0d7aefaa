#!/usr/bin/python3
"""Runs sphere_decompose over the meshes of others, which it needs: writes
docs/charts/decomposition_error.csv, a row a mesh and tolerance (spheres, both one-sided distances, time;
tolerances are shares of the diagonal of the mesh's box), and draws the spheres in place of the meshes,
decomposition_pictures.png. Spheres do not depend on a clock, times do.
"""
import json
import pathlib
import subprocess
import tempfile

import numpy

from drawing import save
from measuring import DATA, fail, parser_of
from sphere_pictures import draw_spheres, read_mesh
from tables import write_rows

MESHES = {  # name: file, metres in the file's unit
    "bunny": ("npm_bunny.off", 0.01),
    "spot": ("mujoco_spot.obj", 0.1),
    "liver": ("sofa_liver-smooth.obj", 0.04),
    "contour": ("ku_contour.stl", 0.001),
    "torus": ("sofa_torus.obj", 0.1),
}
SHARES = (0.08, 0.04, 0.02, 0.014)
SMALL_MESHES, SMALL_SHARES = ("spot", "contour", "torus"), SHARES[:2]
DISTANCES = ("hausdorff", "mesh_to_union", "union_to_mesh")


def decompose(program, mesh, scale, tolerance_m):
    """Its report, and its spheres: rows x, y, z, radius."""
    with tempfile.TemporaryDirectory() as folder:
        report, spheres = pathlib.Path(folder) / "report.json", pathlib.Path(folder) / "spheres.csv"
        subprocess.run([program, mesh, "--scale", str(scale), "--tolerance", repr(tolerance_m),
                        "--out", spheres, "--report", report],
                       check=True, stdout=subprocess.DEVNULL)
        return (json.loads(report.read_text()),
                numpy.loadtxt(spheres, delimiter=",", skiprows=1, ndmin=2))


def measure(program, name, shares):
    """Rows of a mesh, and its spheres as draw_spheres takes them."""
    file, scale = DATA / "meshes" / MESHES[name][0], MESHES[name][1]
    # A coarse run first, for the size of the box.
    whole_m = decompose(program, file, scale, 100.0 * scale)[0]["mesh"]["diagonal_m"]
    rows, levels = [], []
    for share in shares:
        report, spheres = decompose(program, file, scale, share * whole_m)
        level = report["levels"][0]
        rows.append({"mesh": name, "tolerance": share, "spheres": level["balls"],
                     **{key: f"{level[f'{key}_m'] / whole_m:.4g}" for key in DISTANCES},
                     "time_s": f"{report['time_s']:.3g}"})
        levels.append((share, spheres))
        print(*rows[-1].values(), sep=",", flush=True)
    return rows, (name, read_mesh(file, scale), levels)


def main():
    arguments = parser_of(__doc__, "three meshes of five, two tolerances of four").parse_args()
    if not (DATA / "meshes").is_dir():
        fail(f"{DATA / 'meshes'}: expected the real inputs there")
    program = arguments.build / "bin/sphere_decompose"
    rows, decomposed = [], []
    for name in SMALL_MESHES if arguments.small else MESHES:
        of_mesh, spheres = measure(program, name, SMALL_SHARES if arguments.small else SHARES)
        rows += of_mesh
        decomposed.append(spheres)
    write_rows(arguments.charts / "decomposition_error.csv", rows,
               ["sphere_decompose, one thread, on a shared machine; errors and tolerances as shares of the",
                "diagonal of the mesh's box, upper bounds; time is wall time."])
    save(draw_spheres(decomposed), arguments.charts / "decomposition_pictures.png", dpi=100)


if __name__ == "__main__":
    main()
