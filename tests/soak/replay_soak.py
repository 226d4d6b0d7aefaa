#!/usr/bin/python3
"""Every recorded trajectory to its end, again and again: every run writes the same bytes.

The first run has the machine to itself; the others are beside stress-ng. Laws: every recording is
byte for byte the first one's; each trajectory touches its scene; no row is lost. Prints a table, the
one in docs/replay.md; exit status 1 if a law is broken.
"""
import argparse
import json
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
import numpy

import daemons
import trajectories

LONGEST_S = 12.0  # all have ended by then


class Replays(daemons.SessionTest):
    """The helpers of a test, without being one."""

    def runTest(self):
        pass

    def record(self, trajectory):
        scene = trajectories.make_scene(trajectory.scene, self.folder)
        return self.run_lockstep(scene, trajectory.device, LONGEST_S)

    def measure(self, repeats):
        firsts = {trajectory.name: self.record(trajectory) for trajectory in trajectories.TRAJECTORIES}
        same = dict.fromkeys(firsts, 1)
        with trajectories.stress():
            for _ in range(repeats - 1):
                for trajectory in trajectories.TRAJECTORIES:
                    recording = self.record(trajectory)
                    same[trajectory.name] += recording.read_bytes() == firsts[trajectory.name].read_bytes()
                    recording.unlink()
        return [figures(trajectory, firsts[trajectory.name], same[trajectory.name])
                for trajectory in trajectories.TRAJECTORIES]


def figures(trajectory, file, same):
    recording = daemons.read_recording(file)
    return {"trajectory": trajectory.name, "scene": trajectory.scene,
            "rows": len(recording["time_s"]), "same": same,
            "contact_share": numpy.mean(recording["contacts"] > 0),
            "force_max_N": recording.force_norm_N().max()}


def broken_laws(rows, repeats):
    return ([f"{row['trajectory']}: {row['same']} of {repeats} runs gave the first one's bytes"
             for row in rows if row["same"] != repeats] +
            [f"{row['trajectory']}: touched nothing" for row in rows if row["contact_share"] == 0.0])


def print_table(rows):
    print("| trajectory | scene | rows | in contact | largest force | runs alike |")
    print("|---|---|---|---|---|---|")
    for row in rows:
        print(f"| `{row['trajectory']}` | {row['scene']} | {row['rows']:,} | "
              f"{100 * row['contact_share']:.0f} % | {row['force_max_N']:.2f} N | {row['same']} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5, help="of each; default: %(default)s")
    parser.add_argument("--report", type=pathlib.Path, help="write the figures (JSON) there")
    arguments = parser.parse_args()
    if not trajectories.FOLDER.exists():
        sys.exit(f"replay_soak: no {trajectories.FOLDER}: expected $STILLGRID_DATA to hold it")
    replays = Replays()
    replays.setUp()
    try:
        rows = replays.measure(max(2, arguments.repeats))
    finally:
        replays.tearDown()
    broken = broken_laws(rows, max(2, arguments.repeats))
    print_table(rows)
    if arguments.report:
        arguments.report.write_text(json.dumps({"rows": rows, "broken_laws": broken}, indent=2) + "\n")
    for law in broken:
        print(f"replay_soak: {law}", file=sys.stderr)
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
