"""Runs of fit_run, each one command line with one JSON result, kept by a hash of all that it depends on.

A batch goes through GNU parallel, here or on other machines. All paths are relative to the fit's folder, so that
machines which share no folder are sent what a run reads.
"""
import dataclasses
import functools
import hashlib
import json
import os
import pathlib
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time


# Exit statuses of fit_run, and of a shell for a program that is not there.
REFUSED, COULD_NOT_START = 1, 2
NEVER_RAN = (None, COULD_NOT_START, 126, 127)
PLUGINS = ("phantom", "replay")  # that fit_run loads


class Unusable(Exception):
    """The fit cannot go on; one line says why."""


class Printed(Exception):
    """The runs that are missing were printed; nothing was run."""


@dataclasses.dataclass
class Machines:
    """Where runs go."""
    program: str  # fit_run here
    jobs: int | None = None  # on each machine; none: one a core
    sshlogin: str | None = None
    ssh: str | None = None
    remote_program: str | None = None
    print_only: bool = False


class Progress:
    """A bar where somebody looks, else a line every 10 s."""
    PATIENCE_S, WIDTH = 10.0, 28

    def __init__(self):
        self.is_terminal, self.last_s, self.start_s = sys.stderr.isatty(), time.monotonic(), time.monotonic()

    def show(self, what, done, total):
        now_s = time.monotonic()
        if self.is_terminal:
            full = self.WIDTH * done // max(total, 1)
            sys.stderr.write(f"\r\033[K[{'#' * full}{'.' * (self.WIDTH - full)}] {done}/{total} {what}, "
                             f"{now_s - self.start_s:.0f} s")
            sys.stderr.flush()
        elif now_s - self.last_s > self.PATIENCE_S:
            self.last_s = now_s
            print(f"scene_fit: {what}: {done} of {total} runs, {now_s - self.start_s:.0f} s", file=sys.stderr)

    def clear(self):
        if self.is_terminal:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()


@functools.lru_cache(None)
def _hash_at(path, size, time_ns):  # the latter two only to notice a change
    del size, time_ns
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def hash_of(path):
    stat = os.stat(path)
    return _hash_at(str(path), stat.st_size, stat.st_mtime_ns)


def plugins_of(program):
    """The files of PLUGINS, as fit_run finds them (haptic_server/device/device_spec.cpp)."""
    above = pathlib.Path(program).resolve().parent.parent
    listed = filter(None, os.environ.get("STILLGRID_DEVICE_PATH", "").split(":"))
    folders = [*map(pathlib.Path, listed), *(root / "lib/stillgrid/devices" for root in (above, above.parent))]
    found = (next(filter(pathlib.Path.is_file, (folder / f"{name}.so" for folder in folders)), None)
             for name in PLUGINS)
    return [file for file in found if file]


def check_words(words):
    """A line of a batch holds a run."""
    for word in map(str, words):
        if not word.isprintable():
            raise Unusable(f"{word!r}: expected printable characters only, no tab and no line break")


def write_whole(file, text):
    part = file.with_name(file.name + ".part")
    part.write_text(text)
    part.replace(file)


