"""How much a file of strangers may unpack to."""
import gzip
import io
import os
import resource
import stat
import zipfile

from table import Unusable

MIB = 1 << 20
MOST_BYTES = 4096 * MIB  # of a file


def room(packed_bytes):
    """Bytes that a file of so many may unpack to: a hundred times its size, 512 MiB at least."""
    return max(512 * MIB, 100 * packed_bytes)


def refuse(file, fault, most_bytes):
    raise Unusable(f"{file}: cannot be read: {fault}: expected at most {most_bytes // MIB} MiB")


def bytes_of(file):
    """The content of a regular file: a pipe or a device may have no end."""
    try:
        about = os.stat(file)
        if not stat.S_ISREG(about.st_mode):
            raise Unusable(f"{file}: cannot be read: expected a regular file")
        if about.st_size > MOST_BYTES:
            refuse(file, f"{about.st_size // MIB} MiB", MOST_BYTES)
        return file.read_bytes()
    except OSError as error:
        raise Unusable(f"{file}: cannot be read: {error.strerror}") from None


def gunzipped(file, data):
    most = room(len(data))
    content = gzip.GzipFile(fileobj=io.BytesIO(data)).read(most + 1)
    if len(content) > most:
        refuse(file, "unpacks to more", most)
    return content


def check_zip(file, data):
    """By its directory, beyond which zipfile reads no member."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        stated = sum(member.file_size for member in archive.infolist())
    if stated > room(len(data)):
        refuse(file, f"unpacks to {stated // MIB} MiB", room(len(data)))


def limit_memory(packed_bytes):
    """Of this process from here on, for readers that state no sizes; beyond it they raise MemoryError."""
    with open("/proc/self/statm", encoding="ascii") as statm:
        held = int(statm.read().split()[0]) * resource.getpagesize()
    most = held + 2 * room(packed_bytes)
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))
