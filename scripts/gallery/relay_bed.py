"""Sessions over two machines on one (tests/network/two_machines.py): what the charts of the relay share."""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

from measuring import ROOT, fail, program

sys.path.append(str(ROOT / "tests/network"))
import two_machines  # after the path it needs

SCENES = ROOT / "sim_server/scene/scenes"
SESSION = "chart"
CLOCK_OFFSET_S = 1234.5
PATIENCE_S = 20.0


class Bed:
    """Two machines and a folder for what their programs write; all of it ends with the bed. Side a has the
    simulation, b the hand. What a program says on standard error is in FOLDER/NAME.log."""

    def __init__(self, build, *settings, seed=1, clock_offset_s=CLOCK_OFFSET_S):
        two_machines.EMULATOR = program(build, "link_emulator")
        self.build = build
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)
        try:
            self.machines = two_machines.TwoMachines(*settings, seed=seed, clock_offset_s=clock_offset_s)
        except two_machines.NotGranted as missing:
            fail(f"needs two network namespaces: {missing}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.machines.close()
        self._folder.cleanup()

    def start(self, side, name, argv, **options):
        with open(self.folder / f"{name}.log", "w") as log:
            return self.machines.run(side, argv, stderr=log, stdin=subprocess.DEVNULL, **options)

    def sim_server(self, scene, *arguments):
        return self.start("a", "sim", [program(self.build, "sim_server"), "--scene", SCENES / f"{scene}.toml",
                                       "--session", SESSION, *arguments])

    def relays(self, hand="", of_simulation=(), of_hand=()):
        """Both of one hand: (beside the simulation, beside the hand), reports in FOLDER/simulationHAND.json and
        handHAND.json."""
        return tuple(
            self.start(side, f"{role}{hand}",
                       [program(self.build, "scene_relay"), role, "--session", SESSION, "--interface",
                        two_machines.INTERFACE, "--report", self.folder / f"{role}{hand}.json",
                        *(("--hand", hand) if hand else ()), *more])
            for side, role, more in (("a", "simulation", of_simulation), ("b", "hand", of_hand)))

    def haptic_server(self, side, device, *arguments, hand=""):
        return self.start(side, f"haptic{hand}",
                          [program(self.build, "haptic_server"), "--session", SESSION, "--device", device,
                           "--record", self.folder / f"haptic{hand}.csv", "--report",
                           self.folder / f"haptic{hand}.json", *(("--hand", hand) if hand else ()), *arguments])

    def wait_for(self, side, kind, hand=""):
        """Until a segment, "scene" or "tool", stands there."""
        name = f"stillgrid-*/{SESSION}{'+' + hand if hand else ''}-{kind}"
        wait_until(lambda: any(self.machines.shared_memory(side).glob(name)), f"a {kind} on side {side}")

    def end(self, *programs):
        """Ends programs in order, so that each writes its report."""
        for process in programs:
            process.terminate()
            process.wait(PATIENCE_S)

    def report(self, name):
        try:
            return json.loads((self.folder / f"{name}.json").read_text())
        except (OSError, ValueError):
            log = self.folder / f"{name.removesuffix('.json')}.log"
            lines = log.read_text().strip().splitlines() if log.exists() else []
            fail(f"{name}: expected a report" + (f": {lines[-1]}" if lines else ""))


def wait_until(is_so, what, limit_s=PATIENCE_S):
    end_s = time.monotonic() + limit_s
    while not is_so():
        if time.monotonic() > end_s:
            fail(f"expected {what} within {limit_s:g} s")
        time.sleep(0.02)


def median(values):
    values = sorted(values)
    middle = len(values) // 2
    return values[middle] if len(values) % 2 else 0.5 * (values[middle - 1] + values[middle])
