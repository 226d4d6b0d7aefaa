"""Reads an MCAP file (https://mcap.dev/spec) record by record, up to where it was cut off."""
import dataclasses
import struct
import zlib

from binary_tables import package
from limits import room
from table import Unusable

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, METADATA, DATA_END = 3, 4, 5, 6, 12, 15


@dataclasses.dataclass
class Topic:
    encoding: str  # of its messages
    schema_name: str = ""
    schema_encoding: str = ""
    schema: bytes = b""
    messages: list = dataclasses.field(default_factory=list)  # stamp in ns, bytes

    def stamps(self):
        return [stamp for stamp, _ in self.messages]


@dataclasses.dataclass
class Recording:
    """metadata: by name. is_whole: whether the file ends as it should."""

    topics: dict = dataclasses.field(default_factory=dict)
    metadata: dict = dataclasses.field(default_factory=dict)
    is_whole: bool = False


class Fields:
    """What a record holds, one after the other."""

    def __init__(self, body):
        self.body, self.at = body, 0

    def numbers(self, form):
        values = struct.unpack_from("<" + form, self.body, self.at)
        self.at += struct.calcsize("<" + form)
        return values if len(values) > 1 else values[0]

    def bytes(self, form="I"):
        size = self.numbers(form)
        if self.at + size > len(self.body):
            raise ValueError(f"a text of {size} bytes in a record of {len(self.body)}")
        self.at += size
        return bytes(self.body[self.at - size:self.at])

    def text(self):
        return self.bytes().decode("utf-8")

    def map(self):
        inner = Fields(self.bytes())
        found = {}
        while inner.at < len(inner.body):
            key = inner.text()  # before the value: the right side of an assignment comes first
            found[key] = inner.text()
        return found


def read(file, data):
    found, schemas, channels, chunks, left = Recording(), {}, {}, 0, room(len(data))

    def take(code, body):
        nonlocal chunks, left
        fields = Fields(body)
        if code == SCHEMA:
            number = fields.numbers("H")
            schemas[number] = (fields.text(), fields.text(), fields.bytes())
        elif code == CHANNEL:
            number, schema = fields.numbers("HH")
            topic = fields.text()
            known = schemas.get(schema, ("", "", b""))
            channels[number] = found.topics.setdefault(topic, Topic(fields.text(), *known))
        elif code == MESSAGE:
            number, _, log_time_ns = fields.numbers("HIQ")
            if number not in channels or log_time_ns >= 2**63:
                raise ValueError("a message of a channel that is not there")
            channels[number].messages.append((log_time_ns, bytes(body[22:])))
        elif code == METADATA:
            name = fields.text()
            found.metadata[name] = fields.map()
        elif code == CHUNK:
            chunks += 1
            content = chunk_of(file, body, chunks, left)
            left -= len(content)
            for _, *part in records(content):
                take(*part)

    try:
        for at, code, body in records(data, len(MAGIC), may_be_cut=True):
            take(code, body)
            found.is_whole = code == DATA_END
            if found.is_whole:
                check_crc(f"{file}: all up to byte {at}", memoryview(data)[:at], Fields(body).numbers("I"))
                break
    except (struct.error, ValueError) as error:
        raise Unusable(f"{file}: cannot be read: {error}: expected MCAP") from None
    found.topics = {name: topic for name, topic in found.topics.items() if topic.messages}
    for topic in found.topics.values():
        topic.messages.sort(key=lambda message: message[0])
    return found


def check_crc(what, data, told):
    """told: 0 where the file does not state it."""
    if told and zlib.crc32(data) != told:
        raise Unusable(f"{what}: CRC-32 {zlib.crc32(data):08x}: expected {told:08x}, as stated: the file is damaged")


def records(data, offset=0, may_be_cut=False):
    """Where each begins, its code and what it holds."""
    while offset + 9 <= len(data):
        code, size = struct.unpack_from("<BQ", data, offset)
        if offset + 9 + size > len(data):
            if may_be_cut:
                return
            raise ValueError(f"a record of {size} bytes in a chunk of {len(data)}")
        yield offset, code, memoryview(data)[offset + 9:offset + 9 + size]
        offset += 9 + size


def chunk_of(file, body, number, most):
    """What a chunk holds: just as much as it states, and that no more than most."""
    fields = Fields(body)
    _, _, size, crc = fields.numbers("QQQI")
    name, packed = fields.text(), fields.bytes("Q")
    if size > most:
        raise ValueError(f"chunk {number} states {size} bytes, {most} are left of what the file may unpack to")
    content = unpacked(file, number, name, packed, size)
    if len(content) != size:
        raise ValueError(f"chunk {number} states {size} bytes and holds {'more' if len(content) > size else 'fewer'}")
    check_crc(f"{file}: chunk {number}", content, crc)
    return content


def unpacked(file, number, name, packed, size):
    """Up to one byte more than the size: a frame may state more than its chunk does."""
    try:
        if name == "zstd":
            zstandard = package("zstandard", file, "MCAP packed by zstd", "python3-zstandard")
            return zstandard.ZstdDecompressor().stream_reader(packed).read(size + 1)
        if name == "lz4":
            lz4 = package("lz4.frame", file, "MCAP packed by lz4", "python3-lz4")
            return lz4.LZ4FrameDecompressor().decompress(packed, max_length=size + 1)
    except Unusable:
        raise
    except Exception as error:  # whatever the two raise of bad bytes
        raise ValueError(f"chunk {number}, packed by {name}: {error}") from None
    if name:
        raise Unusable(f"{file}: chunk {number}, packed by '{name[:40]}': expected zstd, lz4 or none")
    return packed
