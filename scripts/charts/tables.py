"""Tables of measurements: CSV files with a header, and notes in lines that begin with #."""
import csv
import pathlib
import sys


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


def write_rows(file, rows):
    with open(file, "w", newline="") as stream:
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
