"""One fault: both daemons in real time, the tool touching, the fault, and what became of it."""
import dataclasses
import pathlib
import signal
import time
import typing

import numpy

import daemons
from faults import call_log
from faults.measure import (FADE_N_PER_MS, STALL_MS, Measured, broken_limits, fault_moments_ms,
                            measure)

DRIVER = daemons.BUILD / "tests" / "integration" / "faults" / "faulty_driver.so"
_SETTLED = 50  # ticks


@dataclasses.dataclass
class Fault:
    """What is injected, and what must come of it."""
    kind: str  # of the table's groups
    name: str  # as the table says it
    device: str = ""  # options of faulty_driver.so
    haptic: tuple = ()  # options of haptic_server
    inject: typing.Optional[typing.Callable] = None  # given the run; nothing: the driver does it
    scene: typing.Any = "wall"
    full_N: float = 2.0  # before
    zero_ms: typing.Optional[float] = None  # within which there is no force; nothing: there is one
    late_ms: float = 0.0  # by which the thread that notices, of no priority, may be late
    may_be_zero: bool = False  # or there is not, as it happens
    is_cut: bool = False  # at once, by design
    is_smooth: bool = False  # nothing but fades and ramps
    after_N: typing.Optional[float] = 2.0  # in the end; nothing: the run ends by itself
    status: int = daemons.DONE  # of haptic_server, by itself or when it is stopped
    flag: str = ""  # of the report, that must have been counted
    says: str = ""  # on standard error
    leaves_report: bool = True
    ends_after_s: float = 5.0  # at most


@dataclasses.dataclass
class Outcome:
    fault: Fault
    measured: Measured
    records: numpy.ndarray
    began_ms: float
    ended_ms: typing.Optional[float]
    complaints: list


def is_there(pid):
    """Whether a process runs, that may be no child of ours."""
    return pathlib.Path(f"/proc/{pid}").exists()


