"""Reads recordings in MCAP by the libraries of its makers: tests/integration/mcap."""
import json
import shutil
import subprocess
import unittest

import numpy

import daemons

SCRIPT = daemons.ROOT / "tests/integration/mcap/mcap.mjs"
FLAGS_TOPIC, POSE_TOPIC, TICK_TOPIC = "/tool/flags", "/tool/pose", "/tool/tick"
SCENE_TOPICS = ("/scene/fixed", "/scene/moving", "/tool/spheres")


def run(verb, file, text=None):
    """What the script prints. Skips the test where npm or node is absent."""
    if not (daemons.BUILD / "tests/integration/mcap/fetched.stamp").exists() or not shutil.which("node"):
        raise unittest.SkipTest("skipped: npm or node is absent: the libraries of MCAP's makers were not fetched")
    done = subprocess.run(["node", SCRIPT, verb, str(file)], input=text, text=True, capture_output=True,
                          timeout=120 * daemons.PATIENCE, check=False,
                          env={"PATH": "/usr/local/bin:/usr/bin:/bin", "STILLGRID_BUILD_DIR": str(daemons.BUILD)})
    if done.returncode != 0:
        raise AssertionError(f"{verb} {file}: {done.stdout[-500:]} {done.stderr[-2000:]}")
    return json.loads(done.stdout)


class Read:
    """A recording, as one of the makers' readers finds it. way: indexed or streamed."""

    def __init__(self, file, way):
        found = run(way, file)
        self.found, self.is_whole, self.metadata = found, found["is_whole"], found["metadata"]

    def messages(self, topic):
        """Stamps in ns and messages, their whole numbers as floats: -0 is not 0."""
        return [(int(stamp), json.loads(text, parse_int=float))
                for stamp, _, text in self.found["topics"][topic]["messages"]]

    def rows(self):
        """The columns of the CSV."""
        poses, ticks = self.messages(POSE_TOPIC), self.messages(TICK_TOPIC)
        assert [stamp for stamp, _ in poses] == [stamp for stamp, _ in ticks]
        columns = {"time_s": [tick["time_s"] for _, tick in ticks]}
        for axis in "xyz":
            columns[f"{axis}_m"] = [pose["translation"][axis] for _, pose in poses]
            for name, key in (("v{}_m_s", "velocity_m_s"), ("f{}_N", "force_N"),
                              ("rendered_f{}_N", "rendered_force_N"), ("t{}_N_m", "torque_N_m")):
                columns[name.format(axis)] = [tick[key][axis] for _, tick in ticks]
        for name in ("snapshot_id", "alpha", "contacts", "age_s", "tick_ns", "flags"):
            columns[name] = [tick[name] for _, tick in ticks]
        for axis in "xyzw":
            columns[f"q{axis}"] = [pose["rotation"][axis] for _, pose in poses]
        return {name: numpy.array(column) for name, column in columns.items()}

    def flags(self):
        """Of each tick the names that are set, by the messages of changes."""
        changes, flags, at = self.messages(FLAGS_TOPIC), [], 0
        for stamp, _ in self.messages(TICK_TOPIC):
            while at + 1 < len(changes) and changes[at + 1][0] <= stamp:
                at += 1
            flags.append("|".join(name for name, is_set in changes[at][1].items() if is_set))
        return flags


def assert_same_bits(test, got, csv, rows=None):
    """Every column of a CSV is that of the MCAP; rows: of the first so many."""
    test.assertEqual(set(got), set(csv.columns))
    for name, column in csv.columns.items():
        if name == "flags":
            test.assertEqual(list(got[name]), list(column[:rows]))
            continue
        test.assertEqual(got[name].astype(float).tobytes(), column[:rows].astype(float).tobytes(), name)
