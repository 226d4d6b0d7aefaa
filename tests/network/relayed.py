"""A session over the bed, for a test: sim_server and a relay on side "a", a relay and haptic_server on side "b", what
their segments were at which time, and what a hand may feel of it.

Laws of what was felt, from a recording:
  without_snapshot   ticks with a force though no fresh snapshot came for as long as a fade takes
  going_back         snapshots that were shown after a newer one of the same segment
  growth_N_per_ms    by how much the force grew from one tick to the next
"""
import pathlib
import struct
import sys
import threading
import time

import numpy

import two_machines
from two_machines import INTERFACE, PATIENCE, TwoMachines

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "integration"))
import daemons  # after the path it needs
from daemons import BUILD, DONE, SCENES

# Of the scene wall: a tool held 2 mm deep feels 2 N, of a snapshot every thirtieth of a second.
DEPTH_POINT_M = (0, 0, 0.003)
FORCE_N = 2.0
PERIOD_S = 1.0 / 30.0
# docs/safety.md: from a snapshot to no force, of a local copy; of snapshots alone by the longest period that a relay
# declares of this scene.
LOCAL_FADE_S = 1.0 + 0.1
FADE_S = 1.5 * 2.0 * PERIOD_S + 0.1
MAX_SLEW_N_PER_MS = 0.1
TICK_S = 0.001
CLOCK_OFFSET_S = 3 * 86400 + 1234.5  # of side b, which was switched on days before the other

HEADER_BYTES = 384
EPOCH, LATEST = 24, 256  # docs/protocol.md


class SegmentWatch(threading.Thread):
    """What stands under a segment's name on a side of the bed, every 2 ms: (time_s, epoch, latest) of each change, on
    this process' monotonic clock; epoch 0: nothing."""

    def __init__(self, bed, side, session, kind):
        super().__init__(daemon=True)
        self._folder, self._name = bed.shared_memory(side), f"{session}-{kind}"
        self.changes = [(time.monotonic(), 0, 0)]
        self._ended = threading.Event()
        self.start()

    def look(self):
        for file in self._folder.glob(f"stillgrid-*/{self._name}"):
            try:
                with open(file, "rb", buffering=0) as segment:
                    header = segment.read(HEADER_BYTES)
            except OSError:
                continue
            if len(header) == HEADER_BYTES:
                return struct.unpack_from("<Q", header, EPOCH)[0], struct.unpack_from("<Q", header, LATEST)[0]
        return 0, 0

    def run(self):
        while not self._ended.wait(0.002):
            now = self.look()
            if now != self.changes[-1][1:]:
                self.changes.append((time.monotonic(), *now))

    def stop(self):
        self._ended.set()
        self.join()

    def epochs(self):
        """Of the segments, in order; 0 where there was none between."""
        found = []
        for _, epoch, _ in self.changes:
            if not found or found[-1] != epoch:
                found.append(epoch)
        return found

    def first_published(self, since_s, epoch_is_other_than=None):
        """When something was published first since then; None: never."""
        for before, change in zip(self.changes, self.changes[1:]):
            time_s, epoch, latest = change
            if time_s >= since_s and epoch and latest and epoch != epoch_is_other_than and before[1:] != change[1:]:
                return time_s
        return None

    def first_absent(self, since_s):
        """When there was no segment first since then; None: never."""
        standing = [change for change in self.changes if change[0] <= since_s][-1:]
        later = [change for change in self.changes if change[0] > since_s]
        return next((max(time_s, since_s) for time_s, epoch, _ in standing + later if not epoch), None)


