#!/usr/bin/python3
"""Draws docs/charts/tutorial_hand.png: the picture that step 4 of docs/tutorial.md makes, in lockstep."""
import pathlib
import re
import subprocess
import tempfile

from measuring import ROOT, fail, parser_of
from plot_recording import draw
from recording import load


def main():
    arguments = parser_of(__doc__, "the same: it is small").parse_args()
    scene = re.search(r"^```toml build/mine/cushion\.toml\n(.*?)^```$", (ROOT / "docs/tutorial.md").read_text(),
                      re.MULTILINE | re.DOTALL)
    if not scene:
        fail("docs/tutorial.md: expected a block build/mine/cushion.toml")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "cushion.toml").write_text(scene[1])
        subprocess.run([ROOT / "scripts/launch", folder / "cushion.toml", "--duration", "6", "--device",
                        "phantom:hand=light,path=press", "--lockstep", "--record", folder / "hand.csv", "--build",
                        arguments.build], check=True, stdout=subprocess.DEVNULL)
        draw(load(folder / "hand.csv"), "A light hand presses the cushion", window_s=0.5,
             picture=arguments.charts / "tutorial_hand.png")


if __name__ == "__main__":
    main()
