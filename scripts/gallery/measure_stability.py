#!/usr/bin/python3
"""Measures the largest stable stiffness of both servers' product code in closed loop, in virtual
time, over rate, cost of a step, body, device and transition: docs/charts/stability.csv.

Every point of the grid by eight seeds in runs of 20 s, the least of which counts: hours. Cells that the table
has are not measured again, so that a stopped run goes on where it was: to begin anew, take the table away.
"""
import subprocess

from measuring import parser_of, program

DEVICES = ["light", "hand"]
PERIODS_S = [0.1, 0.033, 0.01]
COSTS = [0, 0.1, 0.3333333333, 1]  # of a step, of its period
SECONDS = 20
LIGHT = ["wall", "free:0.05", "free:0.1", "free:0.5", "free:1", "chain"]
# A heavy body on the hand's spring takes long to come to rest, and more so where contact is soft.
HEAVY = {"scene": ["free:5"], "duration": 30, "lowest": 200}
BLOCK = {"scene": ["block"], "friction": 0.3, "duration": SECONDS}
RIVALS = ["restart", "hermite", "extrapolate", "playout"]


def small_maps():
    """A corner of the grid: free bodies at 33 ms."""
    few = {"device": ["light"], "period": [0.033], "latency": [0.1, 1], "scene": ["free:0.1", "free:1"],
           "duration": 6, "seeds": 1, "lowest": 100, "transition": ["hold", "linear", "predict"]}
    yield few | {"jitter": 0.3}
    yield few | {"jitter": 0}


def maps(every):
    """Maps in the order in which they are measured: what matters most comes first."""
    bodies = [{"scene": LIGHT, "duration": SECONDS}, HEAVY, BLOCK]
    base = {"device": DEVICES, "period": PERIODS_S, "latency": COSTS, "jitter": 0.3, "lowest": 100}
    three = {"transition": ["hold", "linear", "predict"]}
    at_once = {"latency": [0.1]}
    regular = {"jitter": 0}
    for body in bodies:
        yield base | three | body
    for body in bodies:
        yield base | three | regular | body | ({} if every or body is not BLOCK else at_once)
    for body in bodies:
        few = {} if every or body is not BLOCK else {"latency": [0.1, 1]}
        yield base | {"transition": RIVALS} | body | few
        yield base | {"transition": "hold", "model": "force_held"} | body | few
    # Simulated as fast as a step allows: a step that takes its whole period.
    fast = {"transition": "hold", "period": [0.004, 0.002, 0.001], "latency": [1], "jitter": 0}
    for body in bodies:
        yield base | fast | body | ({} if every or body is not BLOCK else {"period": [0.004]})
    friction = {"device-friction": 0.04}
    for body in bodies:
        small = {} if every else {"scene": ["free:0.1", "free:1", "chain"]}
        if every or body is bodies[0]:
            yield base | three | at_once | body | friction | small
    yield base | three | at_once | bodies[0] | {"scene": ["wall"], "device": ["none"]}
    if every:
        for body in bodies:
            yield base | {"transition": RIVALS} | regular | body


def command(lab, csv, threads, one_map):
    options = []
    for name, value in one_map.items():
        values = value if isinstance(value, list) else [value]
        options += [f"--{name}", *map(str, values)]
    return [lab, "map", *options, "--threads", str(threads), "--out", csv]


def main():
    parser = parser_of(__doc__, "24 cells: two free bodies, the light device, 33 ms")
    parser.add_argument("--every", action="store_true", help="cells too that docs/charts/stability.csv leaves "
                        "out")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="default: 2")
    arguments = parser.parse_args()
    lab = program(arguments.build, "stability_lab")
    for one_map in small_maps() if arguments.small else maps(arguments.every):
        subprocess.run(command(lab, arguments.charts / "stability.csv", arguments.threads, one_map),
                       check=True)


if __name__ == "__main__":
    main()
