"""Forces over time, read strictly from CSV, and how two of them differ."""
import dataclasses
import pathlib

import numpy

from expectation import Unusable, content_of
from metadata import metadata_of

TIME_NAMES = ("time_s", "t_s")
FORCE_NAMES = ("fx_N", "fy_N", "fz_N")
POSITION_NAMES = ("x_m", "y_m", "z_m")
POSITION_TOLERANCE_M = 1e-6  # the same input, but for another compiler's rounding


@dataclasses.dataclass
class Forces:
    """Time from zero, one array a column; every value finite, time strictly growing."""

    file: pathlib.Path
    time_s: numpy.ndarray
    columns: dict
    lines: numpy.ndarray  # where each row stands in the file
    is_recording: bool  # by haptic_server --record, whose positions are the tool's in the scene
    about: dict  # of the metadata beside a recording, or of the lines "# key: value" above an imported one

    def names(self, wanted):
        return [name for name in wanted if name in self.columns]


def read_forces(file, sources=None):
    """Reads up to the last whole row; of rows with equal stamps the last counts. sources: by the name of a force, the
    column that it is read from in its stead, and a factor."""
    file = pathlib.Path(file)
    try:
        text = content_of(file).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise Unusable(f"{file}: cannot be read: no text") from None
    lines = text.split("\n")[:-1]  # what follows the last newline was cut off
    rows = [(number, [field.strip() for field in line.split(",")])
            for number, line in enumerate(lines, 1)
            if line.strip() and not line.startswith("#")]
    if len(rows) < 2:
        raise Unusable(f"{file}: no whole row: expected a header that names time_s and fx_N, fy_N or "
                       "fz_N, and rows below it")
    (header_line, header), *rows = rows
    for number, row in rows:
        if len(row) != len(header):
            raise Unusable(f"{file}:{number}: {len(row)} fields: expected {len(header)}")
    columns, sources = {}, sources or {}
    for name, (source, _) in sources.items():
        if source not in header:
            raise Unusable(f"{file}:{header_line}: column {source}: missing: expected it for {name}")
    for name in (*TIME_NAMES, *FORCE_NAMES, *POSITION_NAMES, "contacts", "snapshot_id"):
        source, factor = sources.get(name, (name, 1.0))
        if header.count(source) > 1:
            raise Unusable(f"{file}:{header_line}: column {source}: given twice")
        if source in header:
            columns[name] = factor * numbers(file, source, header.index(source), rows)
    time_name = next((name for name in TIME_NAMES if name in columns), None)
    if time_name is None or not any(name in columns for name in FORCE_NAMES):
        missing = "fx_N" if time_name else "time_s"
        raise Unusable(f"{file}:{header_line}: column {missing}: missing: expected a header that "
                       "names time_s (or t_s) and fx_N, fy_N or fz_N")
    time_s = columns.pop(time_name)
    numbers_of_lines = numpy.array([number for number, _ in rows])
    back = numpy.flatnonzero(numpy.diff(time_s) < 0.0)
    if len(back):
        raise Unusable(f"{file}:{numbers_of_lines[back[0] + 1]}: column {time_name}: value "
                       f"'{time_s[back[0] + 1]:g}': expected a time not before that of the row above")
    kept = numpy.append(numpy.diff(time_s) > 0.0, True)
    try:
        about = metadata_of(file, lines)
    except ValueError as error:
        raise Unusable(error) from None
    return Forces(file, time_s[kept] - time_s[kept][0],
                  {name: column[kept] for name, column in columns.items()},
                  numbers_of_lines[kept], "rendered_fx_N" in header,
                  about)


def numbers(file, name, index, rows):
    texts = [row[index] for _, row in rows]
    try:
        values = numpy.array(texts, float)
    except ValueError:
        values = numpy.array([as_number(text) for text in texts])
    bad = numpy.flatnonzero(~numpy.isfinite(values))
    if len(bad):
        raise Unusable(f"{file}:{rows[bad[0]][0]}: column {name}: value '{texts[bad[0]][:40]}': "
                       "expected a finite number")
    return values


def as_number(text):
    try:
        return float(text)
    except ValueError:
        return numpy.nan


@dataclasses.dataclass
class Comparison:
    """What was got, at the stamps of what was expected."""

    expected: Forces
    got: Forces
    tolerance_N: float
    names: list  # force columns that both have
    time_s: numpy.ndarray  # compared stamps
    expected_N: numpy.ndarray  # row by stamp, column by name
    got_N: numpy.ndarray
    moved: tuple  # first stamp where positions differ: (row, name), or None
    is_same_length: bool

    @property
    def difference_N(self):
        return self.got_N - self.expected_N

    @property
    def is_different(self):
        """A row by stamp."""
        return (numpy.abs(self.difference_N) > self.tolerance_N).any(axis=1)

    @property
    def first(self):
        """Row and column of the first difference, or None."""
        rows = numpy.flatnonzero(self.is_different)
        if not len(rows):
            return None
        return rows[0], int(numpy.argmax(numpy.abs(self.difference_N[rows[0]]) > self.tolerance_N))

    @property
    def largest(self):
        """Row and column of the largest difference of a component."""
        row, column = numpy.unravel_index(numpy.abs(self.difference_N).argmax(), self.difference_N.shape)
        return int(row), int(column)

    @property
    def is_equal(self):
        return self.first is None and self.moved is None and self.is_same_length


def compare(expected, got, tolerance_N):
    """Stamp by stamp; where the stamps are others, what was got is read off between its rows."""
    shared = min(len(expected.time_s), len(got.time_s))
    has_same_stamps = numpy.array_equal(expected.time_s[:shared], got.time_s[:shared])
    if has_same_stamps:
        time_s = expected.time_s[:shared]
        is_same_length = len(expected.time_s) == len(got.time_s)
    else:
        time_s = expected.time_s[expected.time_s <= got.time_s[-1]]
        period_s = longest_step_s(expected.time_s) + longest_step_s(got.time_s)
        is_same_length = abs(expected.time_s[-1] - got.time_s[-1]) <= period_s

    def at_stamps(forces, name):
        if forces is expected or has_same_stamps:
            return forces.columns[name][:len(time_s)]
        return numpy.interp(time_s, forces.time_s, forces.columns[name])

    def table(forces, names):
        return numpy.stack([at_stamps(forces, name) for name in names], axis=1)

    names = expected.names(FORCE_NAMES)
    moved = None
    if expected.is_recording and len(expected.names(POSITION_NAMES)) == 3:
        moves = numpy.abs(table(got, POSITION_NAMES) - table(expected, POSITION_NAMES))
        if (moves > POSITION_TOLERANCE_M).any():
            row, column = numpy.argwhere(moves > POSITION_TOLERANCE_M)[0]
            moved = (row, POSITION_NAMES[column])
    return Comparison(expected, got, tolerance_N, names, time_s, table(expected, names),
                      table(got, names), moved, is_same_length)


def longest_step_s(time_s):
    return numpy.diff(time_s).max() if len(time_s) > 1 else 0.0
