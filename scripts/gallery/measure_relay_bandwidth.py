#!/usr/bin/python3
"""Measures what each scene that ships needs of a link, on its own hands: docs/charts/relay_bandwidth.csv.

Bytes are those of IP packets that arrived, all of the relays' included, over a link without delay that loses nothing,
while the hands move. As it ships; with every snapshot told whole (--no-deltas); and with the tool's samples kept back
that those before lead to (--deadband).
"""
import time
import tomllib

from measuring import parser_of
from relay_bed import SCENES, Bed
from tables import write_rows

# What a scene without a hand of its own is pressed by (docs/gallery.md).
PRESS = "phantom:profile=premium15,hand=light,path=press,centre_z_m=-0.03,depth_m=0.03,period_s=2"
LONGEST_S = 8.0
DEADBAND = 0.07


def hands_of(scene):
    """The devices by the hand's name, '' of a scene with one, and how long the scene comes to rest before."""
    read = tomllib.loads((SCENES / f"{scene}.toml").read_text())
    hand = read.get("hand", {})
    if isinstance(hand, list):
        names = [one["name"] for one in hand]
        return {name: f"phantom:profile=touchx,path={SCENES}/{scene}.{name}.csv" for name in names}, 0.0
    if not hand:
        return {"": PRESS}, 1.0
    return {"": f"replay:file={SCENES / hand['file']}"}, hand.get("settle_s", 0.0)


def duration_s(scene, limit_s):
    """Until the first of the hands is at its end."""
    ends = [float(file.read_text().split()[-1].split(",")[0]) for file in SCENES.glob(f"{scene}.*.csv")]
    return min([limit_s, *ends])


def run(build, scene, limit_s, of_simulation=(), of_hand=()):
    devices, settle_s = hands_of(scene)
    moving_s = duration_s(scene, limit_s)
    with Bed(build) as bed:
        sim = bed.sim_server(scene)
        bed.wait_for("a", "scene", next(iter(devices)))
        began_s = time.monotonic()
        relays = [bed.relays(hand, of_simulation, of_hand) for hand in devices]
        for hand in devices:
            bed.wait_for("b", "scene", hand)
        time.sleep(settle_s)
        for hand, device in devices.items():
            bed.haptic_server("b", device, hand=hand)
        for hand in devices:
            bed.wait_for("a", "tool", hand)
        before, moved_s = bed.machines.counters(), time.monotonic()
        time.sleep(moving_s - 0.4)
        after, took_s = bed.machines.counters(), time.monotonic() - moved_s
        lived_s = time.monotonic() - began_s
        bed.end(*(process for pair in relays for process in pair), sim)
        told = [bed.report(f"simulation{hand}") for hand in devices]
        samples = [bed.report(f"hand{hand}") for hand in devices]

    def kB_s(side):
        return 1e-3 * (after[side]["delivered_bytes"] - before[side]["delivered_bytes"]) / took_s

    def packets_s(side):
        return (after[side]["delivered"] - before[side]["delivered"]) / took_s

    told_count, sample_count = sum(t["sent"] for t in told), sum(t["sent"] for t in samples)
    return {"to_hand_kB_s": kB_s("a"), "to_simulation_kB_s": kB_s("b"), "packets_s": packets_s("a") + packets_s("b"),
            "snapshots_s": told_count / lived_s,
            "snapshot_bytes": sum(t["sent_bytes"] for t in told) / max(1, told_count),
            "samples_sent_share": sample_count / max(1, sample_count + sum(t["withheld"] for t in samples))}


def row(build, scene, limit_s):
    read = tomllib.loads((SCENES / f"{scene}.toml").read_text())["simulation"]
    with_deltas = run(build, scene, limit_s)
    whole = run(build, scene, limit_s, of_simulation=("--no-deltas",))
    kept_back = run(build, scene, limit_s, of_hand=("--deadband", DEADBAND))
    result = {"scene": scene, "rate_hz": f"{read.get('rate_hz') or 1.0 / read['period_s']:g}",
              "hands": len(hands_of(scene)[0]),
              "whole_kB_s": f"{whole['to_hand_kB_s']:.1f}", "deltas_kB_s": f"{with_deltas['to_hand_kB_s']:.1f}",
              "whole_snapshots_s": f"{whole['snapshots_s']:.0f}",
              "delta_snapshots_s": f"{with_deltas['snapshots_s']:.0f}",
              "whole_bytes": f"{whole['snapshot_bytes']:.0f}", "delta_bytes": f"{with_deltas['snapshot_bytes']:.0f}",
              "tool_kB_s": f"{with_deltas['to_simulation_kB_s']:.1f}",
              "tool_deadband_kB_s": f"{kept_back['to_simulation_kB_s']:.1f}",
              "samples_sent_share": f"{kept_back['samples_sent_share']:.3f}",
              "packets_s": f"{with_deltas['packets_s']:.0f}"}
    print(", ".join(f"{key} {value}" for key, value in result.items()), flush=True)
    return result


def main():
    arguments = parser_of(__doc__, "two scenes, a second each").parse_args()
    scenes = ["organ", "threads"] if arguments.small else sorted(file.stem for file in SCENES.glob("*.toml"))
    write_rows(arguments.charts / "relay_bandwidth.csv",
               [row(arguments.build, scene, 1.5 if arguments.small else LONGEST_S) for scene in scenes])


if __name__ == "__main__":
    main()
