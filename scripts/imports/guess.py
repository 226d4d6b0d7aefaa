"""Guesses the columns of a file by their names and values. A unit that nothing states is only suggested."""
import re

import numpy

from mapping import Choice, Term
from text_table import STAMP
from units import FORCE_N, LENGTH_M, TIME_S, split_unit, unit_of

TIME = re.compile(r"(.*[^a-z])?(time|t|timestamps?|stamp|log_?time|secs?|seconds|ms|millis|elapsed|zeit|tijd|temps)"
                  r"([^a-z].*)?")
COUNTER = re.compile(r"(.*[^a-z])?(frame|sample|index|row|count|seq|id|no)([^a-z].*)?")
FORCE = re.compile(r"(^|[^a-z])f[\[_ .-]?\?|force|load(?!ed)")
TURN = re.compile(r"(^|[^a-z])q[\[_ .-]?\?|quat|orient|rot(?!or)|(^|[^a-z])r(ot)?m?\[\?")
LIKE_TURN = re.compile(r"(.*[^a-z])?(roll|pitch|yaw|eul(er)?|rpy|quat(ernion)?s?|orientation|rot(ation)?(matrix)?|dcm"
                       r"|r[xyz]|q[_. ]?[wxyz]|(r|m|rot)_?[0-3][_,]?[0-3])([^a-z].*|[wxyz])?")
POSITION = re.compile(r"pos|tip|tcp|trans(?!form)|point|loc|coord|(^|[^a-z])(ee|p|tool)([^a-z]|$)|^[_ .\[]*\?")
NO_POSITION = re.compile(r"torque|moment|(^|[^a-z])[tmvawg][\[_ .-]?\?|tau|vel|speed|acc|omega|gyro|mag|dot|twist|joint"
                         r"|err")
COMMANDED = re.compile(r"goal|target|desired|cmd|command|ref|master")
AXIS = (re.compile(r"(.*?)(?<![a-z])([xyzw])(?![a-z])(.*)", re.I), re.compile(r"(.*[a-z])([xyzw])(?![a-z])(.*)", re.I),
        re.compile(r"(.*?)(?<![a-z])([xyzw])(pos.*|quat.*|coord.*)", re.I))


class Group:
    """Columns whose names differ by axis (x, y, z, w) or by number. stem: the name with ? in that place."""

    def __init__(self, stem):
        self.stem, self.parts = stem.lower(), {}

    def terms(self, parts):
        return [Term(self.parts[part][0]) for part in parts]

    def unit(self, parts):
        units = {self.parts[part][1] for part in parts}
        return units.pop() if len(units) == 1 else ""


def groups_of(table, known):
    groups = {}

    def put(stem, part, column, unit):
        groups.setdefault(stem, Group(stem)).parts.setdefault(part, (column, unit))

    for column in table.columns:
        name, unit = split_unit(column.name, known)
        unit = unit_of(column.unit, known) or unit
        name = re.sub(r"(?<=[a-z])(?=[XYZW]\b)", "_", name)  # posX
        for pattern in AXIS:
            if match := pattern.fullmatch(name):
                put(f"{match[1]}?{match[3]}", match[2].lower(), column, unit)
                break
        if match := re.fullmatch(r"(.*?)(\[?)(\d+)(\]?)", name):
            put(f"{match[1]}{match[2]}?{match[4]}", int(match[3]), column, unit)
    return list(groups.values())


def numbered(group):
    parts = sorted(part for part in group.parts if isinstance(part, int))
    return parts if parts and parts == list(range(parts[0], parts[0] + len(parts))) else []


def axes_of(group, lengths):
    """x, y and z of a group, or the first three of so many numbers."""
    parts = [part for part in "xyz" if part in group.parts]
    if len(parts) == 3:
        return parts
    numbers = numbered(group)
    return numbers[:3] if len(numbers) in lengths else []


def is_varying(table, terms):
    return all(numpy.isfinite(table.numbers(term.column)).mean() > 0.5 for term in terms)


def guess(table):
    """By quantity, what was found of time, position, orientation and force."""
    found = {"position": guess_position(table), "orientation": guess_orientation(table), "force": guess_force(table)}
    taken = [column.name for choice in found.values() if choice for column in choice.columns()]
    found["time"] = guess_time(table, taken)
    return {name: choice for name, choice in found.items() if choice}


def guess_time(table, taken):
    best, best_score = None, 0
    for column in table.columns:
        name, unit = split_unit(column.name, TIME_S)
        unit = unit_of(column.unit, TIME_S) or unit
        if isinstance(column.values, list) and STAMP.match(column.values[0]):
            return Choice("time", [Term(column)], "iso")
        values = table.numbers(column)
        steps = numpy.diff(values[numpy.isfinite(values)])
        is_named = TIME.fullmatch(name.lower()) or TIME.fullmatch(column.name.lower())
        grows = len(steps) and (steps >= 0).mean() > 0.9 and (steps > 0).mean() > 0.2
        is_other = not grows or COUNTER.fullmatch(name.lower()) or column.name in taken
        score = 0 if is_other else 10 + bool(unit) if is_named else 1
        if score > best_score:
            best = Choice("time", [Term(column)], unit if is_named else "", time_unit_like(steps))
            best_score = score
    return best


