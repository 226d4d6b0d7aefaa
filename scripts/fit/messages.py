"""Lines for the user of scene_fit."""
import sys


class Unusable(Exception):
    """A line that says why there is no fit."""


def note(text):
    print(f"scene_fit: {text}", file=sys.stderr)
