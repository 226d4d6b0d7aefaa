"""The reader of recordings of the Python package, for programs of the tree and for stillgrid_demo."""
import pathlib
import sys

# In the tree, or PREFIX/share/stillgrid/demo/gallery of an installed one.
HERE = pathlib.Path(__file__).resolve()
sys.path += [str(HERE.parents[2] / "shared/python"), str(HERE.parents[4] / "lib/python3/dist-packages")]
from stillgrid.recording import load  # after the path it needs
