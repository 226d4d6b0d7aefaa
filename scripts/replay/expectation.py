"""Files of expected forces: CSV, compressed where the name ends in .gz."""
import contextlib
import gzip
import pathlib
import zlib

from metadata import metadata_file
from whole_file import whole


class Unusable(Exception):
    """One line: the file, where in it, what was expected."""


def content_of(file):
    """The bytes of the CSV."""
    file = pathlib.Path(file)
    try:
        content = file.read_bytes()
        return gzip.decompress(content) if file.suffix == ".gz" else content
    except (EOFError, zlib.error, gzip.BadGzipFile):
        raise Unusable(f"{file}: cannot be read: expected a whole gzip file") from None
    except OSError as error:
        raise Unusable(f"{file}: cannot be read: {error.strerror}") from None


def keep(recording, file):
    """A copy of a recording; compressed, the same bytes for the same forces. Its metadata beside: both, or neither."""
    content, beside = recording.read_bytes(), metadata_file(recording)
    with contextlib.ExitStack() as parts:
        if beside.is_file() and (file.is_file() or not file.exists()):  # a pipe has nothing beside it
            parts.enter_context(whole(metadata_file(file))).write_bytes(beside.read_bytes())
        parts.enter_context(whole(file)).write_bytes(gzip.compress(content, mtime=0) if file.suffix == ".gz"
                                                     else content)


def of_hand(file, name):
    """FILE.csv of a hand is FILE.NAME.csv, as scripts/launch has it; FILE.csv.gz is FILE.NAME.csv.gz."""
    kind = "".join(file.suffixes[-2:]) if file.suffix == ".gz" else file.suffix
    return file.with_name(f"{file.name.removesuffix(kind)}.{name}{kind}")
