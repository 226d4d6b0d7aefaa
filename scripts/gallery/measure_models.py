#!/usr/bin/python3
"""Measures every intermediate model on the same paths: docs/charts/model_table.csv.

Paths are scripted (written here) or recordings made by others, in $STILLGRID_DATA or ../shared/data;
a recording that is not there leaves its rows out, and says so. Each path goes through every model by
the program compare_models, without and with jitter; the largest stable stiffness is of stability_lab's
body that is most like the scene, by one seed of the jitter in runs of 6 s; limits that the table has stay, for
they take hours: take a row away to have its limit sought. paper_figures has the forces of
Figs. 6 to 8.
"""
import concurrent.futures
import csv
import io
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import measuring
from measuring import ROOT, parser_of
from tables import read_rows, write_rows

SCENES = ROOT / "sim_server/scene/scenes"
DATA = measuring.DATA / "trajectories"
PERIOD_S = 1.0 / 33.0
COST = 0.1  # of a period, a step
JITTERS = (0.0, 0.3)
TISSUE = ROOT / "tests/laboratory/scenes/tissue.toml"


def ease(t, start, end):
    """From 0 to 1 without a kink."""
    s = min(max((t - start) / (end - start), 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


def press_tissue(t):
    """Waits above while the blocks settle, then presses the tissue between them twice a second,
    stroking in a circle of 4 mm that brushes the blocks."""
    come = ease(t, 0.7, 1.0)
    depth_m = 0.024 + 0.004 * math.sin(4.0 * math.pi * t)
    angle = 2.0 * math.pi * 0.5 * t
    return (0.004 * math.cos(angle), 0.004 * math.sin(angle), 0.02 - come * (0.02 + depth_m))


def stir_threads(t):
    """Circles of 20 mm at 1 Hz among hanging threads."""
    angle = 2.0 * math.pi * t
    return (0.02 * math.cos(angle) - 0.02, 0.02 * math.sin(angle), 0.005 * math.sin(0.7 * angle))


def ride_sphere(t):
    """Goes with the sphere of moving_sphere, which comes at 0.1 m/s, pressed by 6 mm, and by 1.5 mm
    more and less at 1 Hz."""
    depth_m = ease(t, 0.1, 0.4) * (0.007 + 0.0015 * math.sin(2.0 * math.pi * t)) - 0.001
    return (-0.05 + 0.1 * t + 0.015 - depth_m, 0.0, 0.0)


def replay(file, options):
    return f"replay:file={DATA / file},{options}"


# Name, scene, path or device, when it begins to count, end [s], stability_lab's body most like it.
PATHS = [
    ("tissue and blocks", SCENES / "tissue_and_blocks.toml", press_tissue, 1.0, 8.0, "block"),
    ("tissue and blocks, all", SCENES / "tissue_and_blocks.toml", press_tissue, 0.0, 8.0, "block"),
    ("threads", SCENES / "threads.toml", stir_threads, 0.5, 8.0, "chain:0.0005"),
    ("moving sphere", SCENES / "moving_sphere.toml", ride_sphere, 0.5, 6.0, "wall"),
    ("franka on tissue", TISSUE,
     replay("franka_1khz/franka_20260223_162545.csv",
            "scale=0.2,offset_x_m=-0.11,offset_z_m=0.0026"), 0.5, 11.0, "block"),
    ("contour on tissue", TISSUE,
     replay("ku_contour_force/demo_a_2.csv",
            "scale=0.25,knot_spacing_s=0.035,offset_y_m=0.009,offset_z_m=0.0065"), 0.5, 5.2, "block"),
    ("teleoperator on free body", "free:0.1",
     replay("teleop_1dof_2khz/m2_question1a_spring.csv", "map=z_m:slave_rad*0.075"), 0.5, 4.8,
     "free:0.1"),
]
SMALL_PATHS = [(*PATHS[place][:4], 2.5, PATHS[place][5]) for place in (2, 3)]


def write_path(path, seconds, file):
    with open(file, "w") as stream:
        stream.write("time_s,x_m,y_m,z_m\n")
        for i in range(int(1000 * seconds) + 2):
            stream.write(f"{i / 1000}," + ",".join(f"{x:.9g}" for x in path(i / 1000)) + "\n")


def device_of(path, seconds, folder):
    """As haptic_server --device takes it, or nothing: a recording that is not there."""
    if isinstance(path, str):
        file = pathlib.Path(path.split("file=")[1].split(",")[0])
        return path if file.exists() else None
    file = pathlib.Path(folder) / f"{path.__name__}.csv"
    if not file.exists():
        write_path(path, seconds, file)
    return f"replay:file={file}"


def run(build, program, *options):
    command = [str(measuring.program(build, program)), *map(str, options)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def compare(build, scene, device, jitter, since, seconds, *more):
    text = run(build, "compare_models", "--scene", scene, "--device", device, "--period", PERIOD_S,
               "--latency", COST, "--jitter", jitter, "--seed", 1, "--friction", 0.3, "--from", since,
               "--duration", seconds, *more)
    return list(csv.DictReader(io.StringIO(text)))


def stable_stiffness(build, body, name, jitter):
    """Light device; step cost and jitter as in the table."""
    held = re.fullmatch(r"hold at (\d+) Hz", name)
    period_s = 1.0 / float(held[1]) if held else PERIOD_S
    is_model = name in ("force_held", "force_jacobian", "plane", "sphere", "proxy", "crossfade")
    text = run(build, "stability_lab", "limit", "--scene", body, "--device", "light",
               "--period", period_s, "--latency", COST, "--jitter", jitter, "--friction", 0.3,
               "--duration", 6, "--seeds", 1, "--transition", "hold" if is_model or held else name,
               "--model", name if is_model else "grid")
    return text.strip() if text[0].isdigit() else "0"


def known_limits(file):
    """Of the table that is there, by body, model and jitter."""
    if not file.exists():
        return {}
    return {(row["body"], row["model"], float(row["jitter"])): row["stable_stiffness_N_per_m"]
            for row in read_rows(file) if row["model"] != "reference"}


def measure_table(build, pool, is_small, file):
    """Small: two paths, shortened, with jitter, which the charts show; stiffness is not searched."""
    known = known_limits(file)
    with tempfile.TemporaryDirectory() as folder:
        jobs = []
        for name, scene, path, since, seconds, body in SMALL_PATHS if is_small else PATHS:
            device = device_of(path, seconds, folder)
            if device is None:
                print(f"skipped: {name}: its recording is not in {DATA}", file=sys.stderr)
                continue
            for jitter in JITTERS[1:] if is_small else JITTERS:
                jobs.append((name, body, jitter, pool.submit(
                    compare, build, scene, device, jitter, since, seconds)))
        rows, limits = [], dict(known)
        for name, body, jitter, job in jobs:
            for row in job.result():
                key = body, row["model"], jitter
                if row["model"] != "reference" and key not in limits and not is_small:
                    limits[key] = pool.submit(stable_stiffness, build, *key)
                rows.append({"path": name, "jitter": jitter, "body": body, **row})
    for row in rows:
        key = row["body"], row["model"], row["jitter"]
        limit = limits.get(key, "")
        row["stable_stiffness_N_per_m"] = limit if isinstance(limit, str) else limit.result()
    return rows


FIGURE_MODELS = ("hold", "linear", "local")
FIGURE_S = (2.0, 2.5)


def record(build, transition, period_s, cost, device, folder):
    file = pathlib.Path(folder) / f"{transition}_{period_s:.4f}.csv"
    run(build, "stability_lab", "run", "--scene", SCENES / "moving_sphere.toml", "--device", device,
        "--period", period_s, "--latency", cost, "--transition", transition, "--duration", 3,
        "--jitter", 0.3 if cost else 0.0, "--record", file)
    with open(file) as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def figure_rows(build, label, folder):
    """Of a transition, or of held snapshots at 1 kHz."""
    device = device_of(ride_sphere, 3.0, folder)
    shown = ("hold", 0.001, 0.0) if label == "reference" else (label, PERIOD_S, COST)
    return [{"model": label, "time_s": row["time_s"], "force_N": row[FORCE_COLUMN], "snapshot": row[SNAPSHOT_COLUMN]}
            for row in record(build, *shown, device, folder)
            if FIGURE_S[0] <= float(row["time_s"]) < FIGURE_S[1]]


def measure_figures(build, pool, is_small, file):
    """The force on a tool that goes with the moving sphere, and the snapshot id shown, tick by
    tick; small as it is."""
    del pool, is_small, file
    with tempfile.TemporaryDirectory() as folder:
        return [row for label in (*FIGURE_MODELS, "reference") for row in figure_rows(build, label, folder)]


FORCE_COLUMN, SNAPSHOT_COLUMN = "fx_N", "snapshot_id"
TABLES = {"model_table": measure_table, "paper_figures": measure_figures}


def main():
    parser = parser_of(__doc__, "model_table: two paths of 2.5 s; paper_figures is small")
    parser.add_argument("tables", nargs="*", default=list(TABLES), metavar="TABLE",
                        help=f"some of {', '.join(TABLES)}; default: all")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="default: 2")
    arguments = parser.parse_args()
    try:
        with concurrent.futures.ThreadPoolExecutor(arguments.threads) as pool:
            for table in arguments.tables:
                file = arguments.charts / f"{table}.csv"
                write_rows(file, TABLES[table](arguments.build, pool, arguments.small, file))
    except (OSError, RuntimeError, KeyError, IndexError) as error:
        measuring.fail(f"{type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
