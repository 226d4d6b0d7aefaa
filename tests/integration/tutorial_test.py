#!/usr/bin/python3
"""The commands of docs/tutorial.md do what the page says, in its order."""
import os
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

import daemons

PAGE = daemons.ROOT / "docs/tutorial.md"
BLOCK = re.compile(r"^```(\S[^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks():
    """(what stands behind the fence, text) of each block that has something there."""
    return BLOCK.findall(PAGE.read_text())


class TutorialTest(unittest.TestCase):
    def run_line(self, line, folder):
        """A command of the page, its scripts from this tree and its programs from the build under test."""
        words = shlex.split(line)
        if words[0].startswith("scripts/"):
            script = daemons.ROOT / words[0]
            build = ["--build", str(daemons.BUILD)] if script.name in ("launch", "replay_check") else []
            line = shlex.join([str(script), *words[1:], *build])
        environment = dict(os.environ, PYTHONDONTWRITEBYTECODE="1")
        return subprocess.run(["bash", "-c", line], cwd=folder, env=environment, text=True, timeout=300,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def test_every_command_of_the_tutorial_does_what_the_page_says(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "build/mine").mkdir(parents=True)
            (folder / "build/release").symlink_to(daemons.BUILD)
            (folder / "sim_server").symlink_to(daemons.ROOT / "sim_server")
            printed = []
            for kind, text in blocks():
                if kind.startswith("toml "):
                    (folder / kind.split()[1]).write_text(text)
                    continue
                lines = text.replace("\\\n", " ").splitlines()
                for i, line in enumerate(lines):
                    done = self.run_line(line, folder)
                    printed.append(done.stdout)
                    fails = kind == "sh fails" and i == len(lines) - 1
                    self.assertEqual(done.returncode, 1 if fails else 0, f"{line}\n{done.stdout}")
            self.assertIn("equal: byte for byte", "".join(printed))
            self.assertRegex("".join(printed), r"wrong\.toml:\d+:\d+: .*radius")
            for made in ("first.csv", "first.mcap", "hand.csv", "hand.png", "expected.csv", "organ.csv", "organ.json"):
                self.assertGreater((folder / "build/mine" / made).stat().st_size, 0, made)


if __name__ == "__main__":
    daemons.main()
