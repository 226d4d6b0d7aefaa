"""Reads text: any delimiter, quoted names, comments, lines before the header, a row of units, a decimal comma."""
import collections
import csv
import re

from metadata import metadata_of
from table import Column, Table, Unusable

DELIMITERS = (",", ";", "\t", "|", " ")
COMMENTS = ("#", "%", "//")
NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?|[-+]?(nan|inf)", re.IGNORECASE)
STAMP = re.compile(r"\d{4}-\d\d-\d\d[ T]\d\d:\d\d")
UNIT = re.compile(r"[\[(]?[a-zA-Zµμ°%/^0-9*. -]{0,12}[\])]?")


def split(line, delimiter):
    if delimiter == " ":
        return next(csv.reader([re.sub(r"[ \t]+", " ", line.strip())], delimiter=" ", skipinitialspace=True), [])
    return [field.strip() for field in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]


def is_value(field):
    return bool(NUMBER.fullmatch(field) or STAMP.match(field))


def is_row(fields):
    """Of numbers, some of which may be missing."""
    return len(fields) > 1 and sum(map(is_value, fields)) * 2 > len([field for field in fields if field])


def delimiter_of(lines):
    """The one that most lines agree on, into the most numbers."""
    best, best_score = None, 0
    for delimiter in DELIMITERS:
        rows = (split(line, delimiter) for line in lines)
        counts = collections.Counter(len(fields) for fields in rows if is_row(fields))
        if not counts:
            continue
        fields, agreed = counts.most_common(1)[0]
        # A decimal comma splits a row into more, but then another delimiter is there too.
        is_decimal = delimiter == "," and any(";" in line or "\t" in line for line in lines)
        score = agreed * (1 if is_decimal else 1000 + fields)
        if score > best_score:
            best, best_score = delimiter, score
    return best


def read_text(file, data, delimiter=None):
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in data[:4096]:
            raise Unusable(f"{file}: neither text nor a known format: expected CSV, TSV, MAT, HDF5, NPY, NPZ or "
                           "MCAP") from None
        text = data.decode("latin-1")
    lines = list(enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), 1))
    is_cut = bool(lines[-1][1].strip())  # no newline at the end
    plain = [(number, line) for number, line in lines if line.strip() and not line.lstrip().startswith(COMMENTS)]
    if not plain:
        raise Unusable(f"{file}: no row: expected a header and rows of numbers")
    delimiter = delimiter or delimiter_of([line for _, line in plain[:400]])
    if delimiter is None:
        raise Unusable(f"{file}:{plain[0][0]}: value '{plain[0][1][:40]}': expected columns of numbers, separated by a "
                       "comma, semicolon, tab, bar or blanks; --delimiter names another")
    rows = [(number, split(line, delimiter)) for number, line in plain]
    first = first_row(rows)
    if first is None:
        raise Unusable(f"{file}: no row of numbers: expected some below the header")
    width, notes = len(rows[first][1]), []
    names, units = header_of(rows[:first], lines, rows[first][0], width, delimiter)
    body = rows[first:]
    if is_cut and len(body) > 1 and len(body[-1][1]) < width:
        notes.append(f"left out: line {body[-1][0]}, which was cut off")
        body.pop()
    for number, fields in body:
        if len(fields) != width:
            raise Unusable(f"{file}:{number}: {len(fields)} fields: expected {width}, as in line {rows[first][0]}")
    values = list(map(list, zip(*(fields for _, fields in body))))
    if delimiter != ",":
        values = [[value.replace(",", ".") for value in column] if has_decimal_comma(column) else column
                  for column in values]
    columns = [Column(name, column, unit) for name, column, unit in zip(names, values, units)]
    shown = {"\t": "tab", " ": "blanks", ",": "comma", ";": "semicolon", "|": "bar"}.get(delimiter, delimiter)
    return Table(file, f"text, separated by {shown}", columns, [number for number, _ in body], notes,
                 about_of(file, lines, names))


def about_of(file, lines, names):
    """A recording of haptic_server is in the scene's frame; what reads trajectories knows it by this line."""
    scenes = [line.removeprefix("# scene:").strip() for _, line in lines[:40] if line.startswith("# scene:")]
    if "rendered_fx_N" in names and not scenes:
        try:
            scenes = [metadata_of(file, ()).get("scene", "")]
        except ValueError as error:
            raise Unusable(error) from None
    return [("scene", scenes[0])] if scenes else []


def first_row(rows):
    """Not yet what stands above the header and has a number or two."""
    widths = collections.Counter(len(fields) for _, fields in rows if is_row(fields))
    width = widths.most_common(1)[0][0] if widths else 0
    return next((k for k, (_, fields) in enumerate(rows)
                 if is_row(fields) and (len(fields) == width or all(map(is_value, fields)))), None)


def has_decimal_comma(column):
    return any("," in value for value in column) and not any("." in value for value in column)


def header_of(above, lines, first_line, width, delimiter):
    """Names and units: of the lines above the first row, else of a comment there, else numbers of columns."""
    of_width = [fields for _, fields in above if len(fields) == width]
    units = [""] * width
    if len(of_width) > 1 and all(UNIT.fullmatch(field) for field in of_width[-1]) and any(
            field.strip("[]() ").lower() in KNOWN_UNITS for field in of_width[-1]):
        units = [field.strip("[]() ") for field in of_width.pop()]
    if of_width:
        names = of_width[-1]
    else:
        comments = [split(line.strip().lstrip("#%/").strip(), delimiter) for number, line in lines
                    if number < first_line and line.lstrip().startswith(COMMENTS)]
        names = next((fields for fields in reversed(comments) if len(fields) == width), [""] * width)
    return [name or f"column_{k}" for k, name in enumerate(names, 1)], units


KNOWN_UNITS = {"s", "sec", "ms", "us", "µs", "ns", "m", "mm", "cm", "um", "n", "mn"}
