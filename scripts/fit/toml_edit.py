"""Changes values in the text of a TOML file, and leaves every other byte of it: comments, order, blanks.

A path is a tuple of names, and of numbers for the tables of an array: ("body", 3, "spheres", "spacing_m").
"""
import dataclasses
import json
import re
import tomllib


class Exotic(Exception):
    """The text is written in a way that is not changed safely here."""


@dataclasses.dataclass
class Entry:
    """key = value, as places in the text."""
    path: tuple
    key_start: int
    value_start: int
    value_end: int
    is_inline: bool  # in an inline table


@dataclasses.dataclass
class Table:
    """[name] or [[name]]: where the line of its header, or of its last entry, ends."""
    path: tuple
    end: int


def literal(value):
    """A value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {literal(item)}" for key, item in value.items()) + " }"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


class _Scanner:
    """Finds entries and tables. What it does not know it refuses; tomllib has accepted the text."""

    BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
    SPACE = re.compile(r"[ \t]*")
    BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
    BARE_VALUE = re.compile(r"[^,\]}\s#]+(?: [0-9][^,\]}\s#]*)?")  # the second part: of a date's time
    STRING = re.compile(r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.S)

    def __init__(self, text):
        self.text, self.at = text, 0
        self.entries, self.tables, self.counts = [], [Table((), 0)], {}

    def skip(self, pattern):
        self.at = pattern.match(self.text, self.at).end()

    def take(self, pattern):
        match = pattern.match(self.text, self.at)
        if not match:
            raise Exotic(f"line {self.text.count(chr(10), 0, self.at) + 1}")
        self.at = match.end()
        return match[0]

    def starts(self, what):
        return self.text.startswith(what, self.at)

    def key(self):
        names = []
        while True:
            self.skip(self.SPACE)
            if self.starts('"') or self.starts("'"):
                names.append(next(iter(tomllib.loads(self.take(self.STRING) + " = 0"))))
            else:
                names.append(self.take(self.BARE_KEY))
            self.skip(self.SPACE)
            if not self.starts("."):
                return tuple(names)
            self.at += 1

    def entry(self, table, is_inline):
        start = self.at
        path = table + self.key()
        self.take(re.compile("="))
        self.skip(self.SPACE)
        value_start = self.at
        self.value(path)
        self.entries.append(Entry(path, start, value_start, self.at, is_inline))

    def value(self, path):
        if self.starts("["):
            self.items("]", self.BLANK, lambda: self.value((*path, None)))
        elif self.starts("{"):
            self.items("}", self.SPACE, lambda: self.entry(path, True))
        elif self.starts('"') or self.starts("'"):
            self.take(self.STRING)
        else:
            self.take(self.BARE_VALUE)

    def items(self, end, blank, take_one):
        self.at += 1
        self.skip(blank)
        while not self.starts(end):
            take_one()
            self.skip(blank)
            if self.starts(","):
                self.at += 1
                self.skip(blank)
        self.at += 1

    def resolved(self, names):
        """Of a header: a name that is an array of tables is meant with its last one."""
        path = ()
        for name in names:
            path += (name,)
            if path in self.counts:
                path += (self.counts[path] - 1,)
        return path

    def header(self):
        is_array = self.starts("[[")
        self.at += 2 if is_array else 1
        names = self.key()
        self.take(re.compile(r"\]\]" if is_array else r"\]"))
        if is_array:
            path = self.resolved(names[:-1]) + names[-1:]
            self.counts[path] = self.counts.get(path, 0) + 1
            return (*path, self.counts[path] - 1)
        return self.resolved(names)

    def line_end(self):
        return re.compile(r"\r?\n|\Z").search(self.text, self.at).start()

    def scan(self):
        while True:
            self.skip(self.BLANK)
            if self.at == len(self.text):
                return self
            if self.starts("["):
                self.tables.append(Table(self.header(), self.line_end()))
            else:
                self.entry(self.tables[-1].path, False)
                self.tables[-1].end = self.line_end()


def line_end_of(text):
    return "\r\n" if "\r\n" in text else "\n"


def _set(text, path, value):
    scanned = _Scanner(text).scan()
    for entry in scanned.entries:
        if entry.path == path:
            return text[:entry.value_start] + literal(value) + text[entry.value_end:]
        if entry.path == path[:-1]:  # an inline table without that key
            inside = text[entry.value_start + 1:entry.value_end - 1].strip()
            new = ", ".join(filter(None, (inside, f"{path[-1]} = {literal(value)}")))
            return text[:entry.value_start] + "{ " + new + " }" + text[entry.value_end:]
    tables = {table.path: table for table in scanned.tables}
    if path in tables and isinstance(value, dict):
        for entry in scanned.entries:
            if entry.path[:-1] == path and entry.path[-1] not in value:
                text = _removed(text, entry.path)
        for key, item in value.items():
            text = _set(text, (*path, key), item)
        return text
    line, new = f"{path[-1]} = {literal(value)}", line_end_of(text)
    if path[:-1] in tables:
        end = tables[path[:-1]].end
        return f"{text[:end]}{new}{line}{text[end:]}"
    if len(path) == 2:
        return f"{text.rstrip()}{new}{new}[{path[0]}]{new}{line}{new}"
    raise Exotic(".".join(map(str, path)))


def _removed(text, path):
    """The entry as a comment; in an inline table it is gone."""
    for entry in _Scanner(text).scan().entries:
        if entry.path != path:
            continue
        if not entry.is_inline:
            old = text[entry.key_start:entry.value_end]
            return text[:entry.key_start] + "# " + old.replace("\n", "\n# ") + text[entry.value_end:]
        after = re.compile(r"[ \t]*,[ \t]*").match(text, entry.value_end)
        before = re.search(r",[ \t]*$", text[:entry.key_start])
        if after:
            return text[:entry.key_start] + text[after.end():]
        return text[:before.start() if before else entry.key_start] + text[entry.value_end:]
    return text


def _renamed(text, path, name):
    for entry in _Scanner(text).scan().entries:
        if entry.path == path:
            key = re.compile(r"[A-Za-z0-9_\-\"']+(?=[ \t]*=)").search(text, entry.key_start)
            return text[:key.start()] + name + text[key.end():]
    return text


def _put(document, path, value):
    """The same change on what tomllib reads."""
    for name in path[:-1]:
        document = document.setdefault(name, {}) if isinstance(document, dict) else document[name]
    if value is None:
        document.pop(path[-1], None)
    else:
        document[path[-1]] = value


def edited(text, changes, renamed=()):
    """The text with the values of these paths; None takes an entry out. renamed: (path, new name), done first.

    Throws Exotic where what is read from the new text would be anything but the old with just these changes.
    """
    expected = tomllib.loads(text)
    try:
        for path, name in renamed:
            text = _renamed(text, path, name)
            _put(expected, (*path[:-1], name), 0)
            _put(expected, path, None)
        for path, value in changes.items():
            text = _removed(text, path) if value is None else _set(text, path, value)
            _put(expected, path, value)
        got = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, AttributeError, KeyError, IndexError, TypeError) as error:
        raise Exotic(str(error)) from error
    if got != expected:
        raise Exotic("a value would not read back")
    return text