class FaultRun(daemons.SessionTest):
    """Used for its daemons and its folder; it is no test of its own."""

    def runTest(self):
        pass

    def run_fault(self, fault):
        self.setUp()
        try:
            return self._run_fault(fault)
        except AssertionError as error:
            said = [line for daemon in self.daemons for line in daemon.lines()]
            return Outcome(fault, None, None, 0.0, None, [str(error), *said])
        finally:
            self.tearDown()

    def _run_fault(self, fault):
        self.log = call_log.CallLog(f"/dev/shm/stillgrid-{self.session}-calls")
        self.recording, self.report = self.folder / "run.csv", self.folder / "run.json"
        self.began_ms = self.ended_ms = None
        self.sim = self.sim_server(self.scene_argument(fault.scene))
        self.device = f"{DRIVER}:log={self.log.file},{fault.device}".rstrip(",")
        self.haptic_options = fault.haptic
        self.hand = self.start_hand()
        self.wait_until(lambda: self._settled_at(fault.full_N), 8.0, f"{fault.full_N} N before")
        self.worker = self.hand.pid
        if fault.inject is None:
            self.log.trigger()
            self.wait_until(lambda: self._driver_moment(0) is not None, 3.0, "the fault")
        else:
            fault.inject(self)
        self._wait_for_end(fault)
        return self._judge(fault)

    def start_hand(self):
        return self.haptic_server(self.device, "--record", self.recording, "--report", self.report,
                                  *self.haptic_options)

    def scene_argument(self, scene):
        return scene if isinstance(scene, str) else self.write(*scene)

    # For injections.
    def begin(self):
        self.began_ms = time.monotonic() * 1e3

    def end(self):
        self.ended_ms = time.monotonic() * 1e3

    def _driver_moment(self, which):
        return fault_moments_ms(self.log.records())[which]

    def _settled_at(self, force_N):
        records = self.log.records()
        writes = records[records["call"] == call_log.WRITE][-_SETTLED:]
        last_N = call_log.force_norms_N(records[-_SETTLED:])
        return len(writes) == _SETTLED and (abs(last_N - force_N) <= 0.01 * force_N).all()

    def has_been_zero(self):
        began_ms = self.began_ms or self._driver_moment(0)
        records = self.log.records()
        told = records[(records["time_ns"] * 1e-6 >= began_ms)
                       & (records["call"] <= call_log.EMERGENCY_STOP)]
        return (call_log.force_norms_N(told) == 0.0).any()

    def _wait_for_end(self, fault):
        if fault.after_N is None:
            self.hand.wait(fault.ends_after_s)
            self.wait_until(lambda: not is_there(self.worker), 5.0, "the end of the loop's process")
            return
        if fault.zero_ms is not None:
            self.wait_until(lambda: self.has_been_zero() or not self.hand.runs(), 5.0, "no force")
        else:
            time.sleep(0.3)  # of the fault, to be looked at
        if "for_s" in fault.device:
            self.wait_until(lambda: self._driver_moment(1) is not None, 5.0, "the fault's end")
        self.wait_until(lambda: self._settled_at(fault.after_N) or not self.hand.runs(), 8.0,
                        f"{fault.after_N} N after")
        self.settled_calls = len(self.log.records())
        if self.hand.runs():
            self.hand.signal(signal.SIGINT)

    def _judge(self, fault):
        status = self.hand.wait(5.0)
        records = self.log.records()
        before_stop = records if fault.after_N is None else records[:self.settled_calls]
        began_ms, ended_ms = fault_moments_ms(records)
        began_ms, ended_ms = self.began_ms or began_ms, self.ended_ms or ended_ms
        measured = measure(before_stop, began_ms, ended_ms, fault.after_N or fault.full_N)
        if fault.full_N == 0.0:
            measured.zero_ms = None
        complaints = broken_limits(records) + self._broken_promises(fault, measured)
        if status != fault.status:
            complaints.append(f"exit status {status}, expected {fault.status}")
        if call_log.force_norms_N(records)[-1] != 0.0:
            complaints.append("the device was left with a force")
        if fault.inject is None and fault.status not in (daemons.DONE, daemons.BAD_INPUT):
            complaints += self._commanded_after_fault(fault, records)
        complaints += self._broken_records(fault)
        if complaints:
            complaints += self.hand.lines() + self.sim.lines()
        return Outcome(fault, measured, before_stop, began_ms, ended_ms, complaints)

    @staticmethod
    def _commanded_after_fault(fault, records):
        """A broken device is told nothing but to stop."""
        first = numpy.flatnonzero(records["call"] == call_log.FAULT_BEGINS)[0]
        stop = first + numpy.flatnonzero(numpy.isin(
            records["call"][first:], (call_log.EMERGENCY_STOP, call_log.ACTIVATE)))
        if len(stop) == 0:
            return ["it was neither stopped nor released"]
        forces_N = call_log.force_norms_N(records[first:stop[0]])
        may_follow = 1 if "fault=write" in fault.device else 0  # the write that fails
        return (["told a force after the fault"] if numpy.count_nonzero(forces_N) > may_follow
                else [])

    def _is_starved(self):
        """Whether a busy machine held up the simulation for so long that the force faded."""
        return self.report.exists() and daemons.read_report(self.report)["age_s"]["max"] > 0.15

    def _broken_promises(self, fault, measured):
        broken = []
        is_stalled = measured.gap_ms >= STALL_MS
        if fault.zero_ms is None:
            may_be_zero = fault.may_be_zero or is_stalled or self._is_starved()
            if measured.zero_ms is not None and not may_be_zero:
                broken.append(f"no force {measured.zero_ms:.1f} ms later")
        elif measured.zero_ms is None:
            broken.append("the force did not go to zero")
        else:
            # A tick comes when the machine grants it.
            late_ms = 2.0 + max(fault.late_ms, 0.0 if fault.is_cut else 2.0 * measured.gap_ms)
            if measured.zero_ms > fault.zero_ms + late_ms:
                broken.append(f"no force only {measured.zero_ms:.1f} ms later, expected "
                              f"{fault.zero_ms} (longest gap {measured.gap_ms:.1f} ms)")
        # What is left of a fade where another force ramps in may be of that one, too.
        if fault.is_smooth and measured.step_N_per_ms > 1.5 * FADE_N_PER_MS:
            broken.append(f"{measured.step_N_per_ms:.3g} N/ms, expected the {FADE_N_PER_MS} of a fade")
        if measured.cut_N > 0.0 and not (fault.is_cut or is_stalled):
            broken.append(f"{measured.cut_N:.3g} N cut at once")
        return broken

    def _broken_records(self, fault):
        """Of the report, the recording and what was said."""
        broken = []
        if fault.says and not any(fault.says in line for line in self.hand.lines()):
            broken.append(f"said nothing of '{fault.says}'")
        if not fault.leaves_report:
            return broken
        if not self.report.exists():
            return broken + ["there is no report"]
        report = daemons.read_report(self.report)
        if fault.flag and report["safety"][fault.flag] == 0:
            broken.append(f"no tick was flagged {fault.flag}")
        if self.recording.exists():
            rows = len(daemons.read_recording(self.recording)["time_s"])
            if rows + report["lost_rows"] < report["ticks"]:
                broken.append(f"{rows} rows and {report['lost_rows']} lost of {report['ticks']}")
        return broken
