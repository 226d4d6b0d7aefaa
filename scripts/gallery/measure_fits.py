#!/usr/bin/python3
"""Fits four scenes with scripts/scene_fit: docs/charts/fits.csv, and prints the table of docs/scene_fit.md.

One, bunny_on_sheet, needs a mesh of the folder of real inputs, and is left out where that is not there. Each is fitted to one hand and tried on another that the fit did not see. A row is a run; its role says which is the
scene as given and which is the choice. What it has done it keeps (--keep), so that it may be stopped.
"""
import json
import math
import pathlib
import shutil
import subprocess
import sys

from measuring import DATA, ROOT, fail, output_of, parser_of
from tables import write_rows

sys.path.append(str(ROOT / "scripts"))
from make_hands import ease, press_organ, press_tissue, rows_of, sweep_threads  # after the path it needs


def stroke_tissue(t):
    """Comes down somewhat slower, and strokes a line of 12 mm back and forth."""
    depth_m = 0.025 + 0.002 * math.sin(2.0 * math.pi * 1.3 * t)
    return 0.0, 0.006 * math.sin(2.0 * math.pi * 0.8 * t), 0.02 - ease(t, 0.0, 0.5) * (0.02 + depth_m)


def cross_threads(t):
    """Slower, and from one row to the other."""
    return (0.03 * math.sin(0.8 * math.pi * t + 0.4), 0.01 * math.sin(0.7 * math.pi * t + 1.9),
            0.0425 + 0.0015 * math.sin(2.0 * math.pi * t))


def stroke_organ(t):
    """Strokes across it, twice a second."""
    depth_m = 0.034 + 0.002 * math.sin(2.0 * math.pi * 0.7 * t)
    return (0.003 * math.sin(2.0 * math.pi * 0.5 * t), 0.008 * math.sin(2.0 * math.pi * 0.9 * t),
            -ease(t, 0.0, 0.3) * depth_m)


def press_bunny(t):
    """Presses the bunny's back once a second, in a circle of 2 mm."""
    depth_m = 0.026 + 0.003 * math.sin(2.0 * math.pi * t)
    return 0.002 * math.cos(math.pi * t), 0.002 * math.sin(math.pi * t), -ease(t, 0.0, 0.4) * depth_m


def stroke_bunny(t):
    """Strokes it from the middle of the back to the tail and back, nearly once a second."""
    depth_m = 0.025 + 0.002 * math.sin(2.0 * math.pi * 0.7 * t)
    return 0.006 + 0.006 * math.sin(2.0 * math.pi * 0.9 * t), 0.0, -ease(t, 0.0, 0.3) * depth_m


# Scene, hand, unseen hand, seconds that it settles before.
FITS = [("tissue_and_blocks", press_tissue, stroke_tissue, 4.0), ("threads", sweep_threads, cross_threads, 0.0),
        ("organ", press_organ, stroke_organ, 1.0), ("bunny_on_sheet", press_bunny, stroke_bunny, 2.5)]
BUNNY = DATA / "meshes/npm_bunny.off"
SECONDS = 2.0


def write_path(path, seconds, file):
    file.write_text(rows_of(path, seconds, 1000))
    return file


def scene_of(build, keep, scene):
    """As scene_fit takes it: the name of one that ships, or the file of the bunny's, written with all that it reads."""
    if scene != "bunny_on_sheet":
        return scene
    shutil.copyfile(BUNNY, keep / BUNNY.name)
    output_of([build / "bin/sphere_decompose", BUNNY, "--scale", "0.006", "--tolerance", "0.0015",
               "--out", keep / "bunny.csv"])
    return shutil.copyfile(pathlib.Path(__file__).with_name(f"{scene}.toml"), keep / f"{scene}.toml")


def fit(build, keep, scene, hand, unseen, settle_s, small):
    seconds = 1.0 if small else SECONDS
    command = [sys.executable, ROOT / "scripts/scene_fit", scene_of(build, keep, scene), "--build", build, "--out", keep / scene,
               "--trajectory", write_path(hand, seconds, keep / f"{hand.__name__}.csv"),
               "--check", write_path(unseen, seconds, keep / f"{unseen.__name__}.csv"),
               "--settle", str(settle_s), "--grid", "small" if small else "full"]
    done = subprocess.run(list(map(str, command)), check=False)
    if done.returncode not in (0, 1):  # 1: nothing fits, and that is a result too
        fail(f"scene_fit {scene}: exit status {done.returncode}")
    return json.loads((keep / scene / "fit.json").read_text())


def table_of(fits):
    lines = ["| scene | | us per ms | error | JND | largest margin | unseen hand: error |",
             "|---|---|---|---|---|---|---|"]
    methods = [""]
    for one in fits:
        for role, key in (("as given", "given"), ("fitted", "choice")):
            row, check = one[key], one["check"][key]
            margin = "-" if row["largest_margin"] is None else f"{row['largest_margin']:.3g}"
            lines.append(f"| {one['scene']} | {role} | {row['cost_us_per_ms']:.3g} | "
                         f"{100 * row['error_share']:.3g} % | {row['jnd']:.2f} | {margin} | "
                         f"{100 * check['error_share']:.3g} % |")
            methods.append(f"* {one['scene']}, {role}: {row['description']}")
    return "\n".join(lines + methods)


def main():
    parser = parser_of(__doc__, "threads only, a second, scene_fit --grid small")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER",
                        help="where fits are made and taken up again; default: build/fits")
    parser.add_argument("--only", metavar="SCENE", help="one of the scenes")
    arguments = parser.parse_args()
    keep = arguments.keep or ROOT / "build" / ("fits_small" if arguments.small else "fits")
    keep.mkdir(parents=True, exist_ok=True)
    chosen = [one for one in FITS if (one[0] == "threads" if arguments.small else arguments.only in (None, one[0]))]
    if not BUNNY.exists() and any(one[0] == "bunny_on_sheet" for one in chosen):
        print(f"skipped: bunny_on_sheet: {BUNNY} is absent", file=sys.stderr)
        chosen = [one for one in chosen if one[0] != "bunny_on_sheet"]
    if not chosen:
        return
    fits = [fit(arguments.build, keep, *one, arguments.small) for one in chosen]
    rows = [{"scene": one["scene"], "force_error": one["force_error"], **row} for one in fits for row in one["runs"]]
    notes = [f"{one['scene']}: settled {one['settle_s']:g} s, reference errs by "
             f"{100 * one['reference_own_error']:.2g} %" for one in fits]
    write_rows(arguments.charts / "fits.csv", rows, notes)
    print(table_of(fits))


if __name__ == "__main__":
    main()
