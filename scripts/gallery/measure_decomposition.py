#!/usr/bin/python3
"""Runs sphere_decompose over the meshes of others and writes docs/charts/decomposition_error.csv.

A row a mesh and tolerance: spheres, both one-sided distances, time. Tolerances are shares of the
diagonal of the mesh's box. The spheres go to --spheres, for plot_decomposition.py.
"""
import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

MESHES = {  # name: file, metres in the file's unit
    "bunny": ("npm_bunny.off", 0.01),
    "spot": ("mujoco_spot.obj", 0.1),
    "liver": ("sofa_liver-smooth.obj", 0.04),
    "contour": ("ku_contour.stl", 0.001),
    "torus": ("sofa_torus.obj", 0.1),
}
SHARES = [0.08, 0.04, 0.02, 0.014]


def diagonal_m(report):
    return report["mesh"]["diagonal_m"]


def decompose(program, mesh, scale, tolerance_m, spheres):
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.json"
        subprocess.run([program, mesh, "--scale", str(scale), "--tolerance", repr(tolerance_m),
                        "--out", spheres, "--report", report],
                       check=True, stdout=subprocess.DEVNULL)
        return json.loads(report.read_text())


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    data = pathlib.Path(os.environ.get("STILLGRID_DATA", root.parent / "shared" / "data"))
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=root / "build/release/bin/sphere_decompose",
                        help="default: %(default)s")
    parser.add_argument("--meshes", default=data / "meshes", type=pathlib.Path,
                        help="default: %(default)s")
    parser.add_argument("--spheres", required=True, type=pathlib.Path, metavar="FOLDER",
                        help="write the spheres there, MESH_SHARE.csv")
    parser.add_argument("--out", default=root / "docs/charts/decomposition_error.csv",
                        metavar="FILE.csv", help="default: %(default)s")
    arguments = parser.parse_args()
    if not arguments.meshes.is_dir():
        sys.exit(f"measure_decomposition: {arguments.meshes}: no such folder")
    arguments.spheres.mkdir(parents=True, exist_ok=True)
    rows = []
    for name, (file, scale) in MESHES.items():
        mesh = arguments.meshes / file
        # A coarse run first, for the size of the box.
        scratch = arguments.spheres / "scratch.csv"
        whole_m = diagonal_m(decompose(arguments.program, mesh, scale, 100.0 * scale, scratch))
        scratch.unlink()
        for share in SHARES:
            spheres = arguments.spheres / f"{name}_{share}.csv"
            report = decompose(arguments.program, mesh, scale, share * whole_m, spheres)
            level = report["levels"][0]
            rows.append([name, share, level["balls"]] +
                        [f"{level[key] / whole_m:.4g}" for key in
                         ("hausdorff_m", "mesh_to_union_m", "union_to_mesh_m")] +
                        [f"{report['time_s']:.3g}"])
            print(*rows[-1], sep=",", flush=True)
    with open(arguments.out, "w", newline="") as stream:
        stream.write("# sphere_decompose, one thread, on a shared machine; errors and tolerances as "
                     "shares of the\n# diagonal of the mesh's box, upper bounds; time is wall time.\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["mesh", "tolerance", "spheres", "hausdorff", "mesh_to_union",
                         "union_to_mesh", "time_s"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
