"""Tables of measurements: CSV files with a header, and notes in lines that begin with #."""
import csv
import io
import os
import pathlib
import sys
import threading


def read_rows(file):
    """The rows as dictionaries; what cannot be read ends the program with one line."""
    try:
        with open(file) as stream:
            rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {file}: {error}")
    if not rows:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {file}: expected a header and a row at least")
    return rows


def read_notes(file):
    """Lines that begin with #, without it."""
    return [line[1:].strip() for line in pathlib.Path(file).read_text().splitlines()
            if line.startswith("#")]


def write_bytes(file, content):
    """The file appears whole or not at all, also where several write it at once."""
    part = file.with_name(f"{file.name}.{os.getpid()}-{threading.get_ident()}.part")
    try:
        part.write_bytes(content)
        os.replace(part, file)
    finally:
        part.unlink(missing_ok=True)


def write_text(file, text):
    write_bytes(file, text.encode())


def write_rows(file, rows, notes=()):
    """Rows are dictionaries of the same keys; notes go before them, in lines that begin with #."""
    text = io.StringIO()
    text.writelines(f"# {note}\n" for note in notes)
    writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(pathlib.Path(file), text.getvalue())
