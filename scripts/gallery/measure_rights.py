#!/usr/bin/python3
"""Measures how the 1 kHz loop keeps its time by what its user may: docs/charts/rights.csv.

Runs both daemons on tissue_and_blocks with SCHED_FIFO, with RealtimeKit's priority and with none, one
after the other and several times over, on a quiet machine and beside stress-ng, and keeps what
haptic_server's report says. Needs root, to grant and to take away; RealtimeKit is the tests' fake,
which grants as the real one does (SCHED_RR at 20, RLIMIT_RTTIME), for that needs a desktop session.
"""
import contextlib
import json
import os
import pathlib
import subprocess
import tempfile
import time

from measure_demo import HAND
from measuring import ROOT, fail, parser_of
from rights_bed import WITHOUT_RIGHTS, bus_command
from tables import write_rows

WAYS = ("fifo", "rtkit", "other")


@contextlib.contextmanager
def running(*command):
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def run(way, seconds, build, folder):
    """The report of one run, its haptic_server with this right and no other."""
    session = f"rights-{os.getpid()}"
    report = folder / "haptic.json"
    scene = ROOT / "sim_server/scene/scenes/tissue_and_blocks.toml"
    hand = [*(() if way == "fifo" else WITHOUT_RIGHTS), build / "bin/haptic_server", "--session", session, "--device", HAND,
            "--duration", str(seconds), "--report", report]
    address = folder / "bus"
    environment = os.environ | {"DBUS_SYSTEM_BUS_ADDRESS": f"unix:path={address}"}
    with contextlib.ExitStack() as beside:
        if way == "rtkit":
            beside.enter_context(running(*bus_command(folder, address)))
            os.environ.update(environment)
            while not address.exists():
                time.sleep(0.02)
            beside.enter_context(running(build / "tests/integration/fake_realtime_kit", "grants"))
            time.sleep(0.3)
        beside.enter_context(running(build / "bin/sim_server", "--scene", scene, "--session", session))
        subprocess.run([str(word) for word in hand], env=environment, check=True, stderr=subprocess.DEVNULL)
    address.unlink(missing_ok=True)
    return json.loads(report.read_text())


def measure(seconds, repeats, build):
    for load in ("quiet", "loaded"):
        with contextlib.ExitStack() as beside:
            if load == "loaded":
                beside.enter_context(running("stress-ng", "--cpu", "2", "--vm", "1", "--vm-bytes", "256M", "--quiet"))
            for repeat in range(repeats):
                for way in WAYS:
                    with tempfile.TemporaryDirectory() as folder:
                        report = run(way, seconds, build, pathlib.Path(folder))
                    got = report["scheduling"]["way"]
                    if got != way:
                        fail(f"{way}: the loop got {got}")
                    wake_ns = report["wake_ns"]
                    yield {"load": load, "way": way, "repeat": repeat, "ticks": report["ticks"],
                           "missed_ticks": report["missed_ticks"],
                           **{f"wake_{p}_us": f"{1e-3 * wake_ns[p]:.1f}" for p in ("p50", "p99", "p999")}}


def main():
    arguments = parser_of(__doc__, "2 s a run and one of each, not 10 s and eight").parse_args()
    if os.geteuid() != 0:
        fail("needs root, to grant rights and to take them away")
    rows = []
    for row in measure(*((2, 1) if arguments.small else (10, 8)), arguments.build):
        print(f"{row['load']}, {row['way']}: {row['missed_ticks']} of {row['ticks']} missed, wake p50 "
              f"{row['wake_p50_us']} us, p99 {row['wake_p99_us']} us", flush=True)
        rows.append(row)
    write_rows(arguments.charts / "rights.csv", rows)


if __name__ == "__main__":
    main()
