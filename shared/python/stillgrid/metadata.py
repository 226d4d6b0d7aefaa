"""Metadata of a recording: in a file beside the CSV, or in lines above the CSV that stillgrid_import wrote."""
from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Iterable


def metadata_file(file: str | os.PathLike[str]) -> pathlib.Path:
    return pathlib.Path(f"{os.fspath(file)}-metadata.json")


def metadata_of(file: str | os.PathLike[str], lines: Iterable[str]) -> dict[str, str]:
    """By key; {} where nothing is told. lines: of the CSV, for "# key: value". ValueError names the file and what was
    expected."""
    beside = metadata_file(file)
    try:
        told = {str(key): str(value) for key, value in json.loads(beside.read_bytes())["notes"][0].items()}
    except FileNotFoundError:
        told = {}
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        raise ValueError(f"{beside}: cannot be read: expected metadata as haptic_server --record writes") from None
    comments = (line[1:].strip() for line in lines if line.startswith("#"))
    return told or dict(line.split(": ", 1) for line in comments if ": " in line)
