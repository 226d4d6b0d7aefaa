#!/usr/bin/python3
"""Measures the largest stable stiffness of both servers' product code in closed loop, in virtual
time, over body, tool, device and its limits, start, rate, cost of a step and law: docs/charts/stability.csv.

Every point of the grid by eight seeds in runs of 20 s, the least of which counts, and by eight others near it:
some two hours for `predict`, one for the rest, on two processors. What matters most comes first. Cells that
the table has are not measured again, so that a stopped run goes on where it was: to begin anew, take the
table away.
"""
import subprocess

from measuring import parser_of, program

DEVICES = ["light", "hand"]
PERIODS_S = [0.01, 0.033, 0.1]
PROMPT = [0, 0.1]  # costs of a step, of its period
LATE = [0.3333333333, 1]
FREE = [f"free:{mass_kg}" for mass_kg in ("0.02", "0.05", "0.1", "0.2", "0.5", "1", "2", "5")]
STANDING = ["wall", "chain", "spring:0.1", "spring", "floor", "floor:0.5"]  # without the tool
BODIES = [*STANDING, *FREE, "row", "pinch"]
COMPARED = ["wall", "chain", "spring", "floor", "free:0.05", "free:0.1", "free:0.5", "free:1", "free:2",
            "free:5", "row", "pinch"]
SLOW = ["block", "soft"]  # a run takes ten times as long
BASE = {"device": DEVICES, "period": PERIODS_S, "latency": PROMPT, "jitter": 0.3, "lowest": 200}
OUTSIDE = {"scene": STANDING, "from": "outside"}


def small_maps():
    """A corner of the grid."""
    few = {"device": ["light"], "period": [0.1], "latency": [0.1], "jitter": 0.3, "seeds": 2, "lowest": 2000}
    yield few | {"scene": ["wall", "free:0.1", "pinch"], "transition": ["predict", "hold", "linear"]}
    yield few | {"scene": ["floor"], "from": "outside", "limits": ["none", "declared"]}
    yield few | {"scene": ["wall"], "transition": "hold", "model": "constraints"}


def own_maps():
    """Of `predict`."""
    yield BASE | {"scene": BODIES}
    yield BASE | OUTSIDE
    declared = {"limits": "declared", "latency": [0.1]}
    yield BASE | declared | {"scene": BODIES}
    yield BASE | declared | OUTSIDE
    yield BASE | {"scene": ["free:0.1", "free:1", "chain", "pinch"], "latency": LATE}
    yield BASE | {"scene": ["wall", "free:0.5", "floor"], "tool": "2x2", "latency": [0.1]}
    yield BASE | {"scene": ["free:0.5"], "tool": "3x1", "latency": [0.1]}
    slow = {"scene": SLOW, "latency": [0.1]}
    yield BASE | slow | {"period": [0.033, 0.1], "from": ["inside", "outside"]}
    yield BASE | slow | {"period": [0.01]}


def other_maps():
    """Of other laws, where a step costs a tenth of its period; without a cost, of CHAI3D's one loop."""
    prompt = BASE | {"latency": [0.1], "lowest": 50}
    for cells in ({"scene": COMPARED}, {"scene": ["chain", "spring", "floor"], "from": "outside"}):
        yield prompt | cells | {"transition": ["linear", "hold"]}
        yield prompt | cells | {"transition": "hold", "model": ["constraints", "force_held"]}
    yield prompt | {"scene": COMPARED, "transition": "hold", "model": "force_held", "latency": [0]}


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
    for one_map in small_maps() if arguments.small else (*own_maps(), *other_maps()):
        subprocess.run(command(lab, arguments.charts / "stability.csv", arguments.threads, one_map),
                       check=True)


if __name__ == "__main__":
    main()
