"""Recordings with measured forces, by others, against ours at the same places: both daemons, in lockstep.

Needs the folder of real inputs, $STILLGRID_DATA or ../shared/data of the project.
"""
import csv
import os
import pathlib

import numpy

from recording import load

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("STILLGRID_DATA", ROOT.parent / "shared" / "data"))
SPRING = DATA / "trajectories/teleop_1dof_2khz/m2_question1a_spring.csv"
CONTOUR_MESH = DATA / "meshes/ku_contour.stl"
DEMONSTRATIONS = ("a_1", "a_2", "b_1", "b_2", "c_1", "c_2", "d_1", "d_2")
LEVER_M = 0.075
TOOL_M = 0.005  # radius

SCENE = """format = 2
[world]
gravity_m_s2 = [0.0, 0.0, 0.0]
[tool]
radius_m = {tool_m}
[[material]]
name = "recorded"
contact_stiffness_N_per_m = {stiffness_N_per_m!r}
[[body]]
name = "recorded"
material = "recorded"
{body}
"""


def columns(file, names):
    with open(file) as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return [numpy.array([float(row[name]) for row in rows]) for name in names]


class Spring:
    """A lever tip pressed against a spring: time from the first sample, place and force of the tip."""

    def __init__(self):
        stamp_s, angle, torque_N_m = columns(SPRING, ("t_s", "slave_rad", "Fe_Nm"))
        self.time_s = stamp_s - stamp_s[0]
        self.place_m, self.force_N = LEVER_M * angle, torque_N_m / LEVER_M
        self.half_s = 0.5 * self.time_s[-1]
        first = self.time_s < self.half_s
        self.stiffness_N_per_m, at_zero_N = numpy.polyfit(self.place_m[first], self.force_N[first], 1)
        self.rest_m = -at_zero_N / self.stiffness_N_per_m

    def scene(self):
        """A wall of the stiffness fitted on the first half, at the place where its force is zero."""
        body = (f'kind = "plane"\npoint_m = [{self.rest_m + TOOL_M!r}, 0.0, 0.0]\n'
                "normal = [-1.0, 0.0, 0.0]")
        return SCENE.format(tool_m=TOOL_M, stiffness_N_per_m=float(self.stiffness_N_per_m), body=body)

    def device(self):
        return f"replay:file={SPRING},map=x_m:slave_rad*{LEVER_M}"

    def compare(self, file):
        """Ticks of haptic_server's recording: time, place, force measured and ours, both against the spring."""
        ours = load(file)
        time_s = ours["time_s"]
        return time_s, ours["x_m"], numpy.interp(time_s, self.time_s, self.force_N), -ours["fx_N"]


# The lever's force is on the spring, a torque; place and force of the tip are along x.
SPRING_FIT = ("--one", "--replay", f"map=x_m:slave_rad*{LEVER_M}", "--force", f"fx_N:Fe_Nm*{-1.0 / LEVER_M:.9g}")
BLOCK = ("v 0 -1 -1\nv 2 -1 -1\nv 0 1 -1\nv 2 1 -1\nv 0 -1 1\nv 2 -1 1\nv 0 1 1\nv 2 1 1\nf 1 3 4\nf 1 4 2\nf 5 6 8\n"
         "f 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n")


def spring_halves(folder):
    """For stiffness_fit: a scene with a block whose face is about where the spring is at rest, and the recording's
    halves, to be read by SPRING_FIT."""
    (folder / "block.obj").write_text(BLOCK)
    body = (f'kind = "mesh"\nfile = "block.obj"\nscale = 0.02\nposition_m = [{-0.01 + TOOL_M!r}, 0.0, 0.0]\n'
            'motion = "static"\ncontact = "field"\nfield = { cell_m = 0.001 }')
    scene = folder / "spring.toml"
    scene.write_text(SCENE.format(tool_m=TOOL_M, stiffness_N_per_m=1000.0, body=body))
    header, *rows = [line for line in SPRING.read_text().splitlines(True) if not line.startswith("#")]
    half, halves = len(rows) // 2, []
    for name, part in (("first", rows[:half]), ("second", rows[half:])):
        halves.append(folder / f"{name}_half.csv")
        halves[-1].write_text(header + "".join(part))
    return scene, halves


def demonstration(name):
    return DATA / f"trajectories/ku_contour_force/demo_{name}.csv"


# Lines of a body, and of its tool.
CONTACTS = {"field": ("", ""), "spheres": ("spheres = { volume_spacing_m = 0.005 }\n", ""),
            "penalty": ("spheres = { surface_spacing_m = 0.004 }\n", 'contact = "penalty"\n')}


def contour_scene(contact="field"):
    """The printed contour, that does not move, with a contact of CONTACTS."""
    of_body, of_tool = CONTACTS[contact]
    body = f'kind = "mesh"\nfile = "{CONTOUR_MESH}"\nscale = 0.001\nmotion = "static"\n{of_body}'
    scene = SCENE.format(tool_m=TOOL_M, stiffness_N_per_m=1000.0, body=body)
    return scene.replace("[tool]\n", f"[tool]\n{of_tool}")


def contour_device(name):
    """Poses came at 28.6 Hz, with lines between them."""
    return f"replay:file={demonstration(name)},resample=cubic,knot_spacing_s=0.035"


def contour_duration_s(name):
    (stamp_s,) = columns(demonstration(name), ("t_s",))
    return float(stamp_s[-1] - stamp_s[0])


def compare_contour(name, file):
    """Share of ticks in contact, and the mean cosine with the measured force over them."""
    measured = columns(demonstration(name), ("t_s", "fx_N", "fy_N", "fz_N"))
    time_s = measured[0] - measured[0][0]
    recording = load(file)
    seen = recording["time_s"] <= time_s[-1]
    ours_N = numpy.stack([recording[f"rendered_f{axis}_N"][seen] for axis in "xyz"], axis=1)
    theirs_N = numpy.stack([numpy.interp(recording["time_s"][seen], time_s, force_N)
                            for force_N in measured[1:]], axis=1)
    norms_N = numpy.linalg.norm(ours_N, axis=1)
    touched = norms_N > 0.0
    cosines = (ours_N * theirs_N).sum(axis=1)[touched] / (
        norms_N[touched] * numpy.linalg.norm(theirs_N, axis=1)[touched])
    return touched.mean(), cosines.mean()
