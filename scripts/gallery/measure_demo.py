#!/usr/bin/python3
"""Draws docs/charts/demo_force.png from a run of both daemons in real time: a light hand presses through
the gap between the blocks into the tissue, every two seconds, for ten."""
import pathlib
import subprocess
import tempfile

from measuring import ROOT, parser_of
from plot_recording import draw
from recording import load

HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=2"


def main():
    arguments = parser_of(__doc__, "3 s").parse_args()
    seconds = 3 if arguments.small else 10
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "recording.csv"
        subprocess.run([ROOT / "scripts/launch", "tissue_and_blocks", "--device", HAND, "--duration",
                        str(seconds), "--record", file, "--build", arguments.build],
                       check=True, stdout=subprocess.DEVNULL)
        draw(load(file), f"A light hand presses into the tissue, {seconds} s in real time", window_s=0.1,
             picture=arguments.charts / "demo_force.png")


if __name__ == "__main__":
    main()
