"""Files that appear whole or not at all."""
import contextlib
import pathlib


@contextlib.contextmanager
def whole(file):
    """A file beside it to write to, which takes its name, where a link leads, once all is well; what is no file, a
    pipe, is written to."""
    file = pathlib.Path(file).resolve()
    if file.exists() and not file.is_file():
        yield file
        return
    part = file.with_name(file.name + ".part")
    try:
        yield part
        part.replace(file)
    except OSError as error:
        if error.filename and str(error.filename) != str(part):
            raise
        raise OSError(error.errno, error.strerror, str(file)) from None  # a full disk names no file
    finally:
        part.unlink(missing_ok=True)
