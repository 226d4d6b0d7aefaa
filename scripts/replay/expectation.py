"""Files of expected forces: CSV, compressed where the name ends in .gz."""
import gzip
import pathlib
import shutil
import zlib

from metadata import metadata_file


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


def write_whole(file, content):
    """A file that appears whole or not at all, where a link leads; what is no file, a pipe, is written to."""
    file = file.resolve()
    if file.exists() and not file.is_file():
        file.write_bytes(content)
        return
    part = file.with_name(file.name + ".part")
    try:
        part.write_bytes(content)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def keep(recording, file):
    """A copy of a recording; compressed, the same bytes for the same forces. Its metadata beside."""
    if metadata_file(recording).is_file():
        shutil.copyfile(metadata_file(recording), metadata_file(file))
    content = recording.read_bytes()
    write_whole(file, gzip.compress(content, mtime=0) if file.suffix == ".gz" else content)


def of_hand(file, name):
    """FILE.csv of a hand is FILE.NAME.csv, as scripts/launch has it; FILE.csv.gz is FILE.NAME.csv.gz."""
    kind = "".join(file.suffixes[-2:]) if file.suffix == ".gz" else file.suffix
    return file.with_name(f"{file.name.removesuffix(kind)}.{name}{kind}")
