"""The options of stillgrid_import, each value checked."""
import argparse
import math
import pathlib

from table import Unusable


def number_in(low, high, what):
    def read(text):
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"value '{text}': expected {what}")
        return value
    return read


def accepted(text):
    kinds = {kind.strip() for kind in text.split(",")}
    if not kinds <= {"gaps", "jumps"}:
        raise argparse.ArgumentTypeError(f"value '{text}': expected gaps, jumps or gaps,jumps")
    return kinds


def delimiter(text):
    text = {"tab": "\t", "\\t": "\t", "blanks": " "}.get(text, text)
    if len(text) != 1 or text.isalnum() or text in '".+-\n\r':
        raise argparse.ArgumentTypeError(f"value '{text}': expected one character, tab or blanks")
    return text


class OneLine(argparse.ArgumentParser):
    def error(self, message):
        raise Unusable(message.removeprefix("argument "))


def parse(text, version):
    """text: what the program does. version: gives its version."""
    parser = OneLine(prog="stillgrid_import", description=text,
                     formatter_class=argparse.RawDescriptionHelpFormatter)
    seconds, hertz = number_in(0.0, 1e9, "seconds, zero or more"), number_in(1e-3, 1e6, "hertz, from 0.001 to 1e6")
    parser.add_argument("raw", metavar="RAW", type=pathlib.Path)
    parser.add_argument("--out", metavar="FILE.csv", type=pathlib.Path,
                        help="write the trajectory; default: a look only")
    parser.add_argument("--picture", metavar="FILE.png", type=pathlib.Path, help="draw it, gaps and jumps marked")
    parser.add_argument("--time", metavar="COLUMN[:UNIT]", help="when a row was taken")
    parser.add_argument("--rate", metavar="HZ", type=hertz, help="instead of --time: rows come evenly")
    parser.add_argument("--position", metavar="X,Y,Z[:UNIT]", help="where the tool was")
    parser.add_argument("--orientation", metavar="COLUMNS[:KIND]", help="how it was turned; none: leave it out")
    parser.add_argument("--force", metavar="X,Y,Z[:UNIT]", help="the force on the hand; none: leave it out")
    parser.add_argument("--within", metavar="NAME", help="only arrays below this name (data/demo_3, run.robot), or "
                        "this topic")
    parser.add_argument("--delimiter", metavar="CHARACTER", type=delimiter, help="of a file of text; tab; blanks; "
                        "default: the one that fits")
    parser.add_argument("--drop-invalid", action="store_true", help="leave out rows where a value that is used is "
                        "missing; the gap is judged as any other")
    parser.add_argument("--from", dest="start", metavar="S", type=seconds, default=0.0,
                        help="of the time from zero, where to begin")
    parser.add_argument("--to", dest="end", metavar="S", type=seconds, default=math.inf, help="and where to end")
    parser.add_argument("--resample", metavar="HZ", type=hertz, help="even rows, straight between the old ones, "
                        "filtered by nothing; replay itself plays rows of any rate")
    parser.add_argument("--max-gap", metavar="MS", type=number_in(1e-3, 1e6, "milliseconds, from 0.001 to 1e6"),
                        default=100.0, help="longest time between two rows; default 100")
    parser.add_argument("--max-speed", metavar="M_S", type=number_in(1e-3, 1e3, "m/s, from 0.001 to 1000"), default=5.0,
                        help="what is faster is a jump (beyond 1 mm); default 5; the server disbelieves 20")
    parser.add_argument("--max-turn", metavar="RAD_S", type=number_in(1e-3, 1e4, "rad/s, from 0.001 to 10000"),
                        default=50.0, help="what turns faster is a jump (beyond 0.05 rad); default 50")
    parser.add_argument("--accept", metavar="gaps,jumps", type=accepted, default=set(),
                        help="write although there are such; they are told all the same")
    parser.add_argument("--version", action="version", version=f"stillgrid_import {version()}")
    arguments = parser.parse_args()
    if arguments.rate and arguments.time:
        raise Unusable(f"--rate: value {arguments.rate:g}: expected no such option beside --time")
    if arguments.start >= arguments.end:
        raise Unusable(f"--from: value {arguments.start:g}: expected less than --to, {arguments.end:g}")
    return arguments
