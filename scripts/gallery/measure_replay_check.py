#!/usr/bin/python3
"""Draws docs/charts/replay_check.png: what scripts/replay_check shows of a tissue whose contact is 2 %
too stiff. Needs the folder of real inputs; both daemons in lockstep, so that a build gives one picture."""
import pathlib
import subprocess
import tempfile

from measuring import DATA, ROOT, fail, parser_of
from tables import write_bytes

TISSUE = ROOT / "shared/tools/laboratory/scenes/tissue.toml"
ROBOT = DATA / "trajectories/franka_1khz/franka_20260223_162545.csv"
INTO_SCENE = "scale=0.15,offset_x_m=-0.0852,offset_y_m=-0.0025,offset_z_m=0.005,resample=cubic"
RIGHT, WRONG = "contact_stiffness_N_per_m = 500.0", "contact_stiffness_N_per_m = 510.0"
EQUAL, DIFFERENT = 0, 1


def main():
    arguments = parser_of(__doc__, "the same: it is small").parse_args()
    if not ROBOT.exists():
        fail(f"{ROBOT}: expected the real inputs there")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        stiffer = folder / "stiffer.toml"
        stiffer.write_text(TISSUE.read_text().replace(RIGHT, WRONG))
        expected, picture = folder / "expected.csv", folder / "picture.png"
        for scene, options, status in ((TISSUE, ["--write-expected"], EQUAL),
                                       (stiffer, ["--picture", picture], DIFFERENT)):
            run = subprocess.run(
                [ROOT / "scripts/replay_check", scene, ROBOT, expected, "--replay", INTO_SCENE,
                 "--duration", "3", "--build", arguments.build, *options], capture_output=True, text=True)
            print(run.stdout, end="")
            if run.returncode != status:
                fail(f"replay_check: exit status {run.returncode}, expected {status}: {run.stderr.strip()}")
        write_bytes(arguments.charts / "replay_check.png", picture.read_bytes())


if __name__ == "__main__":
    main()
