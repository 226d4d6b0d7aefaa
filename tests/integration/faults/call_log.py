"""What a device was told: the log of faulty_driver.so, laid out in call_log.hpp."""
import pathlib

import numpy

ACTIVATE, WRITE, IGNORED_WRITE, DEACTIVATE, EMERGENCY_STOP, FAULT_BEGINS, FAULT_ENDS = range(1, 8)

_HEADER = numpy.dtype([("count", "u8"), ("trigger", "u8"), ("reserved", "u8", 6)])
_RECORD = numpy.dtype([("time_ns", "u8"), ("tick_ns", "u8"), ("call", "u8"), ("force_N", "f8", 3)])
_CAPACITY = 60_000


class CallLog:
    """A file in memory, so that no disk holds up the driver."""

    def __init__(self, file):
        self.file = pathlib.Path(file)
        bytes_ = numpy.memmap(self.file, "u1", "w+",
                              shape=_HEADER.itemsize + _CAPACITY * _RECORD.itemsize)
        self._header = bytes_[:_HEADER.itemsize].view(_HEADER)
        self._records = bytes_[_HEADER.itemsize:].view(_RECORD)

    def trigger(self):
        """The fault begins with the next call."""
        self._header["trigger"] = 1

    def records(self, first=0):
        """A copy of what stands there, whole records only."""
        count = int(self._header["count"][0])
        if count > _CAPACITY:
            raise RuntimeError(f"{self.file}: {count} calls, expected no more than {_CAPACITY}")
        records = self._records[first:count].copy()
        unfinished = numpy.flatnonzero(records["call"] == 0)
        return records[:unfinished[0]] if len(unfinished) else records


def force_norms_N(records):
    """On the hand after each call: a stop leaves none, whatever is written after."""
    norms_N = numpy.linalg.norm(records["force_N"], axis=1)
    return numpy.where(records["call"] == WRITE, norms_N, 0.0)
