"""The hand's path that is made of a table: its units ours, its time from zero, its gaps and jumps known."""
import dataclasses
import datetime

import numpy

import rotations
from mapping import QUANTITIES
from table import Unusable


@dataclasses.dataclass
class Trajectory:
    """rows: of the table, for messages. turns: x, y, z, w, or None; so force_N."""

    table: object
    rows: numpy.ndarray
    time_s: numpy.ndarray
    position_m: numpy.ndarray
    turns: object = None
    force_N: object = None
    repeated: int = 0  # rows left out because the next has the same stamp
    invalid: int = 0  # and because a value is missing, where that was asked for

    def kept(self, which):
        """These rows, time from the first of them."""
        def of(values):
            return None if values is None else values[which]
        time_s = self.time_s[which]
        return dataclasses.replace(self, rows=self.rows[which], time_s=time_s - time_s[0],
                                   position_m=self.position_m[which], turns=of(self.turns), force_N=of(self.force_N))


def make(table, choices, rate_hz=None, drops_invalid=False):
    """choices: by quantity, each with its unit."""
    rows = numpy.arange(table.rows)
    if drops_invalid:
        is_good = numpy.ones(table.rows, bool)
        for choice in choices.values():
            for column in choice.columns():
                if choice.unit != "iso":
                    is_good &= numpy.isfinite(table.numbers(column))
        rows = numpy.flatnonzero(is_good)
    if len(rows) < 2:
        raise Unusable(f"{table.file}: {len(rows)} rows: expected 2 at least")
    time_s = rows / rate_hz if rate_hz else times_s(table, choices["time"], rows)
    check_order(table, choices, rows, time_s)
    kept = numpy.append(numpy.diff(time_s) > 0.0, True)
    trajectory = Trajectory(table, rows[kept], time_s[kept] - time_s[kept][0], None,
                            repeated=int((~kept).sum()), invalid=table.rows - len(rows))
    if len(trajectory.rows) < 2:
        raise Unusable(f"{table.file}: one stamp in all rows: expected a time that grows")
    trajectory.position_m = vectors(table, choices["position"], trajectory.rows)
    if "force" in choices:
        trajectory.force_N = vectors(table, choices["force"], trajectory.rows)
    if "orientation" in choices:
        trajectory.turns = turns_of(table, choices["orientation"], trajectory.rows)
    return trajectory


def times_s(table, choice, rows):
    term = choice.terms[0]
    if choice.unit == "iso":
        return stamps_s(table, term.column, rows)
    values = table.finite(term.column, rows)
    return (values - values[0]) * (term.factor * QUANTITIES["time"][choice.unit])


def stamps_s(table, column, rows):
    try:
        stamps = [datetime.datetime.fromisoformat(str(column.values[row]).strip()) for row in rows]
        return numpy.array([(stamp - stamps[0]).total_seconds() for stamp in stamps])
    except (ValueError, TypeError):
        pass
    for row in rows:
        try:
            datetime.datetime.fromisoformat(str(column.values[row]).strip())
        except ValueError:
            raise Unusable(f"{table.place(row)}: column {column.name}: value '{str(column.values[row])[:40]}': "
                           "expected a date and time, such as 2024-05-01 12:00:00.250") from None
    raise Unusable(f"{table.file}: column {column.name}: expected stamps all with a time zone, or all without")


def check_order(table, choices, rows, time_s):
    back = numpy.flatnonzero(numpy.diff(time_s) < 0.0)
    if len(back):
        row, column = rows[back[0] + 1], choices["time"].terms[0].column
        raise Unusable(f"{table.place(row)}: column {column.name}: value '{column.values[row]}': expected a time not "
                       f"before that of the row above, '{column.values[rows[back[0]]]}'")


def vectors(table, choice, rows):
    size = QUANTITIES[choice.quantity].get(choice.unit, 1.0) if choice.quantity != "orientation" else 1.0
    values = [numpy.zeros(len(rows)) if term.column is None
              else table.finite(term.column, rows) * (term.factor * size) for term in choice.terms]
    return numpy.stack(values, axis=1)


def turns_of(table, choice, rows):
    names = ", ".join(column.name for column in choice.columns())

    def refuse(row, text):
        return f"{table.place(rows[row])}: columns {names}: {text}"

    return rotations.quaternions(vectors(table, choice, rows), choice.unit, refuse)


def resampled(trajectory, rate_hz):
    """Rows evenly, straight and turned evenly between the old ones. Filters nothing."""
    count = int(numpy.floor(trajectory.time_s[-1] * rate_hz * (1.0 + 1e-12))) + 1
    if not 2 <= count <= 10**8:
        raise Unusable(f"--resample: value {rate_hz:g}: {count} rows: expected 2 to 100000000")
    at_s = numpy.minimum(numpy.arange(count) / rate_hz, trajectory.time_s[-1])

    def of(values):
        return None if values is None else numpy.stack(
            [numpy.interp(at_s, trajectory.time_s, column) for column in values.T], axis=1)

    turns = None if trajectory.turns is None else rotations.between(trajectory.time_s, trajectory.turns, at_s)
    return dataclasses.replace(trajectory, rows=None, time_s=at_s, position_m=of(trajectory.position_m), turns=turns,
                               force_N=of(trajectory.force_N))


def lost_m(before, after):
    """How far the path that was resampled is from a row that was there, at most."""
    inside = before.time_s <= after.time_s[-1]
    there = numpy.stack([numpy.interp(before.time_s[inside], after.time_s, column) for column in after.position_m.T], 1)
    return float(numpy.linalg.norm(there - before.position_m[inside], axis=1).max())
