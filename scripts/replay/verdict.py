"""What a comparison says, in lines for people and as JUnit's XML for what reads tests."""
import dataclasses
import re
import xml.etree.ElementTree as xml

import numpy

from whole_file import whole

CONTEXT_ROWS = 3
ORIGINS = ("scene", "device", "device_driver")  # of a recording's head


@dataclasses.dataclass
class Verdict:
    """Of one hand; lines: all that is printed of it. headline: of a difference or an error, else empty."""

    name: str
    lines: list
    headline: str = ""
    is_error: bool = False


def headline_of(comparison):
    """The first difference in one line; empty where all is equal."""
    if comparison.first:
        row, column = comparison.first
        return (f"at {comparison.time_s[row]:.4f} s, {comparison.names[column]}: expected "
                f"{comparison.expected_N[row, column]:.6g} N, got {comparison.got_N[row, column]:.6g} N, difference "
                f"{comparison.difference_N[row, column]:+.3g} N, tolerance {comparison.tolerance_N:g} N "
                f"({comparison.expected.file}:{comparison.expected.lines[row]})")
    if comparison.moved:
        return moved_line(comparison)
    return "" if comparison.is_same_length else lengths_line(comparison)


def moved_line(comparison):
    row, name = comparison.moved
    return (f"positions differ first: at {comparison.time_s[row]:.4f} s, {name}: expected "
            f"{comparison.expected.columns[name][row]:.6g} m, got {comparison.got.columns[name][row]:.6g} m: the "
            "trajectory, its options or the scene's [device] are not those of EXPECTED")


def lengths_line(comparison):
    expected, got = comparison.expected, comparison.got
    return (f"lengths differ: {expected.file} ends at {expected.time_s[-1]:.4f} s after {len(expected.time_s)} rows, "
            f"the run at {got.time_s[-1]:.4f} s after {len(got.time_s)}")


def context_lines(comparison):
    """The rows around the first difference."""
    row, _ = comparison.first
    yield "  " + " ".join(["  time_s", *(f"{'expected ' + name:>15} {'got ' + name:>12}" for name in comparison.names)])
    for i in range(max(row - CONTEXT_ROWS, 0), min(row + CONTEXT_ROWS + 1, len(comparison.time_s))):
        values = " ".join(f"{comparison.expected_N[i, k]:15.6g} {comparison.got_N[i, k]:12.6g}"
                          for k in range(len(comparison.names)))
        yield f"{'>' if i == row else ' '} {comparison.time_s[i]:8.4f} {values}"


def largest_words(comparison):
    row, column = comparison.largest
    return (f"largest {comparison.difference_N[row, column]:+.3g} N, {comparison.names[column]} at "
            f"{comparison.time_s[row]:.4f} s")


def result_lines(comparison):
    """All that a comparison says, the first difference first."""
    if comparison.moved:
        yield moved_line(comparison)
    if comparison.first:
        yield "first difference: " + headline_of(comparison)
        yield from context_lines(comparison)
    if not comparison.is_same_length:
        yield lengths_line(comparison)
    norm_N = numpy.linalg.norm(comparison.difference_N, axis=1)
    yield (f"compared {len(norm_N)} rows, {', '.join(comparison.names)}: difference rms "
           f"{numpy.sqrt(numpy.mean(norm_N ** 2)):.3g} N, {largest_words(comparison)}; "
           f"{comparison.is_different.sum()} rows beyond {comparison.tolerance_N:g} N")
    for name in ORIGINS:
        was, now = (forces.about.get(name) for forces in (comparison.expected, comparison.got))
        if was and now and was != now:
            yield f"{name}: EXPECTED is of '{was}', this run of '{now}'"


def in_xml(text):
    """What XML cannot hold, as Python writes it: \\x1b."""
    return re.sub(r"[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", lambda match: ascii(match[0])[1:-1], text)


def write_junit(file, suite, verdicts, seconds):
    """One case a hand, so that what reads JUnit names the hand that differs; whole or not at all."""
    failed = sum(bool(verdict.headline) and not verdict.is_error for verdict in verdicts)
    root = xml.Element("testsuites")
    cases = xml.SubElement(root, "testsuite", name="replay_check", tests=str(len(verdicts)), failures=str(failed),
                           errors=str(sum(verdict.is_error for verdict in verdicts)), skipped="0",
                           time=f"{seconds:.3f}")
    for verdict in verdicts:
        case = xml.SubElement(cases, "testcase", classname=in_xml(suite), name=in_xml(verdict.name),
                              time=f"{seconds / len(verdicts):.3f}")
        if verdict.headline:
            kind = "error" if verdict.is_error else "failure"
            xml.SubElement(case, kind, message=in_xml(verdict.headline)).text = in_xml("\n".join(verdict.lines))
        elif verdict.lines:
            xml.SubElement(case, "system-out").text = in_xml("\n".join(verdict.lines))
    xml.indent(root)
    with whole(file) as part:
        part.write_bytes(xml.tostring(root, encoding="utf-8", xml_declaration=True))
