"""The recorded trajectories: each with a scene that it touches, and how it is laid into it."""
import contextlib
import dataclasses
import subprocess

import daemons

FOLDER = daemons.DATA / "trajectories"
CONTOUR_MESH = daemons.DATA / "meshes" / "ku_contour.stl"
TISSUE = daemons.ROOT / "tests/laboratory/scenes/tissue.toml"

# The printed contour that the demonstrations were recorded on, in place.
CONTOUR_SCENE = """format = 2
[simulation]
rate_hz = 30.0
[tool]
radius_m = 0.003
[[material]]
name = "print"
contact_stiffness_N_per_m = 1000.0
contact_damping_N_s_per_m = 1.0
friction = 0.2
[[body]]
name = "contour"
kind = "mesh"
file = "{mesh}"
scale = 0.001
motion = "static"
material = "print"
"""


@dataclasses.dataclass
class Trajectory:
    file: str  # below FOLDER
    scene: str  # wall, tissue or contour
    options: str  # of the replay device

    @property
    def name(self):
        return self.file.rpartition("/")[2].removesuffix(".csv")

    @property
    def device(self):
        return f"replay:file={FOLDER / self.file},{self.options}"


# The roller's poses came at 28.6 Hz and were interpolated: a spline through one in 35 ms. The lever
# of the 1-DOF rig is 75 mm long; it presses the tool's 5 mm into the wall. The robot's circle of
# 0.43 x 0.61 m becomes one of 6 x 9 cm that sweeps the tissue.
TRAJECTORIES = [
    *(Trajectory(f"ku_contour_force/demo_{demo}.csv", "contour", "resample=cubic,knot_spacing_s=0.035")
      for demo in ("a_1", "a_2", "b_1", "b_2", "c_1", "c_2", "d_1", "d_2")),
    Trajectory("teleop_1dof_2khz/m2_question1a_spring.csv", "wall",
               "map=z_m:slave_rad*0.075,offset_z_m=0.008"),
    Trajectory("teleop_1dof_2khz/question1a_free_motion.csv", "wall",
               "map=z_m:slave_rad*0.075,offset_z_m=0.012"),
    Trajectory("franka_1khz/franka_20260223_162545.csv", "tissue",
               "scale=0.15,offset_x_m=-0.0852,offset_y_m=-0.0025,offset_z_m=0.005,resample=cubic"),
]


def make_scene(name, folder):
    """The scene's file."""
    if name == "wall":
        return daemons.SCENES / "wall.toml"
    if name == "tissue":
        return TISSUE
    scene = folder / "contour.toml"
    scene.write_text(CONTOUR_SCENE.format(mesh=CONTOUR_MESH))
    return scene


@contextlib.contextmanager
def stress():
    """stress-ng beside what is done within."""
    load = subprocess.Popen(["setpriv", "--pdeathsig", "TERM", "stress-ng", "--quiet", "--cpu", "2", "--vm",
                             "1", "--vm-bytes", "64M", "--switch", "1"])
    try:
        yield
        if load.poll() is not None:
            raise RuntimeError("stress-ng ended before what it was beside")
    finally:
        load.terminate()
        load.wait()
