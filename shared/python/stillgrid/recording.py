"""Recordings and trajectories: the CSV of docs/formats.md, columns whose names end in their units."""
import csv
import os
import pathlib
from typing import Any

import numpy
from numpy.typing import NDArray

from .metadata import metadata_of


class Recording:
    """Columns by name, arrays of floats (flags: of text), a row a tick; metadata by key.

    Positions, velocities and forces are in the scene's frame; forces are on the hand.
    """

    def __init__(self, metadata: dict[str, str], columns: dict[str, NDArray[Any]], file: str = ""):
        self.metadata = metadata
        self.columns = columns
        self.file = file

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.time_s)

    def vectors(self, name: str, unit: str) -> NDArray[numpy.float64]:
        """Three columns as rows (N, 3): vectors("rendered_f", "N"), vectors("", "m")."""
        return numpy.stack([self.columns[f"{name}{axis}_{unit}"] for axis in "xyz"], axis=1)

    @property
    def time_s(self) -> NDArray[numpy.float64]:
        """(N,), since the loop began."""
        return self.columns["time_s"]

    @property
    def position_m(self) -> NDArray[numpy.float64]:
        """(N, 3), of the tool."""
        return self.vectors("", "m")

    @property
    def velocity_m_s(self) -> NDArray[numpy.float64]:
        """(N, 3), estimated, of the tool."""
        return self.vectors("v", "m_s")

    @property
    def force_N(self) -> NDArray[numpy.float64]:
        """(N, 3), commanded."""
        return self.vectors("f", "N")

    @property
    def rendered_force_N(self) -> NDArray[numpy.float64]:
        """(N, 3), before the safety chain."""
        return self.vectors("rendered_f", "N")

    @property
    def torque_N_m(self) -> NDArray[numpy.float64]:
        """(N, 3), commanded, about the tool's origin."""
        return self.vectors("t", "N_m")

    def force_norm_N(self) -> NDArray[numpy.float64]:
        """(N,)"""
        force_N: NDArray[numpy.float64] = numpy.sqrt(
            self["fx_N"] ** 2 + self["fy_N"] ** 2 + self["fz_N"] ** 2)
        return force_N


def load(file: str | os.PathLike[str]) -> Recording:
    """Reads a recording up to its last whole row. ValueError names the file and what was expected."""
    file = pathlib.Path(file)
    data = file.read_bytes()
    if data.startswith(b"\x89MCAP"):
        raise ValueError(f"{file}: an MCAP file: expected CSV, as stillgrid_import {file.name} --out FILE.csv makes")
    if data.startswith(b"\x1f\x8b"):
        raise ValueError(f"{file}: compressed by gzip: expected CSV, as gunzip {file.name} makes")
    lines = data.decode("utf-8-sig").splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):
        lines.pop()  # cut off in mid-row
    rows = list(csv.reader(line for line in lines if not line.startswith("#") and line.strip()))
    if len(rows) < 2:
        raise ValueError(f"{file}: expected a header and a row at least")
    header = rows[0]
    if name := next((name for name in header if header.count(name) > 1), None):
        raise ValueError(f"{file}: column {name}: given twice")
    for row in rows[1:]:
        if len(row) != len(header):
            raise ValueError(f"{file}: row '{','.join(row)}': {len(row)} fields: expected {len(header)}")
    columns = {name: _column(file, name, column) for name, column in zip(header, zip(*rows[1:]))}
    return Recording(metadata_of(file, lines), columns, str(file))


def save_trajectory(file: str | os.PathLike[str], time_s: Any, position_m: Any) -> None:
    """Writes a hand's path, times (N,) and positions (N, 3) in the device's frame, for the device replay."""
    rows = numpy.column_stack([time_s, position_m])
    numpy.savetxt(file, rows, "%.9g", ",", header="time_s,x_m,y_m,z_m", comments="")


def save_forces(file: str | os.PathLike[str], recording: Recording, every_s: float = 0.01) -> None:
    """Writes what was felt, a row each every_s, as compare_forces() and replay_check take it."""
    due = numpy.floor(recording.time_s / every_s + 1e-9)
    kept = numpy.flatnonzero(numpy.diff(due, prepend=-1.0) > 0.0)
    rows = numpy.column_stack([recording.time_s, recording.force_N])[kept]
    numpy.savetxt(file, rows, "%.9g", ",", header="time_s,fx_N,fy_N,fz_N", comments="")


def compare_forces(got: Recording, expected: Recording, tolerance_N: float = 0.01) -> str | None:
    """What differs first, in one line, at the stamps of what is expected; None: no component by more
    than the tolerance."""
    columns = [name for name in ("fx_N", "fy_N", "fz_N") if name in expected.columns]
    time_s = expected.time_s
    if time_s[-1] > got.time_s[-1] + 1e-9:
        return (f"the run ends at {got.time_s[-1]:.4f} s: expected {time_s[-1]:.4f} s or more "
                f"({expected.file})")
    here = numpy.column_stack([numpy.interp(time_s, got.time_s, got[name]) for name in columns])
    there = numpy.column_stack([expected[name] for name in columns])
    off_N = abs(here - there)
    beyond = numpy.argwhere(~(off_N <= tolerance_N))
    if not len(beyond):
        return None
    row, column = beyond[0]
    return (f"at {time_s[row]:.4f} s, {columns[column]}: expected {there[row, column]:.6g} N, got "
            f"{here[row, column]:.6g} N, tolerance {tolerance_N:g} N; {len(numpy.unique(beyond[:, 0]))} of "
            f"{len(time_s)} rows differ, by {off_N.max():.3g} N at most ({expected.file})")


def _column(file: str | os.PathLike[str], name: str, column: tuple[str, ...]) -> NDArray[Any]:
    if name == "flags":
        return numpy.array(column)
    try:
        return numpy.array(column, float)
    except ValueError as error:
        raise ValueError(f"{file}: column {name}: {error}") from None
