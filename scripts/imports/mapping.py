"""Which columns are time, position, orientation and force: as given, or as names and values suggest."""
import csv
import dataclasses
import math
import re

from table import Unusable
from units import FORCE_N, LENGTH_M, ROTATIONS, TIME_S, split_unit, unit_of

QUANTITIES = {"time": TIME_S, "position": LENGTH_M, "orientation": ROTATIONS, "force": FORCE_N}


@dataclasses.dataclass
class Term:
    """A column times a factor; of no column: 0."""

    column: object
    factor: float = 1.0

    def text(self):
        if self.column is None:
            return "0"
        name = self.column.name
        name = '"' + name.replace('"', '""') + '"' if re.search(r'[,:*"]', name) else name
        return name if self.factor == 1.0 else f"{name}*{self.factor!r}"


@dataclasses.dataclass
class Choice:
    """unit: as the file or the caller states it; '' where nobody does, and then suggestion is what it may be."""

    quantity: str
    terms: list
    unit: str = ""
    suggestion: str = ""
    is_given: bool = False

    def text(self):
        names = ",".join(term.text() for term in self.terms)
        return f"{names}:{self.unit or self.suggestion}"

    def columns(self):
        return [term.column for term in self.terms if term.column is not None]


def parse(table, quantity, text):
    """COLUMN[*FACTOR],...[:UNIT]; a name with a comma, colon or star in double quotes; NAME for NAME[0], ..."""
    option, units = f"--{quantity}", QUANTITIES[quantity]
    names, unit = text, ""
    head, colon, tail = text.rpartition(":")
    if colon and '"' not in tail and not any(text.endswith(name) for name in table.names if ":" in name):
        names, unit = head, tail.strip()
        if unit not in units:
            raise Unusable(f"{option}: value '{tail}': expected one of {', '.join(units)} after the colon")
    terms = [term for part in fields(names) for term in terms_of(table, option, part)]
    of_kind = {ROTATIONS[unit]} if unit in ROTATIONS else set(ROTATIONS.values())
    wanted = {"time": {1}, "orientation": of_kind}.get(quantity, {3})
    if len(terms) not in wanted:
        raise Unusable(f"{option}: value '{text}': {len(terms)} columns: expected "
                       f"{' or '.join(map(str, sorted(wanted)))}")
    if quantity == "time" and terms[0].column is None:
        raise Unusable(f"{option}: value '{text}': expected a column; --rate HZ where there is none")
    return Choice(quantity, terms, unit or stated(terms, units), is_given=True)


def stated(terms, units):
    """The unit that all of the columns state, by the file or their names, if they are not scaled."""
    found = {unit_of(term.column.unit, units) or split_unit(term.column.name, units)[1]
             for term in terms if term.column is not None}
    return found.pop() if len(found) == 1 and all(term.factor == 1.0 for term in terms) else ""


def fields(names):
    """Split at commas that stand in no quotes; a part keeps its quotes."""
    return [part.strip() for part in re.findall(r'(?:"(?:[^"]|"")*"|[^,"])+', names)]


def terms_of(table, option, part):
    if part == "0" and "0" not in table.names:
        return [Term(None)]
    match = re.fullmatch(r'("(?:[^"]|"")*"|.*?)(?:\*([^*]+))?', part)
    name, factor = match[1], 1.0
    if part in table.names:
        name = part
    elif match[2]:
        try:
            factor = float(match[2])
        except ValueError:
            factor = math.nan
        if not math.isfinite(factor):
            raise Unusable(f"{option}: value '{part}': expected a number after the star")
    if name.startswith('"'):
        name = next(csv.reader([name]))[0]
    parts = [column for column in table.columns if re.fullmatch(re.escape(name) + r"\[\d+\]", column.name)]
    if parts and name not in table.names:
        return [Term(column, factor) for column in parts]
    return [Term(table.find(name, option), factor)]
