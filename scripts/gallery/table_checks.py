"""What of the published tables is measured again, and how: each check draws rows of a table, has the
program that wrote them write them again, and yields (row's key, column, published, measured) of every
figure that no clock decides. What needs the real inputs yields nothing where they are absent."""
import csv
import io
import pathlib
import subprocess
import tempfile

import measure_models
import measure_printed
import recorded_forces
from measuring import output_of, program
from tables import read_rows

CLOCKED = ("tick_median_us", "processor_ms_per_s", "stable_stiffness_N_per_m", "time_s")


class Tables:
    """The published tables, a build to measure them with, and what draws rows."""

    def __init__(self, charts, build, random, rows):
        self.charts, self.build, self.random, self.rows = charts, build, random, rows

    def published(self, table):
        return read_rows(self.charts / f"{table}.csv")

    def draw(self, some):
        some = list(some)
        return self.random.sample(some, min(self.rows, len(some)))

    def run(self, name, *options):
        return list(csv.DictReader(
            line for line in io.StringIO(output_of([program(self.build, name), *options]))
            if not line.startswith("#")))


def differences(key, published, measured, columns):
    for column in columns:
        yield key, column, published[column], measured.get(column, "") if measured else "(no such row)"


def printed(table, keys):
    """Of a program that prints a whole table."""
    def check(tables):
        measured = {tuple(row[key] for key in keys): row
                    for row in tables.run(measure_printed.PROGRAMS[table])}
        rows = tables.published(table)
        for row in tables.random.sample(rows, min(40, len(rows))):
            key = tuple(row[name] for name in keys)
            yield from differences(key, row, measured.get(key), [name for name in row if name not in keys])
    return check


def check_voxel_ratio(tables):
    keys = ("shape", "engine", "ratio")
    measured = {tuple(row[key] for key in keys): row for row in tables.run("voxel_ratio_figures")}
    for row in tables.published("voxel_ratio"):
        if row["engine"] == "paper":
            key = tuple(row[name] for name in keys)
            yield from differences(key, row, measured.get(key), ("entries", "visits", "tests"))


def check_model_table(tables):
    """A path, with or without jitter, and some of its models; one of them with its stable stiffness."""
    rows = tables.published("model_table")
    path = tables.random.choice([path for path in measure_models.PATHS if path[0] != "tissue and blocks, all"])
    name, scene, way, since, seconds, _ = path
    jitter = tables.random.choice(measure_models.JITTERS)
    mine = [row for row in rows if row["path"] == name and float(row["jitter"]) == jitter]
    drawn = tables.draw([row for row in mine if row["model"] != "reference"])
    with tempfile.TemporaryDirectory() as folder:
        device = measure_models.device_of(way, seconds, folder)
        if device is None:
            return
        names = [row["model"] for row in drawn]
        measured = {row["model"]: row for row in measure_models.compare(
            tables.build, scene, device, jitter, since, seconds, "--models", *names)}
    for row in [row for row in mine if row["model"] == "reference"] + drawn:
        key = name, f"jitter {jitter}", row["model"]
        yield from differences(key, row, measured.get(row["model"]),
                               [column for column in measured["reference"]
                                if column not in CLOCKED + ("model",)])


def check_paper_figures(tables):
    label = tables.random.choice(("reference", *measure_models.FIGURE_MODELS))
    with tempfile.TemporaryDirectory() as folder:
        measured = {row["time_s"]: row for row in measure_models.figure_rows(tables.build, label, folder)}
    for row in tables.draw(row for row in tables.published("paper_figures") if row["model"] == label):
        yield from differences((label, row["time_s"]), row, measured.get(row["time_s"]), ("force_N", "snapshot"))


def verdict(tables, row, stiffness_N_per_m, seed):
    options = ["--scene", row["scene"], "--tool", row["tool"], "--device", row["device"],
               "--limits", row["limits"], "--from", row["from"], "--model", row["model"],
               "--transition", row["transition"], "--period", row["period_s"],
               "--latency", row["latency_share"], "--jitter", row["jitter"], "--seed", seed,
               "--resolution", row["resolution_m"], "--device-friction", row["device_friction_N"],
               "--damping", row["contact_damping_N_s_per_m"], "--friction", row["friction"],
               "--duration", row["duration_s"]]
    return output_of([program(tables.build, "stability_lab"), "judge", *options,
                      "--stiffness", f"{stiffness_N_per_m:.6g}"]).strip()


def check_stability(tables):
    """Stable at the limit by each seed: a lower bound is what a limit promises."""
    for row in tables.draw([row for row in tables.published("stability") if row["limit_N_per_m"]]):
        first, _, last = row["seeds"].partition("-")
        verdicts = {verdict(tables, row, float(row["limit_N_per_m"]), seed)
                    for seed in range(int(first), int(last or first) + 1)}
        key = tuple(row[name] for name in ("scene", "tool", "device", "limits", "from", "model", "transition",
                                           "period_s", "latency_share", "seeds", "limit_N_per_m"))
        yield key, "verdict", "stable", " ".join(sorted(verdicts))


def check_contour(tables):
    if not recorded_forces.CONTOUR_MESH.exists():
        return
    row = tables.random.choice(tables.published("contour_forces"))
    with tempfile.TemporaryDirectory() as folder:
        scene, file = pathlib.Path(folder) / "scene.toml", pathlib.Path(folder) / "recording.csv"
        scene.write_text(recorded_forces.contour_scene())
        name = row["demonstration"]
        subprocess.run([recorded_forces.ROOT / "scripts/launch", scene, "--lockstep", "--device",
                        recorded_forces.contour_device(name), "--duration",
                        str(recorded_forces.contour_duration_s(name)), "--record", file,
                        "--build", tables.build], check=True, stdout=subprocess.DEVNULL)
        share, cosine = recorded_forces.compare_contour(name, file)
    yield from differences((name,), row, {"in_contact": f"{share:.4f}", "mean_cosine": f"{cosine:.4f}"},
                           ("in_contact", "mean_cosine"))


# Seconds are of a quiet machine.
CHECKS = {
    "row_ripple": printed("row_ripple", ("quantity", "spacing_mm", "x")),
    "ku_contact": printed("ku_contact", ("model", "step_mm", "demonstration")),
    "broyden_iterations": printed("broyden_iterations", ("scene", "solver", "k_h2_per_m")),
    "voxel_ratio": check_voxel_ratio,
    "model_table": check_model_table,
    "paper_figures": check_paper_figures,
    "stability": check_stability,
    "contour_forces": check_contour,
}
