"""Calls a reader of others' in a process of its own: of a file with wrong bytes it may crash, not only refuse."""
import multiprocessing
import signal

import limits
from table import Unusable


def call(file, reader, *arguments):
    """What reader(file, data, *more) returns or refuses; a line where it crashes or takes too much memory."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=answer, args=(theirs, reader, file, *arguments), daemon=True)
    process.start()
    theirs.close()
    try:
        answered = ours.recv()
    except EOFError:
        raise Unusable(f"{file}: cannot be read: its reader crashed on it: expected a whole file") from None
    finally:
        process.terminate()
        process.join()
    if isinstance(answered, Unusable):
        raise answered
    return answered


def answer(pipe, reader, file, *arguments):
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the caller ends it
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        limits.limit_memory(len(arguments[0]))
        answered = reader(file, *arguments)
    except Unusable as error:
        answered = error
    except MemoryError:
        answered = Unusable(f"{file}: cannot be read: unpacks to more: expected at most "
                            f"{limits.room(len(arguments[0])) // limits.MIB} MiB")
    pipe.send(answered)
    pipe.close()
