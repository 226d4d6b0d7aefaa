"""What every script that measures shares: its options, and where it finds programs and real inputs."""
import argparse
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("STILLGRID_DATA", ROOT.parent / "shared" / "data"))


def parser_of(description, small):
    """Options that all have; small: what --small measures."""
    build = pathlib.Path(os.environ.get("STILLGRID_BUILD_DIR", ROOT / "build/release"))
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--charts", type=pathlib.Path, default=ROOT / "docs/charts", metavar="FOLDER",
                        help="where tables are written; default: docs/charts")
    parser.add_argument("--build", type=pathlib.Path, default=build, metavar="FOLDER",
                        help="default: $STILLGRID_BUILD_DIR, else build/release")
    parser.add_argument("--small", action="store_true", help=small)
    return parser


def fail(what):
    """Ends the program with one line."""
    sys.exit(f"{pathlib.Path(sys.argv[0]).stem}: {what}")


def program(build, name):
    """The file of a benchmark, of a program that prints figures or of a tool; it must be there."""
    for folder in ("bin", "tests"):
        if (file := build / folder / name).exists():
            return file
    fail(f"{file}: expected a program; run scripts/build release all figures")


def output_of(command):
    """What a program prints; its failure ends this one with one line."""
    run = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if run.returncode:
        last = (run.stderr.strip().splitlines() or [f"exit status {run.returncode}"])[-1]
        fail(f"{pathlib.Path(command[0]).name}: {last}")
    return run.stdout
