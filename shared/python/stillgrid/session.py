"""A session's programs, started and ended: a simulation of a scene file or one's own, and haptic_server."""
from collections.abc import Callable
import functools
import itertools
import json
import os
import pathlib
import subprocess
import tempfile
import time
from typing import Any

from . import _places, recording
from .errors import DaemonError
from .publisher import Publisher
from .reader import Reader
from .scene import Scene

_PATIENCE_S = 10.0
_numbers = itertools.count(1)


class Session:
    """Runs haptic_server, and sim_server where the scene is a file; leaving the with block ends both.

        with stillgrid.Session("tissue_and_blocks", duration_s=5) as session:
            pass  # or look at it: session.reader()
        print(session.report["force_N"], session.recording.force_N)

    A program that failed raises a DaemonError with its line. With a duration leaving the block waits
    for its end; else it ends the run there. The thread that enters the block leaves it: programs end
    with the thread that started them.
    """

    def __init__(self, scene: str | os.PathLike[str] | None = None, *, device: str = "phantom",
                 hand: str | None = None, lockstep: bool = False, duration_s: float | None = None,
                 record: str | os.PathLike[str] | None = None, name: str | None = None,
                 sim_arguments: tuple[str, ...] = (), haptic_arguments: tuple[str, ...] = ()):
        """scene: a file, or the name of a shipped one, for sim_server; None: a Publisher of one's own, by
        publish(). device: PLUGIN[:key=value,...]. lockstep: virtual time. record: where the recording
        stays, FILE.csv, or FILE.mcap, which is not read back; None: it is read, then removed. name: None is one of its own."""
        self.name = name or f"python-{os.getpid()}-{next(_numbers)}"
        self._is_named = name is not None
        self.lockstep = lockstep
        self.recording: recording.Recording | None = None  # of CSV, once it has ended
        self.report: dict[str, Any] | None = None  # haptic_server's, of docs/formats.md
        self.simulation_report: dict[str, Any] | None = None  # sim_server's
        self.messages: list[str] = []  # what the programs had to say, a line each
        self._duration_s = duration_s
        self._folder = tempfile.TemporaryDirectory(prefix="stillgrid-")
        self._record = pathlib.Path(record) if record else self._path("recording.csv")
        both = ["--session", self.name] + ["--lockstep"] * lockstep
        lasts = [] if duration_s is None else ["--duration", str(duration_s)]
        self._commands: dict[str, list[str]] = {}
        if scene is not None:
            # In real time the simulation outlives the hand, so that no force fades at the end.
            self._commands["sim_server"] = [
                "--scene", _places.scene_file(scene), "--report", str(self._path("sim_server.json")), *both,
                *(lasts if lockstep else []), *sim_arguments]
        self._commands["haptic_server"] = [
            "--device", device, "--record", str(self._record), "--report",
            str(self._path("haptic_server.json")), *(["--hand", hand] if hand else []), *both, *lasts,
            *haptic_arguments]
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def __enter__(self) -> "Session":
        try:
            for program, arguments in self._commands.items():
                self._start(program, arguments)
        except BaseException:
            self._end_all()
            raise
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            if kind is None:
                self.finish()
        finally:
            self._end_all()
            self._folder.cleanup()

    def publish(self, scene: Scene) -> Publisher:
        """This session's Publisher, on its clock, for a simulation of one's own; its steps() end with
        haptic_server."""
        publisher = Publisher(scene, self.name, virtual_time=self.lockstep)
        publisher._is_over = self._is_over
        return publisher

    def reader(self, hand: str | None = None) -> Reader:
        """A Reader of this session."""
        return Reader(self.name, hand)

    def check(self) -> None:
        """Raises what a program that failed has said."""
        for program, process in self._running.items():
            if process.poll():
                raise DaemonError(program, process.returncode, "".join(self._lines(program)[-1:]))

    def wait(self, timeout_s: float | None = None) -> bool:
        """Waits until haptic_server ends by itself: the duration, a trajectory's end. False: not within
        timeout_s. Ctrl-C ends the wait."""
        until_s = None if timeout_s is None else time.monotonic() + timeout_s
        while self._running["haptic_server"].poll() is None:
            self.check()
            if until_s is not None and time.monotonic() > until_s:
                return False
            time.sleep(0.005)
        self._let_end("sim_server", 0.5 if self._running["haptic_server"].returncode else 0.0)
        self.check()
        return True

    def finish(self) -> None:
        """Ends the run, after its duration where it has one; then recording and reports are there."""
        if self._duration_s is not None:
            self.wait()
        self.check()
        self._end("haptic_server")
        if self.lockstep and self._duration_s is not None:
            self._let_end("sim_server", _PATIENCE_S)
        self._end("sim_server")
        self.check()
        self.recording = None if self._record.suffix.lower() == ".mcap" else recording.load(self._record)
        self.messages = [line for program in self._running for line in self._lines(program)]
        self.report = self._read_report("haptic_server")
        self.simulation_report = self._read_report("sim_server")

    def _is_over(self) -> bool:
        self.check()
        return not self.lockstep and self._running["haptic_server"].poll() is not None

    def _path(self, name: str) -> pathlib.Path:
        return pathlib.Path(self._folder.name) / name

    def _start(self, program: str, arguments: list[str]) -> None:
        with open(self._path(program), "w") as stderr:
            # pdeathsig: not even a killed test run leaves a program behind.
            self._running[program] = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", _places.program(program), *arguments],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=stderr)

    def _let_end(self, program: str, patience_s: float) -> bool:
        process = self._running.get(program)
        try:
            return process is None or process.wait(patience_s) is not None
        except subprocess.TimeoutExpired:
            return False

    def _end(self, program: str) -> None:
        if not self._let_end(program, 0.0):
            self._running[program].terminate()
            if not self._let_end(program, _PATIENCE_S):
                self._running[program].kill()
                self._running[program].wait()

    def _end_all(self) -> None:
        for program in reversed(list(self._running)):
            self._end(program)
        # What one that was killed left of a session of our own would pile up; a named one is its user's.
        if not self._is_named and any(process.returncode < 0 for process in self._running.values()):
            subprocess.run([_places.program("segment_inspect"), "--session", self.name, "--remove-dead"],
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)

    def _lines(self, program: str) -> list[str]:
        return self._path(program).read_text(errors="replace").splitlines()

    def _read_report(self, program: str) -> dict[str, Any] | None:
        file = self._path(f"{program}.json")
        return json.loads(file.read_text()) if file.exists() else None


