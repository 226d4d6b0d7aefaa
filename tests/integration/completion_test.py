#!/usr/bin/python3
"""What bash completes: a program's own options, and no other's that its --help speaks of."""
import os
import re
import subprocess
import unittest

import daemons

# Of the package bash-completion, what an option's completion asks for; scripts/package --test has the whole.
STUB = """_init_completion() {
  words=("${COMP_WORDS[@]}") cword=$COMP_CWORD cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]}
}
_filedir() { :; }
"""
PROGRAMS = ("sim_server", "haptic_server", "segment_inspect", "scene_viewer", "device_check", "sphere_decompose",
            "replay_check", "scene_fit", "stiffness_fit", "stillgrid_import")
PATH = f"{daemons.BUILD / 'bin'}:{daemons.ROOT / 'scripts'}:{os.environ['PATH']}"


class CompletionTest(unittest.TestCase):
    def completed(self, *words):
        script = (f'{STUB}. {daemons.ROOT}/scripts/system/completion.bash; COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); '
                  '_stillgrid; printf "%s\\n" "${COMPREPLY[@]}"')
        run = subprocess.run(["bash", "-c", script, "bash", *words], capture_output=True, text=True, timeout=60,
                             env=dict(os.environ, PATH=PATH))
        return set(run.stdout.split())

    def test_options_are_those_that_the_program_takes(self):
        for program in PROGRAMS:
            options = self.completed(program, "--")
            self.assertIn("--help", options, program)
            for option in options:
                # An option that is not the program's is refused as such, whatever else is wrong.
                run = subprocess.run([program, option], capture_output=True, text=True, timeout=60,
                                     stdin=subprocess.DEVNULL, env=dict(os.environ, PATH=PATH))
                self.assertNotRegex(run.stderr, rf"(unrecognized arguments|not expected|unknown option)[^\n]*{option}\b",
                                    program)

    def test_no_option_that_only_prose_names_is_offered(self):
        for program in ("scene_fit", "stillgrid_import"):
            text = subprocess.run([program, "--help"], capture_output=True, text=True, check=True,
                                  env=dict(os.environ, PATH=PATH)).stdout
            self.assertIn("--record", re.findall(r"--[a-z-]+", text))  # of haptic_server
            self.assertEqual(self.completed(program, "--rec"), set())


if __name__ == "__main__":
    daemons.main()