def still_time(table):
    """A column that is called a time and the first row where it does not grow, or None."""
    for column in table.columns:
        name = split_unit(column.name, TIME_S)[0].lower()
        rows = numpy.flatnonzero(numpy.diff(table.numbers(column)) <= 0) + 1
        if TIME.fullmatch(name) and not COUNTER.fullmatch(name) and len(rows):
            return column, rows[0]
    return None


def time_unit_like(steps):
    """The unit by which rows come at a rate of recordings: 5 Hz to 5 kHz, s before ms before us."""
    typical = float(numpy.median(steps[steps > 0])) if (steps > 0).any() else 1.0
    return next((unit for unit in ("s", "ms", "us", "ns") if 2e-4 <= typical * TIME_S[unit] <= 0.2), "s")


def guess_position(table):
    best, best_score = None, 0
    for group in groups_of(table, LENGTH_M):
        parts, numbers = axes_of(group, (3, 6, 7)), numbered(group)
        if len(parts) == 3 and is_varying(table, group.terms(parts)):
            if "w" in group.parts or any(kind.search(group.stem) for kind in (FORCE, TURN, NO_POSITION)):
                continue
            unit, is_named = group.unit(parts), POSITION.search(group.stem)
            score = 2 + 4 * bool(is_named) + 2 * bool(unit) - bool(COMMANDED.search(group.stem))
            if score > best_score:
                best, best_score = Choice("position", group.terms(parts), unit), score
        elif is_transform(table, group, numbers):
            at = (12, 13, 14) if has_columns_first(table, group, numbers) else (3, 7, 11)
            if best_score < 5:
                best, best_score = Choice("position", group.terms([numbers[k] for k in at])), 5
    if best:
        extent = max(numpy.ptp(values[numpy.isfinite(values)]) for values in map(table.numbers, best.columns()))
        best.suggestion = "mm" if extent > 3.0 else "m"
    return best


def is_transform(table, group, numbers):
    """Of 16 numbers, the last of them 1: a pose as a matrix of 4 x 4."""
    return len(numbers) == 16 and bool((table.numbers(group.parts[numbers[15]][0]) == 1).all())


def has_columns_first(table, group, numbers):
    return all((table.numbers(group.parts[numbers[k]][0]) == 0).all() for k in (3, 7, 11))


def guess_orientation(table):
    best, best_score = None, 0
    for group in groups_of(table, {}):
        numbers, choice = numbered(group), None
        if all(part in group.parts for part in "xyzw"):
            choice, score = Choice("orientation", group.terms("xyzw"), "xyzw"), 6
        elif is_transform(table, group, numbers):
            first = (0, 1, 2, 4, 5, 6, 8, 9, 10)
            unit = "matrix_columns" if has_columns_first(table, group, numbers) else "matrix"
            choice, score = Choice("orientation", group.terms([numbers[k] for k in first]), unit), 5
        elif len(numbers) == 9 and (TURN.search(group.stem) or re.search(r"matrix|dcm", group.stem)):
            choice, score = Choice("orientation", group.terms(numbers), "", "matrix"), 4
        elif TURN.search(group.stem) and len(numbers) == 4 or re.search("pose", group.stem) and len(numbers) == 7:
            order = next((word for word in ("xyzw", "wxyz") if word in group.stem), "")
            choice, score = Choice("orientation", group.terms(numbers[-4:]), order, "xyzw"), 3
        elif re.search(r"rotvec|rvec|rotation_?vector|axis_?angle", group.stem):
            parts = list("xyz") if all(part in group.parts for part in "xyz") else numbers
            if len(parts) == 3:
                choice, score = Choice("orientation", group.terms(parts), "", "rotation_vector"), 2
        if choice and is_varying(table, choice.terms):
            score -= 0.5 * bool(COMMANDED.search(group.stem))
            if score > best_score:
                best, best_score = choice, score
    return best


def turn_like(table, choices):
    """Names of columns that are not chosen, three at least, which look like an orientation."""
    chosen = [column.name for choice in choices.values() for column in choice.columns()]
    names = [column.name for column in table.columns
             if LIKE_TURN.fullmatch(column.name.lower()) and column.name not in chosen
             and not re.search(r"rate|torque|moment|vel|speed|acc|omega|gyro|dot", column.name.lower())]
    return names if len(names) > 2 else []


def guess_force(table):
    best, best_score = None, 0
    for group in groups_of(table, FORCE_N):
        parts = axes_of(group, (3, 6))
        if len(parts) == 3 and FORCE.search(group.stem) and is_varying(table, group.terms(parts)):
            score = 2 + bool(group.unit(parts)) - bool(re.search("rendered|command|cmd", group.stem))
            if score > best_score:
                best, best_score = Choice("force", group.terms(parts), group.unit(parts), "N"), score
    return best
