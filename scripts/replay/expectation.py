"""Files of expected forces: CSV, compressed where the name ends in .gz."""
import gzip
import json
import pathlib
import shutil
import zlib


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


def metadata_file(file):
    """Where haptic_server tells of a recording: docs/formats.md."""
    return pathlib.Path(f"{file}-metadata.json")


def metadata_of(file):
    """By key; {} where nothing stands beside the file."""
    beside = metadata_file(file)
    try:
        return {str(key): str(value) for key, value in json.loads(beside.read_bytes())["notes"][0].items()}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        raise Unusable(f"{beside}: cannot be read: expected metadata as haptic_server --record writes") from None


def keep(recording, file):
    """A copy that appears whole or not at all; compressed, the same bytes for the same forces. Its metadata beside."""
    if metadata_file(recording).is_file():
        shutil.copyfile(metadata_file(recording), metadata_file(file))
    content = recording.read_bytes()
    part = file.with_name(file.name + ".part")
    try:
        part.write_bytes(gzip.compress(content, mtime=0) if file.suffix == ".gz" else content)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def of_hand(file, name):
    """FILE.csv of a hand is FILE.NAME.csv, as scripts/launch has it; FILE.csv.gz is FILE.NAME.csv.gz."""
    kind = "".join(file.suffixes[-2:]) if file.suffix == ".gz" else file.suffix
    return file.with_name(f"{file.name.removesuffix(kind)}.{name}{kind}")
