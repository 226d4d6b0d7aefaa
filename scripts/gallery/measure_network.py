#!/usr/bin/python3
"""Measures what a network between simulation and hand costs, in virtual time, over its delay, its loss and the size
of a snapshot.

stability (docs/charts/network_stability.csv): the largest stable stiffness of bodies in the hand, the least of eight
seeds. error (network_error.csv): the force on the hands of shipped scenes against the scene at 1 kHz without a
network, the worst of two seeds. deadband (network_deadband.csv): the share of tool samples that a deadband sends, and
what it costs of the force, on shipped and recorded hands; recordings that are not there are left out.

Half an hour of a processor. What matters most comes first, and rows that a table has are not measured again: a stopped
run goes on where it was. To begin anew, take the table away.
"""
import concurrent.futures
import json
import pathlib
import tempfile
import threading

import measure_models
from measuring import output_of, parser_of, program
from tables import read_rows, write_rows

DELAYS_S = (0.0, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)  # one way
NETWORKS = ((0.01, 1000), (0.05, 100_000), (0.0, 1000), (0.01, 100_000), (0.05, 1000))  # loss, bytes of a snapshot
# How many of them each law is measured on. predict_over_delay: its snapshots predict a step that is longer by half of
# the delay. predict_untold: the hand is told the simulation's period; else the longest between two snapshots where a
# packet was lost.
LAWS = {"predict": 5, "linear": 2, "hold": 2, "predict_over_delay": 1, "predict_untold": 1}
BODIES = ("free:1", "free:0.1", "chain")
PERIOD_S, ERROR_PERIOD_S = 0.033, 0.02
SEEDS, ERROR_SEEDS = 8, 2
HANDS = ("threads", "organ", "moving_sphere")
DEADBANDS = (0.0, 0.02, 0.07, 0.15)
RECORDED = ("franka on tissue", "contour on tissue", "teleoperator on free body")


def law_options(law, period_s, delay_s):
    name, _, variant = law.partition("_")
    told_s = period_s if variant == "untold" else period_s + min(period_s, 2.0 * delay_s)
    longer = ["--prediction", f"{period_s + 0.5 * delay_s:.6g}"] if variant == "over_delay" else []
    return ["--transition", name, "--told-period", f"{told_s:.6g}", *longer]


def network_options(delay_s, loss, size_bytes):
    return ["--delay", f"{delay_s:g}", "--loss", f"{loss:g}", "--bytes", size_bytes]


def cell_options(row):
    """Of a row of the table of stability."""
    delay_s = float(row["delay_s"])
    return ["--scene", row["scene"], "--device", "hand", "--period", f"{PERIOD_S:g}", "--latency", "0.1",
            "--jitter", "0.3", "--duration", "10", *law_options(row["law"], PERIOD_S, delay_s),
            *network_options(delay_s, float(row["loss"]), row["bytes"])]


def limit_of(build, row, seeds):
    text = output_of([program(build, "stability_lab"), "limit", *cell_options(row), "--seeds", seeds,
                      "--lowest", "100", "--highest", "10000", "--step", "1.5"]).strip()
    row["limit_N_per_m"] = text if text[0].isdigit() else ""  # less than the lowest
    return row


def cells_of(scenes, laws):
    """Without a delay a lost fragment comes at once: size changes nothing."""
    return [(scene, law, delay_s, loss, size) for number, (loss, size) in enumerate(NETWORKS) for law in laws
            for scene in scenes for delay_s in DELAYS_S
            if number < LAWS[law] and (delay_s > 0.0 or size == NETWORKS[0][1])]


KEYS = ("scene", "law", "delay_s", "loss", "bytes")


def rows_of(cells):
    return [{key: value if isinstance(value, str) else f"{value:g}" for key, value in zip(KEYS, cell)}
            for cell in cells]


class Table:
    """The rows of a file, kept as they come: those that it has are not measured again."""

    def __init__(self, file):
        self.file, self.lock = file, threading.Lock()
        self.known = {tuple(row[key] for key in KEYS): row for row in read_rows(file)} if file.exists() else {}

    def measure(self, pool, rows, measured):
        left = [row for row in rows if tuple(row.values()) not in self.known]
        order = {tuple(row.values()): place for place, row in enumerate(rows)}

        def take(row):
            key = tuple(row.values())
            row = measured(row)
            with self.lock:
                self.known[key] = row
                keys = sorted(self.known, key=lambda known: order.get(known, -1))
                write_rows(self.file, [self.known[known] for known in keys])
        for _ in pool.map(take, left):
            pass