class RelayedTest(daemons.SessionTest):
    """A test with a session over the bed, skipped where the machine grants none."""
    fade_s = LOCAL_FADE_S  # of its scene

    def open_bed(self, *settings, clock_offset_s=CLOCK_OFFSET_S, seed=1):
        try:
            self.bed = TwoMachines(*settings, clock_offset_s=clock_offset_s, seed=seed)
        except two_machines.NotGranted as missing:
            self.skipTest(str(missing))
        self.addCleanup(lambda: self.bed.close() if self.bed.is_open else None)
        self.watches = []
        self.addCleanup(lambda: [watch.stop() for watch in self.watches if watch.is_alive()])

    def start_on(self, side, *arguments):
        return self.start(*self.bed.argv(side, arguments))

    def wall_without_model(self):
        """The wall for snapshots alone: the local copy takes ticks without given substeps."""
        scene = self.folder / "wall_without_model.toml"
        scene.write_text((SCENES / "wall.toml").read_text().replace(
            "rate_hz = 30.0", 'rate_hz = 30.0\nintegrator = "velocity_verlet"\nsubsteps = 4').replace(
            '[hand]\nfile = "wall.hand.csv"\n', ""))
        return scene

    def scene(self):
        """Of a session that names none."""
        return "wall"

    def sim_server(self, scene=None, *arguments):
        scene = scene or self.scene()
        file = scene if isinstance(scene, pathlib.Path) else SCENES / f"{scene}.toml"
        return self.start_on("a", BUILD / "bin" / "sim_server", "--scene", file, "--session", self.session,
                             *arguments)

    def relay(self, role, *arguments, joins=("--open",)):
        """role: "simulation" or "hand"."""
        return self.start_on("a" if role == "simulation" else "b", BUILD / "bin" / "scene_relay", role, "--session",
                             self.session, "--interface", INTERFACE, *joins, *arguments)

    def hand(self, device=None, *arguments):
        """haptic_server, and the file of its recording."""
        file = self.folder / f"recording-{len(self.daemons)}.csv"
        return self.start_on("b", BUILD / "bin" / "haptic_server", "--session", self.session, "--device",
                             device or self.still_device(*DEPTH_POINT_M), "--record", file, "--max-slew",
                             MAX_SLEW_N_PER_MS, *arguments), file

    def watch(self, side, kind):
        watch = SegmentWatch(self.bed, side, self.session, kind)
        self.watches.append(watch)
        return watch

    def start_session(self, scene=None, device=None, of_simulation=(), of_hand=()):
        """sim_server, both relays with options of their own, haptic_server and its recording: all as attributes;
        waits until it feels."""
        self.scene_watch, self.tool_watch = self.watch("b", "scene"), self.watch("a", "tool")
        self.sim = self.sim_server(scene)
        self.sim_relay, self.hand_relay = self.relay("simulation", *of_simulation), self.relay("hand", *of_hand)
        self.haptic, self.recording_file = self.hand(device)
        self.wait_until(self.is_felt, 10.0, "a force over the link")

    def is_felt(self):
        """Whether the last row on disk has nearly the whole force of a still hand on the wall."""
        return (last_force_N(self.recording_file) or 0.0) > 0.999 * FORCE_N

    def wait_for_return(self, since_s, watch=None):
        """Until something is published anew; s since then."""
        watch = watch or self.scene_watch
        self.wait_until(lambda: watch.first_published(since_s) is not None, 15.0, "something published")
        return watch.first_published(since_s) - since_s

    def stop_session(self):
        """The recording. All that still run end as after Ctrl-C, without a complaint."""
        self.stop_all(self.haptic, self.hand_relay, self.sim_relay, self.sim)
        return daemons.read_recording(self.recording_file)

    def stop_all(self, *programs):
        for program in programs:
            self.assertEqual(program.stop(), DONE, program.lines())
        for watch in self.watches:
            watch.stop()

    def assert_safe(self, recording, fade_s=None):
        """Nothing older was shown after something newer; no force without a fresh enough snapshot; none grew faster
        than it may."""
        self.assertEqual(going_back(recording), 0)
        self.assertEqual(without_snapshot(recording, fade_s or self.fade_s), 0)
        self.assertLessEqual(growth_N_per_ms(recording).max(), 1.001 * MAX_SLEW_N_PER_MS)

    def assert_returned(self, recording):
        """A still hand on the wall felt all of it in the end, but for the fade of the end itself."""
        self.assertGreater(recording.force_norm_N()[-300:].max(), 0.999 * FORCE_N)


def last_force_N(file):
    """Of the last whole row on disk; None before there is one. Reads no more than the ends of a long recording."""
    if not file.exists():
        return None
    with open(file, "rb") as stream:
        header = next((line for line in stream if not line.startswith(b"#")), b"").decode().split(",")
        begin = stream.tell()
        stream.seek(max(begin, file.stat().st_size - 4096))
        rows = stream.read().split(b"\n")[:-1]
    last = rows[-1].decode().split(",") if rows else []
    if len(last) != len(header):
        return None
    return sum(float(last[header.index(name)]) ** 2 for name in ("fx_N", "fy_N", "fz_N")) ** 0.5


def since_snapshot_s(recording):
    """Of each tick the time since the first tick that was shown what it is shown."""
    time_s, snapshot = recording.time_s, recording["snapshot_id"]
    first = numpy.concatenate(([True], numpy.diff(snapshot) != 0))
    return time_s - time_s[first][numpy.cumsum(first) - 1]


def without_snapshot(recording, fade_s):
    """Ticks with a force though the snapshot is older than a fade takes. A tick that came late was told late."""
    late_s = numpy.diff(recording.time_s, prepend=recording.time_s[0] - TICK_S)
    late_s = numpy.maximum.reduce([late_s, numpy.roll(late_s, 1), numpy.roll(late_s, 2)])
    old = since_snapshot_s(recording) > fade_s + 3 * TICK_S + late_s
    return int((old & (recording.force_norm_N() > 0.0)).sum())


def going_back(recording):
    """Steps back in the numbers of snapshots, but to the first ones of another segment: those of one segment go on
    from number to number, and another begins while no force is felt."""
    snapshot, force_N = recording["snapshot_id"], recording.force_norm_N()
    back = numpy.flatnonzero(numpy.diff(snapshot) < 0) + 1
    return int(sum(force_N[i - 1] != 0.0 for i in back))


def growth_N_per_ms(recording):
    """Of the norm, a tick."""
    passed_ms = 1e3 * numpy.diff(recording.time_s)
    return numpy.maximum(numpy.diff(recording.force_norm_N()), 0.0) / numpy.maximum(passed_ms, 1.0)


def silences_s(recording):
    """How long each snapshot was the newest, s."""
    since_s = since_snapshot_s(recording)
    last = numpy.append(numpy.flatnonzero(numpy.diff(recording["snapshot_id"]) != 0), len(since_s) - 1)
    return since_s[last]


def fades_s(recording):
    """From each last fresh snapshot that was followed by no force, to that."""
    since_s, force_N = since_snapshot_s(recording), recording.force_norm_N()
    ends = numpy.flatnonzero((force_N[1:] == 0.0) & (force_N[:-1] > 0.0)) + 1
    return since_s[ends]
