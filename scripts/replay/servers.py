"""Runs a replay in lockstep: sim_server, and a haptic_server for each hand of the scene."""
import dataclasses
import json
import os
import pathlib
import subprocess
import sys
import time
import tomllib

from expectation import Unusable, of_hand
from recorded_frame import laid_back

PLACES = ("scale=", "offset_", "map=")  # options that say where a trajectory lies
# Fifty times a workspace; beyond 10 m no device is believed. Some snapshots long: a hand that ended at its first
# tick could be gone before the simulation had seen that it came.
AWAY = "time_s,x_m,y_m,z_m\n0,9,0,0\n0.2,9,0,0\n"


@dataclasses.dataclass
class Hand:
    """name: none, of a scene that does not name its hands. expected: None where nothing is compared."""

    name: str
    trajectory: pathlib.Path
    expected: pathlib.Path | None
    recording: pathlib.Path
    options: str  # of its replay device

    @property
    def own(self):
        return f".{self.name}" if self.name else ""


def named_hands(scene):
    """By name the hands of a scene that names them, and the device of one that does not."""
    try:
        table = tomllib.loads(scene.read_text(encoding="utf-8"))
        named, device = table.get("hand"), table.get("device", {})
        return {hand["name"]: hand for hand in named} if isinstance(named, list) else {}, device
    except (ValueError, TypeError, KeyError):
        return {}, {}  # sim_server says where


def hands_of(scene, arguments, folder):
    """Of the scene all that are asked for, and those that are kept away."""
    named, device = named_hands(scene)
    for name in arguments.hand:
        if name not in named:
            raise Unusable(f"--hand: value '{name}': expected " +
                           (f"one of '{', '.join(named)}'" if named else f"none: {scene} names no hands"))
    if not named:
        is_placed = any(option.startswith(PLACES) for option in arguments.replay.split(","))
        frame = "" if is_placed else into_frame(arguments.trajectory, device)
        options = ",".join(filter(None, (frame, arguments.replay)))
        return [Hand("", arguments.trajectory, arguments.expected, folder / "recording.csv", options)]
    (folder / "away.csv").write_text(AWAY)
    hands = []
    for name, hand in named.items():
        recording = folder / f"recording.{name}.csv"
        if arguments.hand and name not in arguments.hand:
            hands.append(Hand(name, folder / "away.csv", None, recording, ""))
            continue
        trajectory = of_hand(arguments.trajectory, name)
        options = ",".join(filter(None, (into_frame(trajectory, hand.get("device", {})), arguments.replay)))
        hands.append(Hand(name, trajectory, of_hand(arguments.expected, name), recording, options))
    return hands


def into_frame(trajectory, device):
    """What takes a recording, which is in the scene's frame, back to the hand's device."""
    try:
        return laid_back(trajectory, device)
    except OSError as error:
        raise Unusable(f"{trajectory}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise Unusable(error) from None


def commands_of(scene, hands, arguments):
    """Name and arguments of each server; the simulation first, as the one that takes the others along."""
    both = ["--lockstep", "--session", f"replay-check-{os.getpid()}"]
    if arguments.duration is not None:
        both += ["--duration", arguments.duration]
    yield "sim_server", "sim_server", ["--scene", scene, *both, *arguments.sim.split()]
    for hand in hands:
        if "," in str(hand.trajectory):
            raise Unusable(f"{hand.trajectory}: expected a name without a comma: it separates options")
        device = ",".join(filter(None, (f"replay:file={hand.trajectory}", hand.options)))
        yield f"haptic_server{hand.own}", "haptic_server", [
            "--device", device, "--record", hand.recording, "--report", hand.recording.with_suffix(".json"),
            *(["--hand", hand.name] if hand.name else []), *both, *arguments.haptic.split()]


def run(build, scene, hands, arguments, folder):
    """Runs the servers to their end, and passes on what they had to say."""
    running = {}
    try:
        for name, program, command in commands_of(scene, hands, arguments):
            with open(folder / name, "w") as stderr:
                # pdeathsig: not even a killed CI job leaves a daemon behind.
                running[name] = subprocess.Popen(
                    ["setpriv", "--pdeathsig", "TERM", build / "bin" / program, *map(str, command)],
                    stdin=subprocess.DEVNULL, stderr=stderr)
        sim_server, *haptic_servers = running.values()
        while (any(server.poll() is None for server in haptic_servers) and not sim_server.poll()
               and not any(server.poll() for server in haptic_servers)):
            time.sleep(0.005)
        if any(server.poll() for server in haptic_servers):
            await_end(sim_server, 0.5)  # one that died of itself is the one to name
        for name, process in running.items():
            if process.poll():
                raise Unusable(complaint(name, folder, process.returncode))
    finally:
        for process in running.values():
            process.terminate()
            if not await_end(process, 5.0):
                process.kill()
                process.wait()
        for left in pathlib.Path(f"/dev/shm/stillgrid-{os.geteuid()}").glob(f"replay-check-{os.getpid()}[-+]*"):
            left.unlink()  # of a daemon that was killed
    for hand in hands:
        report = hand.recording.with_suffix(".json")
        if lost := json.loads(report.read_text())["lost_rows"] if report.exists() else 0:
            raise Unusable(f"{hand.recording}: {lost} rows could not be written: is the disk full?")
    sys.stderr.write("".join((folder / name).read_text() for name in running))


def await_end(process, patience_s):
    try:
        process.wait(patience_s)
    except subprocess.TimeoutExpired:
        return False
    return True


def complaint(name, folder, status):
    lines = (folder / name).read_text().splitlines()
    return lines[-1] if lines else f"{name} ended with status {status}"
