#!/usr/bin/python3
"""Injects faults while the tool touches, and says of each what it did to the force.

With --charts FOLDER it writes faults.csv, the table, and fault_traces.csv, the forces. Exit status 1 if a fault did not end as it should."""
import argparse
import concurrent.futures
import pathlib
import signal
import sys
import unittest

import numpy

import daemons
from faults import call_log
from faults.catalogue import FAULTS
from faults.fault_run import FaultRun

sys.path.append(str(daemons.ROOT / "scripts" / "gallery"))
from tables import write_rows  # after the path it needs

AT_A_TIME = 4  # they mostly sleep
SHOWN_MS = (-50.0, 650.0)


def run_all(faults):
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        return list(pool.map(lambda fault: FaultRun().run_fault(fault), faults))


def number(value, digits):
    return "" if value is None else f"{value:.{digits}f}"


def row_of(outcome):
    fault, measured = outcome.fault, outcome.measured
    return {"kind": fault.kind, "fault": fault.name,
            "force_N": number(measured.force_N, 2),
            "step_N_per_ms": number(measured.step_N_per_ms, 3),
            "cut_N": number(measured.cut_N if fault.is_cut else 0.0, 2),
            "zero_ms": number(measured.zero_ms, 1),
            "limit_ms": number(fault.zero_ms, 0),
            "full_again_ms": number(measured.recovered_ms, 0),
            "in_the_end": end_of(fault)}


def end_of(fault):
    if fault.after_N is not None:
        return f"{fault.after_N:g} N"
    return f"exit {fault.status}" if fault.status >= 0 else signal.Signals(-fault.status).name


def trace_of(outcome):
    """Commanded forces round the moment of the fault, as the corners of a line."""
    if outcome.records is None:
        return []
    records = outcome.records
    records = records[~numpy.isin(records["call"], (call_log.FAULT_BEGINS, call_log.FAULT_ENDS))]
    time_ms = records["time_ns"] * 1e-6 - outcome.began_ms
    force_N = call_log.force_norms_N(records)
    within = (time_ms > SHOWN_MS[0]) & (time_ms < SHOWN_MS[1])
    before_N = force_N[time_ms <= SHOWN_MS[0]]
    corners = [(SHOWN_MS[0], before_N[-1])] if len(before_N) else []
    for time, force in zip(time_ms[within], force_N[within]):
        if corners and (time - corners[-1][0] > 5.0 or force == 0.0 < corners[-1][1]):
            corners.append((time - 0.01, corners[-1][1]))  # held until then
        if len(corners) > 1 and is_on_line(*corners[-2:], (time, force)):
            corners.pop()
        corners.append((time, force))
    return [{"kind": outcome.fault.kind, "fault": outcome.fault.name,
             "time_ms": number(time, 2), "force_N": number(force, 3)} for time, force in corners]


def is_on_line(first, middle, last):
    share = (middle[0] - first[0]) / (last[0] - first[0])
    return abs(first[1] + share * (last[1] - first[1]) - middle[1]) < 2e-3


class FaultTable(unittest.TestCase):
    def test_each_fault_leaves_the_force_within_its_limits_and_comes_to_the_end_it_should(self):
        complaints = [f"{outcome.fault.kind}: {outcome.fault.name}: {complaint}"
                      for outcome in run_all(FAULTS) for complaint in outcome.complaints]
        self.assertEqual(complaints, [], "\n".join(complaints))


def print_table(rows, outcomes):
    """As docs/safety.md has it, and after each row what was wrong."""
    print("| | Fault | Largest step, N/ms | No force after, ms | at most | Full again, ms | "
          "In the end |\n|---|---|---|---|---|---|---|")
    kind = ""
    for row, outcome in zip(rows, outcomes):
        zero = row["zero_ms"] + (", cut" if float(row["cut_N"]) > 0.0 else "")
        cells = (row["kind"] if row["kind"] != kind else "", row["fault"], row["step_N_per_ms"], zero,
                 row["limit_ms"], row["full_again_ms"], row["in_the_end"])
        print("".join(f"| {cell} " if cell else "| " for cell in cells) + "|")
        kind = row["kind"]
        for complaint in outcome.complaints:
            print(f"    {complaint}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--charts", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--only", default="", metavar="WORDS", help="of a fault's name")
    parser.add_argument("--small", action="store_true", help="every seventh fault")
    arguments = parser.parse_args()
    outcomes = run_all([fault for fault in FAULTS[::7 if arguments.small else 1]
                        if arguments.only in fault.name])
    measured = [outcome for outcome in outcomes if outcome.measured]
    for outcome in outcomes:
        if not outcome.measured:
            print(outcome.fault.name, outcome.complaints)
    rows = [row_of(outcome) for outcome in measured]
    print_table(rows, measured)
    if arguments.charts:
        write_rows(arguments.charts / "faults.csv", rows)
        write_rows(arguments.charts / "fault_traces.csv",
                   [row for outcome in measured for row in trace_of(outcome)])
    sys.exit(1 if any(outcome.complaints for outcome in outcomes) else 0)


if __name__ == "__main__":
    if sys.argv[1:2] and sys.argv[1].startswith(FaultTable.__name__):
        daemons.main()
    else:
        main()
