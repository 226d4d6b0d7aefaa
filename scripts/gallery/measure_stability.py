#!/usr/bin/python3
"""Measures the largest stable stiffness of both servers' product code in closed loop, in virtual
time, over body, tool, device and its limits, start, rate, cost of a step and law: docs/charts/stability.csv.

Every point of the grid by eight seeds in runs of 20 s, the least of which counts, and by eight others near it:
some two hours of two processors. What matters most comes first. Cells that the table has are not measured again,
so that a stopped run goes on where it was: to begin anew, take the table away.
"""
import subprocess

from measuring import parser_of, program

DEVICES = ["light", "hand"]
PERIODS_S = [0.01, 0.033, 0.1]
STANDING = ["chain", "spring", "floor"]  # without the tool
BODIES = ["wall", "free:0.05", "free:0.1", "free:0.5", "free:1", "free:2", "free:5", "row", *STANDING, "pinch"]
COMPARED = ["free:0.1", "free:1", "free:5", "row", *STANDING, "pinch"]
BASE = {"device": DEVICES, "period": PERIODS_S, "latency": 0.1, "jitter": 0.3, "lowest": 200}
MEDIUM = BASE | {"period": 0.033}


def small_maps():
    """A corner of the grid."""
    few = {"device": ["light"], "period": [0.1], "latency": [0.1], "jitter": 0.3, "seeds": 2, "lowest": 2000}
    yield few | {"scene": ["wall", "free:0.1", "pinch"], "transition": ["local", "hold", "linear"]}
    yield few | {"scene": ["floor"], "from": "outside", "limits": ["none", "declared"]}
    yield few | {"scene": ["wall"], "transition": "hold", "model": "force_held"}


def maps():
    """By `local` all bodies at one period, as no force depends on it; a part of them at all periods and by every
    law. At no cost, force_held is CHAI3D's one loop."""
    yield MEDIUM | {"scene": BODIES}
    yield from others(MEDIUM)
    yield MEDIUM | {"scene": STANDING, "from": "outside"}
    yield MEDIUM | {"scene": COMPARED, "limits": "declared"}
    yield MEDIUM | {"scene": ["wall", "free:0.5", "floor"], "tool": "2x2"}
    yield MEDIUM | {"scene": "free:0.5", "tool": "3x1"}
    yield BASE | {"scene": COMPARED}
    yield from others(BASE)
    yield MEDIUM | {"scene": ["block", "soft"]}  # a run takes ten times as long


def others(base):
    base = base | {"scene": COMPARED, "lowest": 50}
    yield base | {"transition": ["linear", "hold"]}
    yield base | {"transition": "hold", "model": "force_held"}


def command(lab, csv, threads, one_map):
    options = []
    for name, value in one_map.items():
        values = value if isinstance(value, list) else [value]
        options += [f"--{name}", *map(str, values)]
    return [lab, "map", *options, "--threads", str(threads), "--out", csv]


def main():
    parser = parser_of(__doc__, "12 cells of the longest period and two seeds")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="default: 2")
    arguments = parser.parse_args()
    lab = program(arguments.build, "stability_lab")
    for one_map in small_maps() if arguments.small else maps():
        subprocess.run(command(lab, arguments.charts / "stability.csv", arguments.threads, one_map),
                       check=True)


if __name__ == "__main__":
    main()
