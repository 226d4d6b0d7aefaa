#!/usr/bin/python3
"""A session between two machines outlives what breaks between them: the relay beside the simulation, the relay beside
the hand, sim_server are killed (SIGKILL), and the link is cut, in turn and at random instants, while a hand presses
on a wall. Two namespaces, joined by a link that delays by 5 ms and loses 1 %; 150 spheres move out of its reach, so
that snapshots go as deltas.

Laws: nothing torn, and no snapshot that is older than one shown before; no force without a fresh enough snapshot;
none that grows faster than it may; all of it back each time; no program that ends by itself. Exit status 1 if one is
broken, 77 where the machine grants no namespaces. Rows by kill: what, how long it was away, the fade (from the last
snapshot to no force) and the return (from the end of the cause to the first snapshot), s.
"""
import argparse
import csv
import json
import pathlib
import random
import struct
import subprocess
import sys
import time
import unittest

import numpy

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "network"))
import relayed  # after the path it needs
from relayed import BUILD, CLOCK_OFFSET_S, RelayedTest, daemons

LINK = ("delay_ms 5", "jitter_ms 2", "loss 0.01")
CAUSES = ("sim_relay", "hand_relay", "sim_server", "partition")
AWAY_S = (0.0, 1.0)
FELT_S = (0.2, 1.0)  # in full, before the next
PROGRESS_S = 20.0
START_NS = 56  # docs/protocol.md

SPHERE = """
[[body]]
name = "s{i}"
kind = "sphere"
motion = "prescribed"
velocity_m_s = [{x}, {y}, 0.0]
position_m = [{px}, {py}, 0.5]
radius_m = 0.004
material = "wall"
"""


def scene_text(draw, count=150):
    """The wall, and spheres above it that each move in a way of its own."""
    text = (daemons.SCENES / "wall.toml").read_text().replace('file = "wall.hand.csv"',
                                                              f'file = "{daemons.SCENES / "wall.hand.csv"}"')
    for i in range(count):
        x, speed_m_s = draw.uniform(-0.8, 0.8), draw.uniform(1e-4, 1e-3)
        text += SPHERE.format(i=i, x=speed_m_s * x, y=speed_m_s * (1.0 - x * x) ** 0.5,
                              px=draw.uniform(-0.2, 0.2), py=draw.uniform(-0.2, 0.2))
    return text


