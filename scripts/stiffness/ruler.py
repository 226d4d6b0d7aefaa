"""A recording as the product meets it: both servers in lockstep, whose own field is the ruler."""
import argparse
import contextlib
import dataclasses
import io
import pathlib

import numpy

from fit_scene import PROBE_N_PER_M
from expectation import Unusable
from forces import FORCE_NAMES, POSITION_NAMES, read_forces
from law import Contact
from servers import Hand, into_frame, run

TOUCHED_SHARE = 0.05  # of the largest measured force: so much is contact, however deep the tool seems
RENDERED = {name: (f"rendered_{name}", 1.0) for name in FORCE_NAMES}  # what was asked for before the safety chain
FEWEST_ROWS = 100


class Recording:
    """A measured force beside where the tool was. columns: as of --force."""

    def __init__(self, file, columns):
        read = read_forces(file, columns)
        self.file, self.time_s = pathlib.Path(file), read.time_s
        if len(self.time_s) < FEWEST_ROWS:
            raise Unusable(f"{file}: {len(self.time_s)} rows: expected {FEWEST_ROWS} at least")
        none = numpy.zeros(len(self.time_s))
        self.force_N = numpy.stack([read.columns.get(name, none) for name in FORCE_NAMES], axis=1)


@dataclasses.dataclass
class Track:
    """The rows of a recording that the ruler reaches, in the scene's frame."""

    recording: Recording
    rows: numpy.ndarray  # their numbers in the recording
    normal: numpy.ndarray
    contact: Contact
    size_N: numpy.ndarray  # of the measured force
    far_N: float  # the largest force measured where the ruler does not reach

    def touched(self, offset_m):
        """Where the tool is in the surface, or a force says that it is."""
        force_N = self.contact.force_N
        return (self.contact.depth_m(offset_m) > 0.0) | (force_N > TOUCHED_SHARE * force_N.max())

    def along(self, force_N):
        """Of forces at all rows of the recording, the part along the normal at these."""
        return (force_N[self.rows] * self.normal).sum(axis=1)


class Ruler:
    """Replays recordings, in scenes that it writes into a folder of its own."""

    def __init__(self, scene, build, options, folder):
        self.scene, self.build, self.options, self.folder = scene, build, options, folder
        self.count = 0

    def replay(self, recording, scene_file):
        """What the product renders at the recording's stamps: force and place of the tool, scene's frame."""
        self.count += 1
        device = self.scene.document.get("device", {})
        options = ",".join(filter(None, (into_frame(recording.file, device), self.options)))
        hand = Hand("", recording.file.resolve(), None, self.folder / f"replay-{self.count}.csv", options)
        said = io.StringIO()
        with contextlib.redirect_stderr(said):  # what the servers note of each scene
            run(self.build, scene_file, [hand], argparse.Namespace(duration=None, sim="", haptic=""), self.folder)
        got = read_forces(hand.recording, RENDERED)
        hand.recording.unlink()
        return tuple(numpy.stack([numpy.interp(recording.time_s, got.time_s, got.columns[name]) for name in names],
                                 axis=1) for names in (FORCE_NAMES, POSITION_NAMES))

    def replay_text(self, recording, text):
        file = self.folder / "scene.toml"
        file.write_text(text)
        return self.replay(recording, file)

    def measure(self, recording, bound_m):
        """Depth, normal and foot of every row that comes within bound_m of the mesh: of a field that much farther out,
        PROBE_N_PER_M stiff, whose force is its depth."""
        pressed_N, tool_m = self.replay_text(recording, self.scene.alone(self.scene.field(bound_m)))
        size_N = numpy.linalg.norm(pressed_N, axis=1)
        is_near = size_N > 0.0
        measured_N = numpy.linalg.norm(recording.force_N, axis=1)
        if is_near.sum() < FEWEST_ROWS:
            raise Unusable(f"{recording.file}: {is_near.sum()} rows within {1e3 * bound_m:g} mm of body "
                           f"'{self.scene.body['name']}': expected {FEWEST_ROWS} at least: is it laid into the scene's "
                           "frame, in its unit?")
        rows = numpy.flatnonzero(is_near)
        normal = pressed_N[rows] / size_N[rows, None]
        gap_m = bound_m - size_N[rows] / PROBE_N_PER_M
        foot_m = self.scene.to_mesh(tool_m[rows] - (self.scene.tool_m + gap_m)[:, None] * normal)
        along_N = (recording.force_N[rows] * normal).sum(axis=1)
        contact = Contact(recording.time_s[rows], gap_m, foot_m, along_N)
        if not (contact.depth_m(bound_m) @ along_N > 0.0 and along_N.max() > 0.0):
            raise Unusable(f"{recording.file}: the measured force pulls the tool in, by up to {-along_N.min():.3g} N: "
                           "expected the force on the hand, away from the body: --force changes its sign")
        return Track(recording, rows, normal, contact, measured_N[rows], float(measured_N[~is_near].max(initial=0.0)))
