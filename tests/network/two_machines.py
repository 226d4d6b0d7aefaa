"""Two machines on one, for a test: namespaces, and a link between them that may delay and lose.

    with TwoMachines("delay_ms 10", "loss 0.01", clock_offset_s=1000.0) as bed:
        server = bed.run("a", [PROGRAM, "--session", "s"])     # a Popen, which may be killed and run again
        bed.control("partition on")
        print(bed.counters()["a"]["lost"])
"""
import json
import os
import pathlib
import subprocess

BUILD = pathlib.Path(os.environ.get("STILLGRID_BUILD_DIR",
                                    pathlib.Path(__file__).resolve().parents[2] / "build" / "release"))
EMULATOR = BUILD / "tests" / "link_emulator"
PATIENCE = float(os.environ.get("STILLGRID_PATIENCE", 1))  # times every limit of time

ADDRESS = {"a": "10.77.0.1", "b": "10.77.0.2"}
INTERFACE = "link"
NOT_GRANTED = 2  # exit status of link_emulator


class NotGranted(Exception):
    """The machine grants no namespaces or no TUN interface; the text says which."""


def skip_reason(clock_offset_s=0.0):
    """What the machine does not grant, or None."""
    try:
        TwoMachines(clock_offset_s=clock_offset_s).close()
    except NotGranted as missing:
        return str(missing)
    return None


class TwoMachines:
    """Sides "a" and "b", joined by link_emulator. Nothing that runs in them outlives this, or this process.

    settings are lines as of control(). Each side has a /dev/shm of its own, other files are this machine's.
    b's monotonic clock is ahead by clock_offset_s. Raises NotGranted."""

    def __init__(self, *settings, clock_offset_s=0.0, seed=1):
        # pdeathsig: a test that ctest kills for its time takes the sides along.
        self._emulator = subprocess.Popen(
            ["setpriv", "--pdeathsig", "KILL", EMULATOR, "--clock-offset", repr(float(clock_offset_s)),
             "--seed", str(seed), *settings],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        first = self._emulator.stdout.readline()
        if not first:
            _, said = self._emulator.communicate()
            raise (NotGranted if self._emulator.returncode == NOT_GRANTED else RuntimeError)(said.strip())
        self._entrances = json.loads(first)
        self._programs = []
        self.is_open = True

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.is_open:
            self.close()

    def argv(self, side, arguments):
        """The command line by which a program of this machine runs on a side, in this process' folder. The process
        becomes the program: its number, signals and exit status are the program's. It ends with its parent."""
        return [*self._entrances[side], f"--wdns={os.getcwd()}",
                "setpriv", "--pdeathsig", "KILL", *map(str, arguments)]

    def run(self, side, arguments, **options):
        """Starts a program on a side, options as of Popen."""
        process = subprocess.Popen(self.argv(side, arguments), **options)
        self._programs.append(process)
        return process

    def control(self, line):
        """Changes a setting of the link from now on: "loss 0.01", or "a loss 0.01" of what a sends (link_emulator
        --help)."""
        said = self._ask(line)
        if said != "ok":
            raise ValueError(said)

    def counters(self):
        """Packets so far, by the side that sent them: {"a": {"sent": 12, "lost": 1, ...}, "b": {...}}."""
        return json.loads(self._ask("counters"))

    def shared_memory(self, side):
        """The folder that is /dev/shm on a side."""
        return pathlib.Path(f"/proc/{self._holder(side)}/root/dev/shm")

    def dropped_by_kernel(self, side):
        """What a side's kernel dropped, which is not the link's doing: packets before the interface and behind it,
        datagrams that a full socket had no room for, and packets of which not all fragments came in time."""
        folder = pathlib.Path(f"/proc/{self._holder(side)}/net")
        rows = [line.split() for line in (folder / "dev").read_text().splitlines()]
        interface = next(row for row in rows if row[0] == f"{INTERFACE}:")
        counts = {}
        lines = (folder / "snmp").read_text().splitlines()
        for names, values in zip(lines[::2], lines[1::2]):
            kind = names.split()[0]
            counts.update({kind + name: int(value) for name, value in zip(names.split()[1:], values.split()[1:])})
        return {"interface": int(interface[4]) + int(interface[12]), "socket": counts["Udp:RcvbufErrors"],
                "fragments": counts["Ip:ReasmFails"]}

    def kill(self):
        """Kills the emulator as nothing can catch it: the link is cut and both sides end. close() is still due."""
        self._emulator.kill()

    def close(self):
        """Kills all that runs on both sides. Returns the last counters; None if the emulator was dead."""
        self.is_open = False
        for program in self._programs:  # one that has not entered its side yet is not found there
            program.kill()
            program.wait(PATIENCE * 10.0)
        self._emulator.stdin.close()
        lines = self._emulator.stdout.read().splitlines()
        self._emulator.wait(PATIENCE * 10.0)
        for file in (self._emulator.stdout, self._emulator.stderr):
            file.close()
        return json.loads(lines[-1]) if lines else None

    def _ask(self, line):
        self._emulator.stdin.write(f"{line}\n")
        self._emulator.stdin.flush()
        return self._emulator.stdout.readline().rstrip("\n")

    def _holder(self, side):
        words = self._entrances[side]
        return int(words[words.index("--target") + 1])
