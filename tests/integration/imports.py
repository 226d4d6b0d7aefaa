"""Paths of hands that laboratories might have recorded, and what stillgrid_import makes of them."""
import csv
import json
import struct
import subprocess
import sys

import numpy

import daemons

sys.path.insert(1, str(daemons.ROOT / "scripts" / "imports"))
import rotations  # after the path it needs

DONE, FAULTY, COULD_NOT_RUN = 0, 1, 2
IMPORT = daemons.ROOT / "scripts" / "stillgrid_import"
SEEDS = range(1, 6)
TOLERANCE = 1e-9


class Hand:
    """A smooth path of some seconds, stamps that jitter, turned and pushed."""

    def __init__(self, seed, rows=None):
        random = numpy.random.default_rng(seed)
        rows = rows or int(random.integers(150, 400))
        self.time_s = numpy.append(0.0, numpy.cumsum(random.uniform(0.0013, 0.0047, rows - 1)))
        phase = random.uniform(0.0, 6.0, 9)[:, None] + random.uniform(2.0, 7.0, 9)[:, None] * self.time_s
        self.position_m = (0.07 * numpy.sin(phase[:3]) + random.normal(size=3)[:, None] * 0.02).T
        self.vectors_rad = (0.9 * numpy.sin(phase[3:6])).T
        self.turns = rotations.of_vectors(self.vectors_rad)
        self.force_N = (3.7 * numpy.sin(phase[6:])).T

    def matrices(self):
        x, y, z, w = self.turns.T
        return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]).transpose(2, 0, 1)

    def transforms(self):
        whole = numpy.zeros((len(self.time_s), 4, 4))
        whole[:, :3, :3], whole[:, :3, 3], whole[:, 3, 3] = self.matrices(), self.position_m, 1.0
        return whole


def read(file):
    """Columns by name, of what was written."""
    with open(file, encoding="utf-8") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return {name: numpy.array([float(row[name]) for row in rows]) for name in rows[0] if name != "flags"}


def record(code, body):
    return struct.pack("<BQ", code, len(body)) + body


def text_of(text):
    return struct.pack("<I", len(text)) + text.encode()


def mcap(messages, topic, packing=None, name="", crc=lambda data: 0):
    """By the specification at mcap.dev: a header, a channel and its messages, plain or in a chunk, an end. crc: of the
    chunk and of all up to the end; 0 states none."""
    inner = record(4, struct.pack("<HH", 7, 0) + text_of(topic) + text_of("json") + struct.pack("<I", 0))
    inner += b"".join(record(5, struct.pack("<HIQQ", 7, k, stamp, stamp) + json.dumps(message).encode())
                      for k, (stamp, message) in enumerate(messages))
    if packing:
        packed = packing(inner)
        inner = record(6, struct.pack("<QQQI", 0, 0, len(inner), crc(inner)) + text_of(name)
                       + struct.pack("<Q", len(packed)) + packed)
    data = b"\x89MCAP0\r\n" + record(1, text_of("") + text_of("of a test")) + inner
    return (data + record(15, struct.pack("<I", crc(data))) + record(2, struct.pack("<QQI", 0, 0, 0))
            + b"\x89MCAP0\r\n")


def without_crcs(data):
    """An MCAP file that states none, so that what reads behind them is reached."""
    data, at = bytearray(data), 8
    while at + 9 <= len(data) - 8:
        code, size = struct.unpack_from("<BQ", data, at)
        if code in (6, 15):  # a chunk, the end of the data
            struct.pack_into("<I", data, at + 9 + (24 if code == 6 else 0), 0)
        at += 9 + size
    return bytes(data)


class ImportTest(daemons.SessionTest):
    def run_import(self, *arguments, program=IMPORT, **options):
        return subprocess.run(["/usr/bin/python3", *map(str, (program, *arguments))], cwd=self.folder, text=True,
                              capture_output=True, timeout=60 * daemons.PATIENCE, check=False, **options)

    def imported(self, raw, *arguments, **options):
        out = self.folder / "out.csv"
        out.unlink(missing_ok=True)
        run = self.run_import(raw, *arguments, "--out", out, **options)
        self.assertEqual(run.returncode, DONE, run.stdout + run.stderr)
        self.assertEqual(run.stderr, "")
        return read(out)

    def refused(self, status, words, raw, *arguments, **options):
        def there():  # a picture is drawn of faults that are refused
            return {file for file in self.folder.iterdir() if file.name != "seen.png"}

        before = there()
        run = self.run_import(raw, *arguments, "--out", self.folder / "refused.csv", "--picture",
                              self.folder / "refused.png" if status == COULD_NOT_RUN else self.folder / "seen.png",
                              **options)
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        self.assertRegex(run.stderr, r"\Astillgrid_import: .*\n\Z")
        self.assertRegex(run.stderr, words)
        self.assertEqual(there(), before)

    def assert_same(self, got, hand, has_turn=True, has_force=True):
        def stack(*names):
            return numpy.stack([got[name] for name in names], axis=1)

        numpy.testing.assert_allclose(got["time_s"], hand.time_s, rtol=0, atol=TOLERANCE)
        numpy.testing.assert_allclose(stack("x_m", "y_m", "z_m"), hand.position_m, rtol=0, atol=TOLERANCE)
        self.assertEqual((has_turn, has_force), ("qx" in got, "fx_N" in got))
        if has_turn:  # q and -q are one orientation
            turns = stack("qx", "qy", "qz", "qw")
            sign = numpy.sign((turns * hand.turns).sum(axis=1, keepdims=True))
            numpy.testing.assert_allclose(sign * turns, hand.turns, rtol=0, atol=TOLERANCE)
        if has_force:
            numpy.testing.assert_allclose(stack("fx_N", "fy_N", "fz_N"), hand.force_N, rtol=0, atol=TOLERANCE)

    def package(self, name):
        try:
            return __import__(name, fromlist=["_"])
        except ImportError:
            self.skipTest(f"skipped: Python's {name} is absent")
