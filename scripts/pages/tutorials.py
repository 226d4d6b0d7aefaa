"""The tutorials' pages as what they are: files to write and commands to give, in their order.

A fence "```LANGUAGE FILE" is a file, or what is appended to one that a fence before began. "```sh" holds commands;
of "```sh fails N" the last ends with status N, or 1. Other fences are for the reader alone.
"""
import os
import pathlib
import re
import shlex
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs/tutorials"
BLOCK = re.compile(r"^```(\S[^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PICTURE = re.compile(r"!\[[^\]]*\]\(\.\./charts/tutorial_(\w+)\.png\)")
OF_A_BUILD = ("launch", "replay_check", "scene_fit")  # scripts that take --build
GIVEN = "first_scene"  # its scenes are there on the other pages


def names():
    return sorted(page.stem for page in FOLDER.glob("*.md"))


def text_of(name):
    return (FOLDER / f"{name}.md").read_text(encoding="utf-8")


def blocks(name):
    """(what stands behind the fence, text) of each block that has something there."""
    return BLOCK.findall(text_of(name))


def files(name):
    """{file: text} of a page's files."""
    written = {}
    for kind, text in blocks(name):
        words = kind.split()
        if words[0] != "sh" and len(words) == 2:
            written[words[1]] = f"{written[words[1]]}\n{text}" if words[1] in written else text
    return written


def pictures(name):
    """Of tutorial_NAME.png on the page: each NAME. The page's commands draw a NAME.png."""
    return PICTURE.findall(text_of(name))


def script_of(name, session):
    """The page's commands as a script that says each, and ends at the first that does otherwise than the page says.
    A session named try is called session, for others may try the page at the same time."""
    yield "set -euo pipefail"
    for kind, text in blocks(name):
        words = kind.split()
        if words[0] != "sh":
            continue
        lines = re.sub(r"\btry\b", session, text.replace("\\\n", " ")).splitlines()
        for i, line in enumerate(lines):
            yield f"printf '$ %s\\n' {shlex.quote(line)}"
            if "fails" in words and i == len(lines) - 1:
                status = words[2] if len(words) > 2 else "1"
                yield f"status=0; {line} || status=$?"
                yield f"[ $status = {status} ] || {{ echo \"exit status $status: expected {status}\"; exit 1; }}"
            else:
                yield line


def run(name, folder, build, limit_s=300):
    """Gives a page's commands in a folder that stands for the tree, what ran in real time in virtual time. Returns
    exit status and what was printed."""
    folder, build = pathlib.Path(folder), pathlib.Path(build).resolve()
    (folder / "build/mine").mkdir(parents=True)
    (folder / "build/release").symlink_to(build)
    (folder / "sim_server").symlink_to(ROOT / "sim_server")
    (folder / "scripts").mkdir()
    for script in (ROOT / "scripts").iterdir():
        stand_in = folder / "scripts" / script.name
        if script.name in OF_A_BUILD:
            virtual_time = " --lockstep" if script.name == "launch" else ""
            stand_in.write_text(f"#!/bin/sh\nexec {shlex.quote(str(script))} \"$@\" --build "
                                f"{shlex.quote(str(build))}{virtual_time}\n")
            stand_in.chmod(0o755)
        else:
            stand_in.symlink_to(script)
    for file, text in {**files(GIVEN), **files(name)}.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text)
    script = "\n".join(script_of(name, f"try-{os.getpid()}"))
    done = subprocess.run(["bash", "-c", script], cwd=folder, text=True, timeout=limit_s,
                          env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"), stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False)
    return done.returncode, done.stdout


def picture_of(folder, name):
    """The file NAME.png that a page's commands have drawn in folder."""
    found = sorted((pathlib.Path(folder) / "build/mine").rglob(f"{name}.png"))
    if len(found) != 1:
        raise ValueError(f"build/mine: expected one {name}.png, there are {len(found)}")
    return found[0]
