"""How a program ends that cannot go on: in one line, or without one where nobody reads."""
import os
import signal
import sys

COULD_NOT_RUN = 2


def missing_package(what, name, debian):
    return f"{what} needs Python's {name}, which is missing: expected apt install {debian}"


def require_numpy(program):
    """Before what imports it."""
    try:
        __import__("numpy")
    except ImportError:
        print(f"{program}: {missing_package('it', 'numpy', 'python3-numpy')}", file=sys.stderr)
        sys.exit(COULD_NOT_RUN)


def line_of(error):
    """Of an OSError."""
    return f"{error.filename2 or error.filename or 'standard output'}: {error.strerror}"


def end_unread():
    """Where `| head` has read enough: as other programs end, by SIGPIPE."""
    leave_unsaid()
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGPIPE)


def flush():
    """Before a line to standard error, whatever became of standard output."""
    try:
        sys.stdout.flush()
    except OSError:
        leave_unsaid()


def leave_unsaid():
    """What is still to be printed goes nowhere, so that Python does not try once more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
