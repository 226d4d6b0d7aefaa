"""Where the library and the programs are: beside this package, so that an installed tree may be moved."""
import os
import pathlib
import shutil
import sysconfig

SONAME = "libstillgrid.so.1"

_HERE = pathlib.Path(__file__).resolve().parent  # PREFIX/lib/python3/dist-packages/stillgrid
_LIB = _HERE.parents[2] if len(_HERE.parents) > 3 else _HERE


def library() -> str:
    """What to load: the library beside the package, else $STILLGRID_LIBRARY, else by the loader's search."""
    for folder in (_LIB, _LIB / (sysconfig.get_config_var("MULTIARCH") or "")):
        if (folder / SONAME).is_file():
            return str(folder / SONAME)
    return os.environ.get("STILLGRID_LIBRARY") or SONAME


def program(name: str) -> str:
    """The path of a program: beside the package, else beside $STILLGRID_LIBRARY, else on $PATH."""
    prefixes = [_LIB.parent]
    if named := os.environ.get("STILLGRID_LIBRARY"):
        prefixes.append(pathlib.Path(named).absolute().parents[1])
    for prefix in prefixes:
        if os.access(prefix / "bin" / name, os.X_OK):
            return str(prefix / "bin" / name)
    if found := shutil.which(name):
        return found
    raise FileNotFoundError(f"no program {name}: expected it at {_LIB.parent / 'bin' / name}, or on $PATH")


def scene_file(scene: "str | os.PathLike[str]") -> str:
    """A scene's file, or that of a shipped scene by its name."""
    shipped = _LIB.parent / "share" / "stillgrid" / "scenes" / f"{scene}.toml"
    for file in (pathlib.Path(scene), shipped):
        if file.is_file():
            return str(file)
    raise FileNotFoundError(f"{scene}: no such scene: expected a file, or the name of a shipped one")