def replay(scene: Scene | str | os.PathLike[str], trajectory: str | os.PathLike[str],
           simulate: Callable[[Publisher], object] | None = None, *, options: str = "",
           duration_s: float | None = None, haptic_arguments: tuple[str, ...] = ()) -> Session:
    """Replays a recorded hand in virtual time, so that no clock decides anything, to the trajectory's
    end. Returns the session that was, for its recording and report.

    scene: a file or a shipped scene for sim_server; or a Scene, and simulate, which is called with a
    Publisher of it and publishes until steps() ends. options: of the replay device, as
    "resample=cubic,offset_z_m=-0.02".
    """
    if isinstance(scene, Scene) != (simulate is not None):
        raise ValueError("simulate: expected with a Scene, and only then")
    if "," in str(trajectory):
        raise ValueError(f"{trajectory}: expected a name without a comma: it separates options")
    device = ",".join(filter(None, (f"replay:file={trajectory}", options)))
    run = functools.partial(Session, device=device, lockstep=True, duration_s=duration_s,
                            haptic_arguments=haptic_arguments)
    if isinstance(scene, Scene):
        assert simulate is not None  # by the first check
        with run() as session:
            with session.publish(scene) as publisher:
                simulate(publisher)
    else:
        with run(scene) as session:
            session.wait()
    return session
