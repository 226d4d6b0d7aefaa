"""Units that a file may be in, and their size in ours."""
import re

TIME_S = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "iso": 1.0}
LENGTH_M = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254}
FORCE_N = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "gf": 9.80665e-3, "lbf": 4.4482216152605}
ROTATIONS = {"xyzw": 4, "wxyz": 4, "matrix": 9, "matrix_columns": 9, "rotation_vector": 3, "rotation_vector_deg": 3}

# As files write them.
WORDS = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "millis": "ms", "milliseconds": "ms",
    "µs": "us", "μs": "us", "usec": "us", "micros": "us", "microseconds": "us", "nsec": "ns", "nsecs": "ns",
    "nanosec": "ns", "nanoseconds": "ns", "meter": "m", "meters": "m", "metres": "m", "millimeters": "mm",
    "millimetres": "mm", "centimeters": "cm", "µm": "um", "newton": "N", "newtons": "N", "n": "N", "mn": "mN"}


def unit_of(text, known):
    """The unit that a word of a file is, or ''."""
    text = text.strip()
    if text in known:
        return text
    word = WORDS.get(text.lower(), text.lower())
    return word if word in known else ""


def split_unit(name, known):
    """time_ms, Time [ms], time (ms), time/ms: the name without its unit, and the unit or ''."""
    match = re.fullmatch(r"(.*?)(?:[_ ./]*[\[(]\s*([\wµμ]+)\s*[\])]|[_ /.]([A-Za-zµμ]+))", name.strip())
    if match and (unit := unit_of(match[2] or match[3], known)) and (match[2] or unit not in ("in", "min")):
        return match[1], unit
    return name, unit_of(name, known) if len(name) > 1 else ""
