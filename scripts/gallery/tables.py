"""Tables of measurements: CSV files with a header, and notes in lines that begin with #."""
import argparse
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


def draw_table(description, chart, draw, read=read_rows):
    """The whole of a script that draws docs/charts/CHART.png from what read() makes of CHART.csv."""
    charts = pathlib.Path(__file__).resolve().parents[2] / "docs/charts"
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("rows", nargs="?", default=charts / f"{chart}.csv", metavar="ROWS.csv")
    parser.add_argument("picture", nargs="?", default=charts / f"{chart}.png", metavar="OUT.png")
    arguments = parser.parse_args()
    try:
        figure = draw(read(arguments.rows))
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"{pathlib.Path(sys.argv[0]).stem}: {type(error).__name__}: {error}")
    figure.savefig(arguments.picture, dpi=120, facecolor="white")


def write_rows(file, rows):
    with open(file, "w", newline="") as stream:
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
