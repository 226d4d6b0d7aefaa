"""What can go wrong, one line each."""
import enum


class Code(enum.IntEnum):
    """Result codes of the library, as proto/stillgrid.h has them."""

    OK = 0
    NOTHING = 1
    AGAIN = 2
    ARGUMENT = -1
    ORDER = -2
    CAPACITY = -3
    SESSION = -4
    VERSION = -5
    THREAD = -6
    MEMORY = -7
    FAULT = -8


class StillgridError(Exception):
    """A call that failed, and has changed nothing: its code, and the line that says what was wrong."""

    def __init__(self, code: int, line: str):
        super().__init__(line)
        self.code = Code(code) if code in Code._value2member_map_ else code
        self.line = line

    def __reduce__(self) -> tuple[type, tuple[int, str]]:
        return type(self), (int(self.code), self.line)


class DaemonError(StillgridError):
    """A sim_server or haptic_server that ended with an error: its exit status, and its last line."""

    def __init__(self, program: str, status: int, line: str):
        super().__init__(Code.SESSION, line or f"{program} ended with status {status}")
        self.program = program
        self.status = status

    def __reduce__(self) -> tuple[type, tuple[str, int, str]]:  # type: ignore[override]
        return type(self), (self.program, self.status, self.line)
