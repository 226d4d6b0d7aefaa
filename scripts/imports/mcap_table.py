"""Reads MCAP (https://mcap.dev/spec): messages in JSON of one topic, each a row, up to where the file was cut off."""
import json
import struct

import numpy

from binary_tables import package
from table import Column, Table, Unusable

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15


def read_mcap(file, data, within):
    topics, encodings, is_whole = messages_of(file, data)
    if not topics:
        raise Unusable(f"{file}: no message: expected a topic with positions")
    topic = within or max(topics, key=lambda name: (encodings[name] == "json", len(topics[name])))
    if topic not in topics:
        raise Unusable(f"{file}: --within: value '{within}': expected a topic, one of {', '.join(sorted(topics))}")
    if encodings[topic] != "json":
        raise Unusable(f"{file}: topic {topic}: messages encoded as '{encodings[topic]}': expected json")
    notes = [] if is_whole else ["the file was cut off; read up to there"]
    others = [f"{name} ({len(rows)})" for name, rows in sorted(topics.items()) if name != topic]
    if others:
        notes.append(f"left out: topics {', '.join(others)}; --within TOPIC takes another")
    log_time_ns = [stamp for stamp, _ in topics[topic]]
    rows = [flat(file, topic, message) for _, message in topics[topic]]
    names = [name for name in rows[0] if all(name in row for row in rows)]
    columns = [Column("log_time", numpy.array(log_time_ns, numpy.int64), "ns")]
    columns += [Column(name, numpy.array([row[name] for row in rows])) for name in names]
    return Table(file, f"MCAP, topic {topic}", columns, notes=notes)


def flat(file, topic, message):
    """The numbers of a message: pose.position.x, data[0]."""
    found = {}

    def walk(name, value):
        if isinstance(value, dict):
            for key, part in value.items():
                walk(f"{name}.{key}" if name else key, part)
        elif isinstance(value, list) and len(value) <= 64:
            for k, part in enumerate(value):
                walk(f"{name}[{k}]", part)
        elif isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 2**63:
            found[name] = value

    try:
        walk("", json.loads(message))
    except (ValueError, RecursionError):
        raise Unusable(f"{file}: topic {topic}: value '{message[:40]!r}': expected JSON") from None
    return found


def messages_of(file, data):
    """By topic the stamps and bytes, and the encoding; whether the file ends as it should."""
    channels, topics, encodings = {}, {}, {}

    def take(code, body):
        if code == CHANNEL:
            number, _, size = struct.unpack_from("<HHI", body)
            topic = text_at(body, 4, size)
            channels[number] = topic
            (encoding_size,) = struct.unpack_from("<I", body, 8 + size)
            encodings[topic] = text_at(body, 8 + size, encoding_size)
        elif code == MESSAGE:
            number, _, log_time_ns = struct.unpack_from("<HIQ", body)
            if number not in channels or log_time_ns >= 2**63:
                raise ValueError("a message of a channel that is not there")
            topics.setdefault(channels[number], []).append((log_time_ns, bytes(body[22:])))
        elif code == CHUNK:
            for part in records(chunk_of(file, body)):
                take(*part)

    is_whole = False
    try:
        for code, body in records(data[len(MAGIC):], may_be_cut=True):
            take(code, body)
            is_whole = code == DATA_END
            if is_whole:
                break
    except (struct.error, ValueError) as error:
        raise Unusable(f"{file}: cannot be read: {error}: expected MCAP") from None
    for rows in topics.values():
        rows.sort(key=lambda row: row[0])
    return topics, encodings, is_whole


def text_at(body, offset, size):
    if offset + 4 + size > len(body):
        raise ValueError(f"a text of {size} bytes in a record of {len(body)}")
    return bytes(body[offset + 4:offset + 4 + size]).decode("utf-8")


def records(data, may_be_cut=False):
    offset = 0
    while offset + 9 <= len(data):
        code, size = struct.unpack_from("<BQ", data, offset)
        if offset + 9 + size > len(data):
            if may_be_cut:
                return
            raise ValueError(f"a record of {size} bytes in a chunk of {len(data)}")
        yield code, memoryview(data)[offset + 9:offset + 9 + size]
        offset += 9 + size


def chunk_of(file, body):
    _, _, size, _, name_size = struct.unpack_from("<QQQII", body)
    name = text_at(body, 28, name_size)
    (packed_size,) = struct.unpack_from("<Q", body, 32 + name_size)
    packed = bytes(body[40 + name_size:40 + name_size + packed_size])
    if len(packed) != packed_size or size > 2**32:
        raise ValueError(f"a chunk of {packed_size} bytes in a record of {len(body)}")
    try:
        if name == "zstd":
            zstandard = package("zstandard", file, "MCAP packed by zstd", "python3-zstandard")
            return zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        if name == "lz4":
            return package("lz4.frame", file, "MCAP packed by lz4", "python3-lz4").decompress(packed)
    except Unusable:
        raise
    except Exception as error:  # whatever the two raise of bad bytes
        raise ValueError(f"a chunk packed by {name}: {error}") from None
    if name:
        raise Unusable(f"{file}: a chunk packed by '{name[:40]}': expected zstd, lz4 or none")
    return packed