class Runs:
    def __init__(self, folder, machines, progress):
        self.folder, self.machines, self.progress = folder, machines, progress
        self.kept = folder / "runs"
        self.kept.mkdir(exist_ok=True)

    def key(self, arguments, files):
        check_words((*arguments, *files))
        programs = (self.machines.program, *plugins_of(self.machines.program))
        parts = [*map(hash_of, programs), *map(str, arguments),
                 *(f"{file}={hash_of(self.folder / file)}" for file in sorted(files))]
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]

    def make(self, arguments, file):
        """Runs fit_run here, for what it writes; nothing to do where that file is there."""
        if (self.folder / file).is_file():
            return
        done = subprocess.run([self.machines.program, *arguments], cwd=self.folder, capture_output=True, text=True,
                              check=False)
        if done.returncode or not (self.folder / file).is_file():
            lines = done.stderr.strip().splitlines() or [f"fit_run ended with status {done.returncode}"]
            raise Unusable(lines[-1].removeprefix("fit_run: "))

    def results(self, what, requests, alone=False):
        """What came of each (arguments, files read), in their order.

        alone: one after the other and on this machine, so that times may be compared; never printed for others to
        run. What fit_run refused is {"refused": its line}, what crashed {"crashed": its last line}, and only the
        latter is tried again another time. Throws where one could not even start.
        """
        keys = [self.key(*request) for request in requests]
        missing = {key: request for key, request in zip(keys, requests) if not (self.kept / f"{key}.json").is_file()}
        crashed = {}
        if missing:
            if self.machines.print_only and not alone:
                self._print(missing)
                raise Printed(f"{what}: {len(missing)} runs to do")
            crashed = self._run(what, missing, alone)
        return [crashed[key] if key in crashed else self._read(key) for key in keys]

    def _read(self, key):
        file = self.kept / f"{key}.json"
        try:
            # Empty: of a printed run that was refused.
            result = json.loads(file.read_text() or '{"refused": "refused where it was run"}')
            if isinstance(result, dict):
                return result
        except (OSError, ValueError):
            pass
        raise Unusable(f"{file}: expected the line of JSON that fit_run wrote; remove the file to run it again")

    def _command(self, program, arguments):
        return shlex.join([str(program), *map(str, arguments)])

    def _print(self, missing):
        program = self.machines.remote_program or self.machines.program
        check_words([self.folder])
        for key, (arguments, _) in missing.items():
            file = f"runs/{key}.json"
            print(f"cd {shlex.quote(str(self.folder))} && {{ {self._command(program, arguments)} > {file}.part; "
                  f"[ $? -le {REFUSED} ]; }} && mv {file}.part {file}")

    def _parallel(self, missing):
        machines = self.machines
        if not shutil.which("parallel"):
            raise Unusable("no program parallel: expected Debian's package of GNU parallel, as scripts/setup installs")
        command = ["setpriv", "--pdeathsig", "TERM", "parallel", "--will-cite", "--plain", "--colsep", "\t",
                   "--tagstring", "{1}", "--line-buffer", "--joblog", "runs/joblog", "--halt", "never", "--arg-file",
                   "runs/batch"]
        if not machines.sshlogin:
            return machines.program, [*command, "--jobs", str(machines.jobs or os.cpu_count()), "eval {2}"]
        command += ["--jobs", str(machines.jobs or "100%"), "--sshlogin", machines.sshlogin, "--workdir", ".",
                    "--retries", "2"]
        if machines.ssh:
            command += ["--ssh", machines.ssh]
        for file in sorted({file for _, files in missing.values() for file in files}):
            command += ["--basefile", file]
        return machines.remote_program or machines.program, [*command, "eval {2}"]

    def _run(self, what, missing, alone):
        """Runs and keeps them; returns those that crashed. What could not start says nothing of a candidate."""
        ended, complaints = {}, {}
        if alone or (len(missing) == 1 and not self.machines.sshlogin):
            self._run_here(what, missing, ended, complaints)
        else:
            self._run_parallel(what, missing, ended, complaints)
        self.progress.clear()
        crashed, never_ran = {}, []
        for key in missing:
            status, text = ended.get(key, (None, ""))
            how = f"left no status: see {self.kept / 'joblog'}" if status is None else f"ended with status {status}"
            line = (complaints.get(key) or complaints.get("") or [f"fit_run {how}"])[-1]
            if status == REFUSED:
                write_whole(self.kept / f"{key}.json", json.dumps({"refused": line.removeprefix("fit_run: ")}))
            elif status in NEVER_RAN:
                never_ran.append(line.removeprefix("fit_run: "))
            elif status != 0 or not text:
                crashed[key] = {"crashed": line}
        if never_ran:
            raise Unusable(never_ran[0])
        return crashed

    def _keep(self, key, status, text, ended):
        ended[key] = status, text
        if status == 0 and text:
            write_whole(self.kept / f"{key}.json", text + "\n")

    def _run_here(self, what, missing, ended, complaints):
        """One after the other."""
        for number, (key, (arguments, _)) in enumerate(missing.items()):
            self.progress.show(what, number, len(missing))
            done = subprocess.run([self.machines.program, *arguments], cwd=self.folder, capture_output=True, text=True,
                                  check=False)
            complaints[key] = done.stderr.strip().splitlines()
            self._keep(key, done.returncode, done.stdout.strip(), ended)

    def _run_parallel(self, what, missing, ended, complaints):
        program, command = self._parallel(missing)
        lines = [f"{key}\t{self._command(program, arguments)}; echo \"status $?\"\n"
                 for key, (arguments, _) in missing.items()]
        write_whole(self.kept / "batch", "".join(lines))
        # A session of its own: Ctrl-C is for us to pass on. The lines are for sh, whatever shell a user has or lacks.
        process = subprocess.Popen(command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, start_new_session=True,
                                   env={**os.environ, "PARALLEL_SHELL": "/bin/sh"})
        reader = threading.Thread(target=self._read_complaints, args=(process.stderr, complaints), daemon=True)
        reader.start()
        try:
            self._collect(what, process.stdout, len(missing), ended)
            process.wait()
        finally:
            self._stop(process)
            reader.join(1.0)
            process.stdout.close()
            process.stderr.close()

    def _collect(self, what, stream, total, ended):
        texts = {}
        self.progress.show(what, 0, total)
        for line in stream:
            key, _, text = line.rstrip("\n").partition("\t")
            if not text.startswith("status "):
                texts[key] = text
                continue
            self._keep(key, int(text.split()[1]), texts.get(key, ""), ended)
            self.progress.show(what, len(ended), total)

    @staticmethod
    def _read_complaints(stream, complaints):
        for line in stream:
            key, tab, text = line.rstrip("\n").partition("\t")
            if not tab:
                key, text = "", key
            if text.strip():
                complaints.setdefault(key, []).append(text)

    @staticmethod
    def _stop(process):
        """Told twice, parallel ends its runs too."""
        while process.poll() is None:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(0.2)
            except subprocess.TimeoutExpired:
                continue
