"""Reads messages of ROS 2: CDR (OMG DDSI-RTPS, plain, either byte order), by the definition that a bag holds beside
them (https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html)."""
import re
import struct

PRIMITIVES = {"bool": "?", "byte": "B", "char": "B", "uint8": "B", "int8": "b", "uint16": "H", "int16": "h",
              "uint32": "I", "int32": "i", "uint64": "Q", "int64": "q", "float32": "f", "float64": "d"}
FIELD = re.compile(r"([\w/]+)(?:<=\d+)?(\[(<=)?(\d*)\])?\s+([A-Za-z]\w*)(?!\s*=)(?:\s+.*)?")
DEEPEST = 16
LONGEST_SHOWN = 64  # of arrays: longer ones are clouds and pictures


def definitions(text):
    """Of a definition with those it names below it: by type its fields (type, None or length, name); '' is the first."""
    types, fields = {}, []
    types[""] = fields
    for line in text.splitlines():
        line = line.split("#")[0].strip()
        if line.startswith("MSG:"):
            fields = types.setdefault(line[4:].strip(), [])
        elif match := FIELD.fullmatch(line):
            kind, is_list, is_bounded, length, name = match.groups()
            size = None if not is_list else int(length) if length and not is_bounded else -1
            fields.append((kind, size, name))
    return types


class Reader:
    """Of one message. ValueError and struct.error where it is not as its definition says."""

    def __init__(self, types, data):
        if len(data) < 4 or data[0] != 0 or data[1] > 1:
            raise ValueError("expected messages in plain CDR")
        self.types, self.data, self.at, self.order = types, data[4:], 0, "<" if data[1] else ">"
        self.found = {}

    def number(self, code):
        size = struct.calcsize("=" + code)
        self.at += -self.at % size
        (value,) = struct.unpack_from(self.order + code, self.data, self.at)
        self.at += size
        return value

    def message(self, fields, prefix, owner, depth=0):
        if depth > DEEPEST:
            raise ValueError("a type that holds itself")
        for kind, size, name in fields:
            name = f"{prefix}.{name}" if prefix else name
            if size is None:
                self.value(kind, name, owner, depth)
                continue
            count = self.number("I") if size < 0 else size
            if count > len(self.data):
                raise ValueError(f"a list of {count} in a message of {len(self.data)} bytes")
            if kind in PRIMITIVES and count > LONGEST_SHOWN:
                width = struct.calcsize("=" + PRIMITIVES[kind])
                self.at += -self.at % width + width * count
                continue
            for k in range(count):
                self.value(kind, f"{name}[{k}]", owner, depth)

    def value(self, kind, name, owner, depth):
        if kind in PRIMITIVES:
            value = self.number(PRIMITIVES[kind])
            if not isinstance(value, bool):
                self.found[name] = value
        elif kind in ("string", "wstring"):
            count = self.number("I")
            self.at += count if kind == "string" else 4 * count
        else:
            full = next((full for full in (kind, f"{owner}/{kind}", kind.replace("/msg/", "/"))
                         if full in self.types), None)
            if full is None:
                raise ValueError(f"no definition of {kind}")
            self.message(self.types[full], name, full.split("/")[0], depth + 1)


def flat(types, schema_name, data):
    """The numbers of a message: pose.position.x, data[0]."""
    reader = Reader(types, data)
    reader.message(types[""], "", schema_name.split("/")[0])
    if reader.at > len(reader.data):
        raise ValueError(f"a message of {len(reader.data)} bytes: shorter than its definition")
    return reader.found
