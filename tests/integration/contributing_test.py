#!/usr/bin/python3
"""What a contributor has before CI: commit hook, clang-tidy on what changed, editor's settings, pages that lead on."""
import configparser
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import daemons
from faults.catalogue import FAULTS

CLEAN = '#include "shared/sum.hpp"\n\nnamespace stillgrid::shared {\nint sum(int a, int b) { return a + b; }\n}  // namespace stillgrid::shared\n'
HEADER = "#pragma once\n\nnamespace stillgrid::shared {\nint sum(int a, int b);\n}  // namespace stillgrid::shared\n"
NULL = "namespace stillgrid::shared {\nint* none() { return 0; }\n}  // namespace stillgrid::shared\n"  # modernize-use-nullptr


class RepositoryTest(unittest.TestCase):
    """A repository with our scripts and two clean files."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-"))
        self.addCleanup(shutil.rmtree, self.root)
        for name in ("setup", "check_format", "check_layers", "tidy", "hooks/pre-commit"):
            (self.root / "scripts" / name).parent.mkdir(exist_ok=True)
            shutil.copy(daemons.ROOT / "scripts" / name, self.root / "scripts" / name)
        for name in (".clang-format", ".clang-tidy"):
            shutil.copy(daemons.ROOT / name, self.root)
        self.plant("proto/unit.hpp", "#pragma once\n")
        self.plant("shared/sum.hpp", HEADER)
        self.plant("shared/sum.cpp", CLEAN)
        for folder in ("sim_server", "haptic_server", "tests"):
            self.plant(f"{folder}/CMakeLists.txt", "")
        self.run_here("git", "init", "-q")
        self.stage_all()
        self.assertEqual(self.commit()[0], 0)

    def plant(self, file, text, is_program=False):
        path = self.root / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755 if is_program else 0o644)

    def run_here(self, *command, **more):
        """Exit status and all that was printed, outside any other repository."""
        names = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
        result = subprocess.run(command, cwd=self.root, capture_output=True, text=True, check=False,
                                timeout=60 * daemons.PATIENCE,
                                env={**names, "GIT_CONFIG_GLOBAL": os.devnull, **more})
        return result.returncode, result.stdout + result.stderr

    def stage_all(self):
        self.run_here("git", "add", "--all")

    def commit(self):
        return self.run_here("git", "-c", "user.name=a", "-c", "user.email=a@b", "commit", "-m", "one more")


class VersionTest(unittest.TestCase):
    def test_a_script_that_finds_no_file_of_the_version_says_so_in_one_line_and_fails(self):
        with tempfile.TemporaryDirectory(prefix="stillgrid-test-") as root:
            shutil.copytree(daemons.ROOT / "scripts", pathlib.Path(root) / "scripts")
            for script in ("replay_check", "scene_fit", "launch"):
                with self.subTest(script):
                    run = subprocess.run([pathlib.Path(root) / "scripts" / script, "--version"], capture_output=True,
                                         text=True, check=False)
                    self.assertNotEqual(run.returncode, 0)
                    self.assertEqual(run.stdout, "")
                    self.assertRegex(run.stderr, f"\\A{script}: .*VERSION.*\n\\Z")


class UdevTest(unittest.TestCase):
    SETUP = daemons.ROOT / "scripts" / "setup"

    def run_setup(self, *before):
        return subprocess.run([*before, self.SETUP, "--udev"], capture_output=True, text=True, check=False)

    def test_who_is_not_root_gets_one_line(self):
        if os.geteuid() == 0:  # another user may not be allowed to enter the clone
            folder = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-", dir="/tmp"))
            self.addCleanup(shutil.rmtree, folder)
            folder.chmod(0o755)
            run = subprocess.run([*daemons.NOBODY, shutil.copy(self.SETUP, folder), "--udev"], capture_output=True,
                                 text=True, check=False)
        else:
            run = self.run_setup()
        self.assertEqual((run.returncode, run.stdout), (2, ""))
        self.assertEqual(run.stderr, "setup: --udev: needs root: sudo scripts/setup --udev\n")

    def test_root_has_the_rules_in_place_and_udev_reads_them(self):
        """With an empty /etc of its own, and a udevadm that only writes down how it was called."""
        folder = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-"))
        self.addCleanup(shutil.rmtree, folder)
        alone = ("unshare", "--map-root-user", "--mount", "sh", "-ec",
                 f'mount -t tmpfs none /etc; PATH={folder}:$PATH; "$@"; cat /etc/udev/rules.d/*', "sh")
        if subprocess.run([*alone[:4], "-c", "mount -t tmpfs none /etc"], capture_output=True, check=False).returncode:
            self.skipTest("skipped: no namespace of its own")
        for status, line in ((0, "rules\n"), (1, "rules, for when udev runs: it does not here\n")):
            called = folder / f"called-{status}"
            (folder / "udevadm").write_text(f'#!/bin/sh\necho "$@" >> {called}\nexit {status}\n')
            (folder / "udevadm").chmod(0o755)
            run = self.run_setup(*alone)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            rules = (self.SETUP.parent / "udev/60-stillgrid.rules").read_text()
            self.assertEqual(run.stdout, "setup: /etc/udev/rules.d/60-stillgrid." + line + rules)
            self.assertEqual(called.read_text(), "control --reload\n" + ("" if status else "trigger\n"))


@unittest.skipUnless(shutil.which("clang-format-14"), "skipped: clang-format-14 is not installed, see scripts/setup")
class CommitHookTest(RepositoryTest):
    def setUp(self):
        super().setUp()
        self.assertEqual(self.run_here("scripts/setup", "--hooks"), (0, ""))

    def assert_refused(self, *words):
        self.stage_all()
        status, text = self.commit()
        self.assertEqual(status, 1, text)
        for word in words:
            self.assertIn(word, text)

    def test_what_is_clean_is_committed(self):
        self.plant("shared/more.hpp", HEADER)
        self.stage_all()
        status, text = self.commit()
        self.assertEqual(status, 0, text)

    def test_bad_format_a_wrong_layer_and_a_wrong_word_are_refused_by_name(self):
        self.plant("shared/more.hpp", "#pragma once\nint  x ;\n")
        self.assert_refused("shared/more.hpp:2:", "check_format")
        self.plant("shared/more.hpp", '#pragma once\n#include "sim_server/a.hpp"\n')
        self.assert_refused("shared/more.hpp:2:", "check_layers")
        self.plant("shared/more.hpp", HEADER)
        self.plant("scripts/check_words", '#!/bin/sh\n! grep -rn slope "$1/shared"\n', is_program=True)
        self.plant("shared/words.hpp", "#pragma once  // slope\n")
        self.assert_refused("shared/words.hpp:1:", "check_words")

    def test_what_is_staged_counts_and_not_what_the_folder_holds(self):
        self.plant("shared/more.hpp", "#pragma once\nint  x ;\n")
        self.stage_all()
        self.plant("shared/more.hpp", HEADER)
        self.assertEqual(self.commit()[0], 1)
        self.stage_all()
        self.plant("shared/more.hpp", "#pragma once\nint  x ;\n")
        status, text = self.commit()
        self.assertEqual(status, 0, text)


@unittest.skipUnless(shutil.which("clang-tidy"), "skipped: clang-tidy is not installed, see scripts/setup")
class TidyTest(RepositoryTest):
    def setUp(self):
        super().setUp()
        self.plant("shared/null.cpp", NULL)
        commands = [{"directory": str(self.root), "file": f"shared/{name}.cpp",
                     "command": f"clang++ -std=c++20 -I. -c shared/{name}.cpp"} for name in ("sum", "null", "later")]
        self.plant("build/compile_commands.json", json.dumps(commands))
        self.plant(".gitignore", "/build/\n")

    def tidy(self, *arguments, **more):
        return self.run_here("scripts/tidy", "--build", "build", *arguments, **more)

    def test_a_changed_source_and_one_that_is_not_committed_are_looked_at_and_no_others(self):
        status, text = self.tidy("--changed", "HEAD")
        self.assertEqual(status, 1, text)
        self.assertIn("modernize-use-nullptr", text)
        self.assertTrue(text.endswith("0 passed, 1 failed\n"), text)
        self.stage_all()
        self.commit()
        self.plant("shared/sum.cpp", CLEAN.replace("a + b", "b + a"))
        self.assertEqual(self.tidy("--changed", "HEAD"), (0, "shared/sum.cpp: passed\n1 passed, 0 failed\n"))

    def test_a_changed_header_is_looked_at_from_the_source_of_its_name(self):
        (self.root / "shared" / "null.cpp").unlink()
        self.plant("shared/sum.hpp", HEADER.replace("sum(int a", "sum(int first"))
        status, text = self.tidy("--changed", "HEAD")
        self.assertEqual(status, 1, text)
        self.assertIn("readability-inconsistent-declaration-parameter-name", text)

    def test_what_the_time_is_too_short_for_is_named(self):
        self.assertEqual(self.tidy("--changed", "HEAD", STILLGRID_TIDY_S="0"),
                         (0, "shared/null.cpp: left out for want of time\n0 passed, 0 failed, 1 skipped\n"))

    def test_a_base_that_does_not_exist_is_refused(self):
        status, text = self.tidy("--changed", "nowhere")
        self.assertEqual((status, text.count("\n")), (2, 1), text)
        self.assertIn("nowhere", text)


class PagesTest(unittest.TestCase):
    def test_every_file_that_the_pages_for_contributors_name_is_there(self):
        missing = []
        for page in ("CONTRIBUTING.md", "SECURITY.md", "CODE_OF_CONDUCT.md"):  # the changelog names files of the past
            text = (daemons.ROOT / page).read_text()
            named = re.findall(r"\]\((?!http)([^)#]+)", text)
            named += re.findall(r"`((?:\.ci|\.github|proto|shared|sim_server|haptic_server|tests|scripts|docs)/[\w./-]+)", text)
            missing += [f"{page}: {name}" for name in named if not (daemons.ROOT / name).exists()
                        and "NAME" not in name]
        self.assertEqual(missing, [])

    def test_what_the_pages_count_is_as_many_in_the_tree(self):
        def text_of(page):
            return " ".join((daemons.ROOT / page).read_text().split())

        def rows(file, pattern):
            return len(re.findall(pattern, (daemons.ROOT / file).read_text(), re.MULTILINE))
        numbers = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
        stages = numbers[rows("docs/safety.md", r"^\| \d+ \| ")]
        transitions = numbers[rows("shared/display/transition.cpp", r"^    TransitionLaw\{")]
        rivals = numbers[rows("tests/laboratory/rivals/rivals.cpp", r'^    \{"\w+", ')]
        for page, sentence in (
                ("README.md", f"{stages} stages between every force and the hand, tried with {len(FAULTS)} injected faults"),
                ("README.md", f"{transitions} ways to pass from one snapshot to the next"),
                ("README.md", f"{rivals} rival models"),
                ("docs/README.md", f"{len(FAULTS)} injected faults"), ("docs/README.md", f"{rivals} rivals"),
                ("docs/safety.md", f"injects {len(FAULTS)} faults"),
                ("docs/algorithms/snapshot_renderer.md", f"All {transitions} transitions"),
                ("docs/architecture.md", f"{rivals} [models of others]")):
            self.assertIn(sentence, text_of(page), page)
        faults = rows("docs/safety.md", r"^\| \w* ?\| .+ \|.*\| (?:[\d.]+ N|exit \d+|SIG[A-Z]+) \|$")
        self.assertEqual(faults, len(FAULTS), "rows of the table of faults in docs/safety.md")

    def test_the_page_of_the_protocol_is_of_the_version_that_segments_have(self):
        header = (daemons.ROOT / "proto/segment_header.hpp").read_text()
        version = re.search(r"kSegmentVersion = (\d+);", header)[1]
        self.assertIn(f"This is version {version} (`kSegmentVersion`, `proto/segment_header.hpp`)",
                      (daemons.ROOT / "docs/protocol.md").read_text())

    def test_the_changelog_is_of_the_form_that_it_names(self):
        text = (daemons.ROOT / "CHANGELOG.md").read_text()
        releases = re.findall(r"^## (.*)$", text, re.MULTILINE)
        self.assertEqual(releases[0], "[Unreleased]")
        for release in releases[1:]:
            self.assertRegex(release, r"^\[\d+\.\d+\.\d+\] - \d{4}-\d\d-\d\d$")
        sections = set(re.findall(r"^### (.*)$", text, re.MULTILINE))
        self.assertLessEqual(sections, {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"})
        self.assertRegex((daemons.ROOT / "VERSION").read_text(), r"^\d+\.\d+\.\d+\n$")


@unittest.skipUnless(shutil.which("clang-format-14"), "skipped: clang-format-14 is not installed, see scripts/setup")
class EditorConfigTest(unittest.TestCase):
    def test_editors_and_clang_format_agree_on_widths(self):
        editor = configparser.ConfigParser(inline_comment_prefixes="#")
        editor.read_string("[preamble]\n" + (daemons.ROOT / ".editorconfig").read_text())
        style = subprocess.run(["clang-format-14", "--dump-config", "--style=file"], cwd=daemons.ROOT,
                               capture_output=True, text=True, check=True).stdout
        of_cpp = {**editor["*"], **editor["*.{c,h,cpp,hpp}"]}
        for key, name in (("max_line_length", "ColumnLimit"), ("indent_size", "IndentWidth")):
            self.assertEqual(of_cpp[key], re.search(rf"^{name}: +(\d+)$", style, re.MULTILINE)[1])


if __name__ == "__main__":
    daemons.main()
