"""The reader of recordings of the Python package, for programs of the tree."""
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "shared/python"))
from stillgrid.recording import load  # after the path it needs
