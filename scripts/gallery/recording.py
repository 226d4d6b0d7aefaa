"""Reads a recording: the CSV of docs/formats.md, as haptic_server --record writes it."""
import csv
import pathlib
import sys

import numpy

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "replay"))
from old_names import columns_of_today, flags_of_today, given_twice


class Recording:
    """Columns by name, arrays of floats (flags: of text); metadata by key."""

    def __init__(self, file):
        lines = pathlib.Path(file).read_text().splitlines(keepends=True)
        if lines and not lines[-1].endswith("\n"):
            lines.pop()  # cut off in mid-row
        comments = [line[1:].strip() for line in lines if line.startswith("#")]
        self.metadata = dict(line.split(": ", 1) for line in comments if ": " in line)
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
        if len(rows) < 2:
            raise ValueError(f"{file}: expected a header and a row at least")
        if name := given_twice(rows[0]):
            raise ValueError(f"{file}: column {name}: given twice, by this name or an earlier one")
        self.columns = {name: numpy.array([flags_of_today(text) for text in column]) if name == "flags"
                        else numpy.array(column, float)
                        for name, column in zip(columns_of_today(rows[0]), zip(*rows[1:]))}

    def __getitem__(self, name):
        return self.columns[name]

    def force_norm_N(self):
        return numpy.sqrt(self["fx_N"] ** 2 + self["fy_N"] ** 2 + self["fz_N"] ** 2)