class NetworkSoak(RelayedTest):
    kills, seed, report_file, rows_file = 6, 1, None, None

    def test_a_session_between_two_machines_outlives_what_breaks(self):
        draw = random.Random(self.seed)
        self.open_bed(*LINK, seed=self.seed)
        self.scene = self.write("scene.toml", scene_text(draw))
        self.start_session(self.scene)
        watcher = self.bed.run("b", [BUILD / "tests" / "snapshot_watch", "--session", self.session],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        began_s = self.hand_began_s()
        rows = self.disturb(draw)
        recording = self.stop_session()
        watcher.terminate()
        seen = json.loads(watcher.communicate(timeout=10 * relayed.PATIENCE)[0])
        self.add_fades(rows, recording, began_s)
        figures = figures_of(rows, recording, seen)
        self.tell(figures, rows)
        self.assertEqual(figures["broken_laws"], [])

    def hand_began_s(self):
        """When the hand's recording begins, on this process' clock."""
        file = next(self.bed.shared_memory("b").glob(f"stillgrid-*/{self.session}-tool"))
        return 1e-9 * struct.unpack_from("<Q", file.read_bytes(), START_NS)[0] - CLOCK_OFFSET_S

    def disturb(self, draw):
        rows, said_s = [], time.monotonic()
        for number in range(self.kills):
            time.sleep(draw.uniform(*FELT_S))
            cause, away_s = CAUSES[number % len(CAUSES)], draw.uniform(*AWAY_S)
            begun_s = time.monotonic()
            self.end(cause)
            time.sleep(away_s)
            over_s = time.monotonic()
            self.begin(cause)
            return_s = self.wait_for_return(over_s)
            self.wait_until(self.is_felt, 10.0, f"the whole force after {cause}")
            rows.append({"cause": cause, "begun_s": begun_s, "away_s": over_s - begun_s, "return_s": return_s})
            if time.monotonic() > said_s + PROGRESS_S:
                said_s += PROGRESS_S
                print(f"network_soak: {number + 1} of {self.kills}", file=sys.stderr)
        return rows

    def end(self, cause):
        if cause == "partition":
            self.bed.control("partition on")
        else:
            program = {"sim_relay": self.sim_relay, "hand_relay": self.hand_relay, "sim_server": self.sim}[cause]
            self.assertTrue(program.runs(), program.lines())
            program.kill()
            self.daemons.remove(program)

    def begin(self, cause):
        if cause == "partition":
            self.bed.control("partition off")
        elif cause == "sim_relay":
            self.sim_relay = self.relay("simulation")
        elif cause == "hand_relay":
            self.hand_relay = self.relay("hand")
        else:
            self.sim = self.sim_server(self.scene)

    def add_fades(self, rows, recording, began_s):
        """To each row from the last snapshot to no force; None where a snapshot came before the force was gone."""
        time_s, force_N = recording.time_s + began_s, recording.force_norm_N()
        since_s = relayed.since_snapshot_s(recording)
        gone = numpy.flatnonzero((force_N[1:] == 0.0) & (force_N[:-1] > 0.0)) + 1
        for row in rows:
            until_s = row["begun_s"] + row["away_s"] + row["return_s"]
            of_it = [i for i in gone if row["begun_s"] <= time_s[i] <= until_s + 0.05]
            row["fade_s"] = float(since_s[of_it[0]]) if of_it else None

    def tell(self, figures, rows):
        print(json.dumps(figures, indent=2))
        if self.report_file:
            pathlib.Path(self.report_file).write_text(json.dumps(figures, indent=2) + "\n")
        if self.rows_file:
            with open(self.rows_file, "w", newline="") as file:
                writer = csv.writer(file)
                writer.writerow(["cause", "away_s", "fade_s", "return_s"])
                for row in rows:
                    writer.writerow([row["cause"], *("" if row[key] is None else f"{row[key]:.4f}"
                                                     for key in ("away_s", "fade_s", "return_s"))])


def spread_of(values):
    return {"count": len(values), "p50": float(numpy.median(values)) if values else None,
            "max": max(values, default=None)}


def figures_of(rows, recording, seen):
    growth = relayed.growth_N_per_ms(recording)
    figures = {"kills": len(rows), "seconds": float(recording.time_s[-1]), "ticks": len(recording),
               "fade_s": spread_of([row["fade_s"] for row in rows if row["fade_s"] is not None]),
               "return_s": {cause: spread_of([row["return_s"] for row in rows if row["cause"] == cause])
                            for cause in CAUSES},
               "force_max_N": float(recording.force_norm_N().max()), "slew_max_N_per_ms": float(growth.max()),
               "without_snapshot": relayed.without_snapshot(recording, relayed.LOCAL_FADE_S),
               "backwards": relayed.going_back(recording), **seen}
    laws = {"a torn snapshot": seen["torn"] == 0,
            "no snapshot was read": seen["snapshots"] > 0,
            "an older snapshot after a newer one": figures["backwards"] == 0,
            "a force without a fresh snapshot": figures["without_snapshot"] == 0,
            "a force above the wall's": figures["force_max_N"] <= 1.001 * relayed.FORCE_N,
            f"a growth above {relayed.MAX_SLEW_N_PER_MS} N/ms":
                figures["slew_max_N_per_ms"] <= 1.001 * relayed.MAX_SLEW_N_PER_MS}
    return {**figures, "broken_laws": [law for law, holds in laws.items() if not holds]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=6, help="and partitions; default: %(default)s")
    parser.add_argument("--seed", type=int, default=1, help="of the instants; default: %(default)s")
    parser.add_argument("--report", metavar="FILE.json", help="write the figures")
    parser.add_argument("--rows", metavar="FILE.csv", help="write a row a kill")
    arguments = parser.parse_args()
    if arguments.kills < 1:
        parser.error(f"--kills: value {arguments.kills}: expected 1 at least")
    NetworkSoak.kills, NetworkSoak.seed = arguments.kills, arguments.seed
    NetworkSoak.report_file, NetworkSoak.rows_file = arguments.report, arguments.rows
    result = unittest.TextTestRunner().run(unittest.defaultTestLoader.loadTestsFromTestCase(NetworkSoak))
    sys.exit(1 if not result.wasSuccessful() else daemons.SKIPPED if result.skipped else 0)


if __name__ == "__main__":
    main()