def stability_rows(is_small):
    cells = cells_of(BODIES, LAWS)
    if is_small:
        cells = [("free:1", law, delay_s, 0.01, 1000) for law in LAWS for delay_s in DELAYS_S[3:5]]
    return rows_of(cells + [("wall", "predict", delay_s, 0.01, 1000) for delay_s in DELAYS_S[-1:]])


def measure_stability(arguments, pool):
    table = Table(arguments.charts / "network_stability.csv")
    rows = stability_rows(arguments.small)
    seeds = 2 if arguments.small else SEEDS
    table.measure(pool, rows, lambda row: limit_of(arguments.build, row, seeds))


def metrics_of(build, options):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "metrics.json"
        output_of([program(build, "stability_lab"), "run", *options, "--metrics", file])
        return json.loads(file.read_text())


def hand_options(scene):
    file = measure_models.SCENES / f"{scene}.toml"
    return ["--scene", file, "--device", f"replay:file={file.with_suffix('.hand.csv')}", "--duration", "2"]


def shown_share(network):
    """Of the snapshots that are on their way no longer; where nothing is between the two sides, all."""
    lost = network["replaced"] + network["late"]
    return network["snapshots_shown"] / (network["snapshots_shown"] + lost) if lost else 1.0


def error_of(build, row, seeds):
    delay_s, loss = float(row["delay_s"]), float(row["loss"])
    runs = [metrics_of(build, [*hand_options(row["scene"]), "--period", f"{ERROR_PERIOD_S:g}", "--seed", seed,
                               *law_options(row["law"], ERROR_PERIOD_S, delay_s),
                               *network_options(delay_s, loss, row["bytes"])])
            for seed in range(1, (seeds if loss > 0.0 else 1) + 1)]
    shown = [shown_share(run["network"]) for run in runs]
    row["rms_N"] = f"{max(run['error_N']['rms'] for run in runs):.4g}"
    row["max_N"] = f"{max(run['error_N']['max'] for run in runs):.4g}"
    row["shown_share"] = f"{min(shown):.3g}"
    return row


def error_rows(is_small):
    laws = [law for law in LAWS if law != "predict_untold"]  # no force fades but in the safety chain
    if is_small:
        return rows_of([("threads", law, delay_s, 0.01, 1000) for law in laws for delay_s in DELAYS_S[3:5]])
    return rows_of(cells_of(HANDS, laws))


def measure_error(arguments, pool):
    table = Table(arguments.charts / "network_error.csv")
    rows, seeds = error_rows(arguments.small), 1 if arguments.small else ERROR_SEEDS
    table.measure(pool, rows, lambda row: error_of(arguments.build, row, seeds))


def recorded_options(name):
    """Nothing where the recording is not there."""
    path = next(path for path in measure_models.PATHS if path[0] == name)
    device = measure_models.device_of(path[2], path[4], None)
    return device and ["--scene", path[1], "--device", device, "--duration", path[4]]


def deadband_of(build, hand, deadband):
    """A row; nothing where the recording is not there."""
    options = recorded_options(hand) if hand in RECORDED else hand_options(hand)
    if options is None:
        return None
    run = metrics_of(build, [*options, "--period", f"{ERROR_PERIOD_S:g}", *network_options(0.02, 0.01, 1000),
                             "--deadband", f"{deadband:g}"])
    return {"hand": hand, "deadband": f"{deadband:g}",
            "sent_share": f"{run['network']['samples_sent'] / run['network']['samples']:.3g}",
            "rms_N": f"{run['error_N']['rms']:.4g}", "max_N": f"{run['error_N']['max']:.4g}"}


def measure_deadband(arguments, pool):
    hands = ("threads",) if arguments.small else (*HANDS, "wall", *RECORDED)
    cells = [(hand, deadband) for hand in hands for deadband in DEADBANDS]
    rows = list(pool.map(lambda cell: deadband_of(arguments.build, *cell), cells))
    for hand in sorted({hand for (hand, _), row in zip(cells, rows) if row is None}):
        print(f"{hand}: no recording, left out")
    write_rows(arguments.charts / "network_deadband.csv", [row for row in rows if row is not None])


TABLES = {"stability": measure_stability, "error": measure_error, "deadband": measure_deadband}


def main():
    parser = parser_of(__doc__, "two delays, one network, a body or a scene")
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"some of {', '.join(TABLES)}; default: all")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="default: 2")
    arguments = parser.parse_args()
    for name in set(arguments.tables) - set(TABLES):
        parser.error(f"TABLE: value {name}: expected some of {', '.join(TABLES)}")
    with concurrent.futures.ThreadPoolExecutor(arguments.threads) as pool:
        for name in arguments.tables or TABLES:
            TABLES[name](arguments, pool)


if __name__ == "__main__":
    main()
