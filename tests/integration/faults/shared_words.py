"""Writes into a running session's shared memory, as only its owner could: docs/protocol.md."""
import os
import pathlib
import time

import numpy

# Bytes from the start of a segment, of a slot, and of a payload.
LATEST, SLOT_OFFSETS, PAYLOAD_BYTES, MATERIALS, STATE_CAPACITY = 256, 64, 80, 1000, 12944
SEQUENCE, PAYLOAD = 0, 64
PUBLISH_TIMES, STATE_BYTES, STATE_TICK, STATE_HASH, FIRST_SPHERE = 32, 80, 88, 96, 512
RADIUS = 48  # in a sphere


def segment_file(session, kind):
    return pathlib.Path(f"/dev/shm/stillgrid-{os.geteuid()}/{session}-{kind}")


class SharedWords:
    """A segment's words in place."""

    def __init__(self, session, kind):
        self._bytes = numpy.memmap(segment_file(session, kind), "u1", "r+")
        self.slots = [int(offset) for offset in self.at(SLOT_OFFSETS, "u8", 2)]

    def at(self, offset, type_, count=1):
        size = numpy.dtype(type_).itemsize * count
        return self._bytes[offset:offset + size].view(type_)

    def states(self):
        """The states of both slots: the room at the end of their payloads."""
        end, room = (int(self.at(place, "u8")[0]) for place in (PAYLOAD_BYTES, STATE_CAPACITY))
        return self.in_slots(PAYLOAD + end - room, "u1", room)

    def in_slots(self, offset, type_, count=1):
        """The same words of both slots."""
        return [self.at(slot + offset, type_, count) for slot in self.slots]


def spoil(places, value, for_s):
    """Writes it there again and again, faster than the writer mends it."""
    until_s = time.monotonic() + for_s
    while time.monotonic() < until_s:
        for place in places:
            place[:] = value
        time.sleep(0.5e-3)
