"""What is said of a file: its columns, what they are taken for, its gaps and jumps, and how to go on."""
import shlex

import numpy

from mapping import QUANTITIES

SHOWN = 24  # columns
SHOWN_FAULTS = 10


def columns(table, choices):
    used = {column.name: name for name, choice in choices.items() for column in choice.columns()}
    lines = [f"{table.file}: {table.kind}, {table.rows} rows, {len(table.columns)} columns"]
    lines += [f"  {note}" for note in table.notes]
    width = min(max(len(name) for name in table.names[:SHOWN]), 32)
    for k, column in enumerate(table.columns[:SHOWN], 1):
        values = table.numbers(column)
        good = values[numpy.isfinite(values)]
        span = f"{good.min():.6g} to {good.max():.6g}" if len(good) else f"text, such as '{str(column.values[0])[:24]}'"
        missing = f", {len(values) - len(good)} no number" if 0 < len(good) < len(values) else ""
        unit = f" [{column.unit}]" if column.unit else ""
        lines.append(f"  #{k:<3} {column.name + unit:{width}} {span}{missing}"
                     + (f"  <- {used[column.name]}" if column.name in used else ""))
    if len(table.columns) > SHOWN:
        lines.append(f"  and {len(table.columns) - SHOWN} more, to #{len(table.columns)}")
    return lines


def taken(choices, rate_hz, left):
    """left: names of columns that look like an orientation, which are not taken."""
    lines = []
    for name in ("time", "position", "orientation", "force"):
        if name == "time" and rate_hz:
            lines.append(f"time         rows at {rate_hz:g} Hz, by --rate")
        elif name == "orientation" and name not in choices and left:
            lines.append(f"{name:12} none found; not taken: {', '.join(left[:9])}{', ...' if len(left) > 9 else ''}, "
                         f"which look like one: --orientation COLUMNS:KIND of {', '.join(QUANTITIES[name])}; no Euler "
                         "angles")
        elif name not in choices:
            lines.append(f"{name:12} none found" + ("; --rate HZ for rows that come evenly" if name == "time" else ""))
        else:
            choice = choices[name]
            words = "given" if choice.is_given else "found by name" if choice.unit else "found"
            if not choice.unit:
                words += f"; unit not stated, may be {choice.suggestion}" if choice.suggestion else "; unit not stated"
                if name == "orientation":
                    words = "found; convention not stated, may be " + (choice.suggestion or "any")
            lines.append(f"{name:12} {choice.text()}  ({words})")
    return lines


def measured(trajectory, faults):
    steps_s = numpy.diff(trajectory.time_s)
    span_m = numpy.ptp(trajectory.position_m, axis=0)
    lines = [f"length       {trajectory.time_s[-1]:.6g} s, {len(trajectory.time_s)} rows, typically every "
             f"{1e3 * numpy.median(steps_s):.4g} ms, at most {1e3 * steps_s.max():.4g} ms",
             "extent       " + " x ".join(f"{1e3 * span:.4g}" for span in span_m) + " mm"]
    if trajectory.force_N is not None:
        lines.append(f"force        up to {numpy.linalg.norm(trajectory.force_N, axis=1).max():.4g} N")
    if trajectory.repeated:
        lines.append(f"left out     {trajectory.repeated} rows with the stamp of the next")
    if trajectory.invalid:
        lines.append(f"left out     {trajectory.invalid} rows with values that are missing")
    lines.append("faults       " + counted(faults))
    largest = sorted(faults, key=lambda fault: (fault.kind, -max(fault.size, fault.duration_s)))[:SHOWN_FAULTS]
    lines += [f"  {fault.text(trajectory)}" for fault in sorted(largest, key=lambda fault: fault.row)]
    if len(faults) > SHOWN_FAULTS:
        lines.append(f"  and {len(faults) - SHOWN_FAULTS} smaller ones")
    return lines


def counted(faults):
    counts = [(kind, sum(fault.kind == kind for fault in faults)) for kind in ("gap", "jump", "turn")]
    return ", ".join(f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in counts if count) or "none"


def command(table, choices, rate_hz, others):
    """The line that writes a trajectory of what was found."""
    words = ["stillgrid_import", str(table.file), *others]
    for name in ("time", "position", "orientation", "force"):
        if name == "time" and rate_hz:
            words += ["--rate", f"{rate_hz:g}"]
        elif name in choices:
            words += [f"--{name}", choices[name].text()]
    return "to write:    " + shlex.join([*words, "--out", "trajectory.csv"])
