"""For pytest: a recorded hand replayed against a simulation, its forces compared (docs/python.md).

pytest finds it by itself, where the package is on its path.
"""
from collections.abc import Callable
import os
import pathlib

import pytest

from .publisher import Publisher
from .recording import compare_forces, load, save_forces
from .scene import Scene
from .session import Session, replay


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.getgroup("stillgrid").addoption(
        "--stillgrid-write-expected", action="store_true",
        help="stillgrid_session.assert_forces() writes what was felt as what is expected from now on")


class ReplayedSessions:
    """What the fixture stillgrid_session gives a test."""

    def __init__(self, folder: pathlib.Path, writes: bool):
        self._folder = folder
        self._writes = writes

    def replay(self, scene: Scene | str | os.PathLike[str], trajectory: str | os.PathLike[str],
               simulate: Callable[[Publisher], object] | None = None, *, options: str = "",
               duration_s: float | None = None, haptic_arguments: tuple[str, ...] = ()) -> Session:
        """stillgrid.replay(), the trajectory looked for beside the test."""
        return replay(scene, self._folder / trajectory, simulate, options=options, duration_s=duration_s,
                      haptic_arguments=haptic_arguments)

    def assert_forces(self, session: Session, expected: str | os.PathLike[str],
                      tolerance_N: float = 0.01) -> None:
        """The forces felt are those of a file beside the test, at its stamps, but for tolerance_N a
        component. pytest --stillgrid-write-expected writes that file."""
        assert session.recording is not None
        file = self._folder / expected
        if self._writes:
            save_forces(file, session.recording)
        if not file.exists():
            pytest.fail(f"{file}: no such file: expected pytest --stillgrid-write-expected once", pytrace=False)
        if line := compare_forces(session.recording, load(file), tolerance_N):
            pytest.fail(line, pytrace=False)


@pytest.fixture
def stillgrid_session(request: pytest.FixtureRequest) -> ReplayedSessions:
    """Replays recorded hands in virtual time: replay(), assert_forces()."""
    return ReplayedSessions(request.path.parent, request.config.getoption("--stillgrid-write-expected"))
