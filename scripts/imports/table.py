"""What a raw file holds: named columns of equal length, and where each value stands."""
import collections
import dataclasses

import numpy


class Unusable(Exception):
    """One line: the file, where in it, which column and value, what was expected."""


class Faulty(Exception):
    """One line: a gap or a jump that nobody accepted."""


@dataclasses.dataclass
class Column:
    """Of one name. values: numbers, or the texts of a file of text. unit: as the file states it, or ''."""

    name: str
    values: object
    unit: str = ""


@dataclasses.dataclass
class Table:
    """places: the line of each row in a file of text; None where rows are counted."""

    file: object
    kind: str
    columns: list
    places: object = None
    notes: list = dataclasses.field(default_factory=list)  # what was left out, a line each
    about: list = dataclasses.field(default_factory=list)  # name and text, to stand in what is written of it

    def __post_init__(self):
        if not self.columns or not len(self.columns[0].values):
            raise Unusable(f"{self.file}: no row of numbers: expected columns of time and position")
        counts = collections.Counter(self.names)
        twice = [name for name, count in counts.items() if count > 1]
        if twice:  # none of them is found by its name then
            self.columns = [dataclasses.replace(column, name=f"{column.name} (#{k})" if column.name in twice
                                                else column.name) for k, column in enumerate(self.columns, 1)]
            self.notes.append(f"names given twice: {', '.join(twice)}; called by their number")
        self._numbers = {}

    @property
    def rows(self):
        return len(self.columns[0].values)

    @property
    def names(self):
        return [column.name for column in self.columns]

    def place(self, row):
        return f"{self.file}:{self.places[row]}" if self.places is not None else f"{self.file}: row {row + 1}"

    def find(self, name, option):
        """By name, or #N from 1."""
        for column in self.columns:
            if column.name == name:
                return column
        if name.startswith("#") and name[1:].isdecimal() and 1 <= int(name[1:]) <= len(self.columns):
            return self.columns[int(name[1:]) - 1]
        near = ", ".join(self.names[:12]) + (", ..." if len(self.names) > 12 else "")
        raise Unusable(f"{self.file}: {option}: column '{name}': missing: expected one of {near}, or #1 to "
                       f"#{len(self.columns)}")

    def numbers(self, column):
        """Not finite where it is no number. Whole numbers stay whole: nanoseconds since 1970 are no double."""
        if column.name not in self._numbers:
            self._numbers[column.name] = as_numbers(column.values)
        return self._numbers[column.name]

    def finite(self, column, rows):
        """The numbers of these rows, all of them finite."""
        values = self.numbers(column)[rows]
        bad = numpy.flatnonzero(~numpy.isfinite(values))
        if len(bad):
            row = rows[bad[0]]
            raise Unusable(f"{self.place(row)}: column {column.name}: value '{str(column.values[row])[:40]}': expected "
                           "a finite number; --drop-invalid leaves such rows out")
        return values


def as_numbers(values):
    if isinstance(values, numpy.ndarray):
        is_whole = values.dtype.kind in "iu" and values.max() < 2**63
        return values.astype(numpy.int64 if is_whole else float)
    if any("_" in value for value in values):  # which Python takes for a separator of thousands
        return numpy.array([numpy.nan if "_" in value else as_number(value) for value in values])
    try:
        whole = numpy.array([int(value) for value in values], object)
        if max(map(abs, whole)) < 2**63:
            return whole.astype(numpy.int64)
    except ValueError:
        pass
    try:
        return numpy.array(values, float)
    except ValueError:
        return numpy.array([as_number(value) for value in values])


def as_number(text):
    try:
        return float(text)
    except (ValueError, TypeError):
        return numpy.nan


def columns_of(name, array, unit=""):
    """Of an array whose first axis is the rows: NAME, or NAME[0], NAME[1] row by row of what is left."""
    flat = array.reshape(len(array), -1)
    if array.ndim == 1:
        return [Column(name, array, unit)]
    return [Column(f"{name}[{k}]", flat[:, k], unit) for k in range(flat.shape[1])]


def rows_first(array):
    """A 3 x N array of a laboratory that counts the other way, or 3 x 3 x N, with its rows first."""
    array = numpy.squeeze(array) if array.size > 1 else array.reshape(-1)
    if array.ndim == 2 and array.shape[0] <= 32 < array.shape[1]:
        return array.T
    if array.ndim == 3 and array.shape[:2] in ((3, 3), (4, 4)) and array.shape[2] > 4:
        return numpy.moveaxis(array, 2, 0)
    return array


def table_of_arrays(file, kind, arrays, within, notes=()):
    """arrays: (name, array, unit). Those of one length make the table: of the length that most columns have."""
    if within:
        stem = within.rstrip("/.")
        arrays = [(name[len(stem):].lstrip("/.") or name.rpartition("/")[2], array, unit)
                  for name, array, unit in arrays
                  if name == stem or name.startswith((stem + "/", stem + "."))]
        if not arrays:
            raise Unusable(f"{file}: --within: value '{within}': expected the start of an array's name")
    arrays = [(name, rows_first(array), unit) for name, array, unit in arrays
              if array.dtype.kind in "iuf" and array.size > 1]
    by_length = {}
    for name, array, unit in arrays:
        by_length.setdefault(len(array), []).extend(columns_of(name, array, unit) if array[0].size <= 64 else [])
    by_length = {length: columns for length, columns in by_length.items() if columns}
    if not by_length:
        raise Unusable(f"{file}: no array of numbers: expected columns of time and position")
    rows = max(by_length, key=lambda length: (min(len(by_length[length]), 4), length))
    others = [f"{len(columns)} columns of {length} rows ({', '.join(column.name for column in columns[:4])}"
              f"{', ...' if len(columns) > 4 else ''})" for length, columns in by_length.items() if length != rows]
    if others:
        notes = [*notes, f"left out: {'; '.join(others)}; --within NAME takes what is below NAME"]
    return Table(file, kind, by_length[rows], notes=list(notes))
