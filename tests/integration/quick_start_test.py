#!/usr/bin/python3
"""From nothing to the demo: scripts/setup, scripts/build and scripts/demo, with tools of ours in apt's, cmake's and
cyclictest's place."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import daemons

SETS = ("demo", "view", "test", "all")
# Says what is in the file "installed"; apt-get puts there what it is asked for, and writes down how it was called.
TOOLS = {
    "dpkg-query": 'for package; do grep -qx "$package" "$TOOLS/installed" && echo "installed $package"; done; true',
    "apt-get": '''echo "$@" >>"$TOOLS/called"
case "$*" in
  *--assume-no*) printf '%s\\n' '0 upgraded, 2 newly installed, 0 to remove and 6 not upgraded.' \\
    'Need to get 66.3 MB of archives.' 'After this operation, 267 MB of additional disk space will be used.'; exit 1 ;;
  install*) if [ -e "$TOOLS/fails" ]; then cat "$TOOLS/fails" >&2; exit 100; fi
    printf '%s\\n' 'dlstatus:1:20.4:Retrieving file 1 of 2 (2s remaining)' \\
      'pmstatus:g++:43.2:Unpacking g++ (amd64)'; printf '%s\\n' "$@" >>"$TOOLS/installed" ;;
esac''',
    "cmake": '''echo "$@" >>"$TOOLS/called"
case "$*" in --build*) cat "$TOOLS/built"; [ ! -e "$TOOLS/fails" ] ;; esac''',
}


class TreeTest(unittest.TestCase):
    """A tree with our scripts, and the tools above before all others."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-"))
        self.addCleanup(shutil.rmtree, self.root)
        self.root.chmod(0o755)
        shutil.copytree(daemons.ROOT / "scripts", self.root / "scripts",
                        ignore=shutil.ignore_patterns("__pycache__"))
        self.tools = self.root / "tools"
        self.tools.mkdir()
        for name, text in TOOLS.items():
            self.write(self.tools / name, f"#!/bin/bash\n{text}\n")
        for name in ("installed", "called", "built"):
            self.write(self.tools / name, "")
        self.environment = dict(os.environ, TOOLS=str(self.tools), STILLGRID_PROGRESS_S="0",
                                PATH=f"{self.tools}:{os.environ['PATH']}", TMPDIR=str(self.root))

    @staticmethod
    def write(file, text):
        file.write_text(text)
        file.chmod(0o755)

    def run_script(self, *command, before=(), **environment):
        return subprocess.run([*before, *map(str, command)], cwd=self.root, capture_output=True, text=True, check=False,
                              env={**self.environment, **environment}, timeout=60 * daemons.PATIENCE)

    def setup(self, *arguments, **more):
        return self.run_script(self.root / "scripts/setup", *arguments, **more)

    def called(self):
        return (self.tools / "called").read_text()

    def assert_one_line(self, run, status, pattern):
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        self.assertRegex(run.stderr, rf"\A{pattern}\n\Z")


class SetupTest(TreeTest):
    def packages(self, name):
        run = self.setup(f"--{name}", "--list")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return run.stdout.split()

    def test_each_set_holds_the_one_before_and_the_demos_holds_nothing_large(self):
        sets = [self.packages(name) for name in SETS]
        for smaller, larger in zip(sets, sets[1:]):
            self.assertLess(set(smaller), set(larger))
        self.assertEqual(self.called(), "")
        self.assertFalse(set(sets[0]) & {"chromium", "doxygen", "libsundials-dev", "nodejs", "npm",
                                         "python3-matplotlib", "clang", "cyclonedds-dev", "catch2"}, sets[0])
        self.assertEqual(self.setup("--list").stdout.split(), sets[-1], "the default is --all")

    def test_what_is_there_is_not_installed_again_and_costs_no_word(self):
        (self.tools / "installed").write_text("\n".join(self.packages("demo")))
        run = self.setup("--demo")
        self.assertEqual((run.returncode, run.stdout, run.stderr, self.called()), (0, "", "", ""))

    @unittest.skipIf(os.geteuid() != 0, "skipped: needs root, in whose place sudo would be asked")
    def test_what_is_missing_is_installed_with_how_much_it_is_and_how_far(self):
        packages = self.packages("demo")
        (self.tools / "installed").write_text("\n".join(packages[2:]))
        run = self.setup("--demo")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(run.stdout,
                         "setup: installing for --demo: 2 packages, 66.3 MB to fetch, 267 MB on disk\n")
        self.assertIn("setup: fetching, 20 %\nsetup: installing, 43 %: Unpacking g++\n", run.stderr)
        self.assertTrue(self.called().endswith(" ".join(packages[:2]) + "\n"), self.called())
        self.assertEqual(list(self.root.glob("stillgrid-setup-*")), [], "the log stays only where it is needed")

    @unittest.skipIf(os.geteuid() != 0, "skipped: needs root, in whose place sudo would be asked")
    def test_a_failure_of_apt_is_one_line_with_its_cause(self):
        (self.tools / "fails").write_text(
            "W: Failed to fetch http://deb.debian.org/x  Temporary failure resolving 'deb.debian.org'\n"
            "E: Unable to fetch some archives\n")
        run = self.setup("--demo")
        self.assertEqual(run.returncode, 2)
        self.assertRegex(run.stderr.splitlines()[-1],
                         r"^setup: apt-get install: Failed to fetch .*resolving 'deb\.debian\.org'.*; log: \S+$")

    def test_without_root_and_sudo_a_line_says_what_root_would_do(self):
        for name in ("bash", "env", "id", "dirname", "grep"):
            (self.tools / name).symlink_to(shutil.which(name))
        before = ("/usr/bin/setpriv", "--reuid", "65534", "--clear-groups") if os.geteuid() == 0 else ()
        self.assert_one_line(self.setup("--demo", before=before, PATH=str(self.tools)), 2,
                             r"setup: needs root, and there is no sudo: expected as root: apt-get install .*g\+\+ .*")

    def test_where_there_is_no_apt_a_line_names_the_system_that_is_expected(self):
        (self.tools / "apt-get").unlink()
        for name in ("bash", "dirname"):
            (self.tools / name).symlink_to(shutil.which(name))
        self.assert_one_line(self.setup("--demo", PATH=str(self.tools)), 2,
                             r"setup: no apt-get: expected Debian 12 or 13, or Ubuntu 24\.04; .*g\+\+ .*")


class BuildTest(TreeTest):
    def setUp(self):
        super().setUp()
        self.write(self.root / "scripts/setup", '#!/bin/bash\necho "setup $@" >>"$TOOLS/called"\n')

    def build(self, *arguments, **more):
        return self.run_script(self.root / "scripts/build", *arguments, **more)

    def test_steps_done_are_told_while_it_builds_and_nothing_where_nothing_is_to_do(self):
        (self.tools / "built").write_text("[1/3] Building a\n[2/3] Building b\n[3/3] Linking c\n")
        run = self.build("demo")
        self.assertEqual((run.returncode, run.stdout), (0, "build: demo\n"), run.stderr)
        self.assertEqual(run.stderr, "".join(f"build: demo: {i} of 3 steps\n" for i in (1, 2, 3)))
        self.assertIn("[2/3] Building b\n", (self.root / "build/release/build.log").read_text())
        (self.tools / "built").write_text("ninja: no work to do.\n")
        self.assertEqual(self.build("demo").stderr, "")

    def test_the_time_left_is_what_the_rest_takes_at_the_pace_so_far(self):
        script = '. scripts/terminal/progress.sh; SECONDS=30; time_left 20 60 0; time_left 0 60 0; time_left 1 60 28'
        self.assertEqual(self.run_script("bash", "-c", script).stdout, ", about 1:00 min left")

    def test_each_preset_asks_for_the_packages_that_it_needs(self):
        for preset, packages in (("demo", "--demo"), ("demo_view", "--view"), ("release", "--test"), ("dev", "--test"),
                                 ("aarch64", "--test aarch64"), ("asan", "--all"), ("tidy", "--all")):
            self.write(self.tools / "called", "")
            self.assertEqual(self.build(preset).returncode, 0)
            self.assertEqual(self.called().splitlines()[0], f"setup {packages}")

    def test_a_part_leaves_a_folder_that_holds_more_as_it_is(self):
        (self.root / "build/release").mkdir(parents=True)
        for cache, preset in (("", "demo"), ("STILLGRID_PAGE:BOOL=ON\n", "demo_view"),
                              ("BUILD_TESTING:BOOL=ON\nSTILLGRID_PAGE:BOOL=ON\n", "release")):
            (self.root / "build/release/CMakeCache.txt").write_text(cache)
            self.write(self.tools / "called", "")
            self.build("demo")
            self.assertEqual(self.called().splitlines()[1], f"--preset {preset}")
            self.assertTrue(self.called().endswith(" --target demo\n"), self.called())

    def test_a_build_that_fails_shows_the_error_and_not_what_went_well(self):
        (self.tools / "built").write_text("[1/2] Building a\nFAILED: b.o\nb.cpp:1: error: no\n")
        (self.tools / "fails").touch()
        run = self.build("release")
        self.assertEqual(run.returncode, 2)
        self.assertTrue(run.stderr.endswith("FAILED: b.o\nb.cpp:1: error: no\n"
                                            "build: release failed, log: build/release/build.log\n"), run.stderr)

    def test_a_full_disk_and_a_tree_of_another_are_one_line_each(self):
        (self.tools / "built").write_text("FAILED: b.o\nb.s: fatal error: No space left on device\n")
        (self.tools / "fails").touch()
        self.assert_one_line(self.build("release"), 2, "build: .*build/release: the disk is full")
        shutil.rmtree(self.root / "build")
        (self.tools / "called").chmod(0o666)
        before = ("setpriv", "--reuid", "65534", "--clear-groups") if os.geteuid() == 0 else ()
        self.root.chmod(0o555)
        self.addCleanup(self.root.chmod, 0o755)
        self.assert_one_line(self.build("release", before=before), 2,
                             "build: .*build/release: cannot write there: expected a tree .*: git clone .*")


class PackageTest(TreeTest):
    def setUp(self):
        super().setUp()
        (self.root / "VERSION").write_text("1.2.3\n")
        page = self.root / "shared/tools/scene_viewer/page"
        page.mkdir(parents=True)
        for name in ("package.json", "package-lock.json"):
            (page / name).write_text("{}")
        self.write(self.root / "scripts/setup", "#!/bin/bash\n")
        for name, text in (("git", "true"), ("npm", "mkdir -p node_modules/three"),
                           ("dpkg-parsechangelog", "echo 1.2.3-1")):
            self.write(self.tools / name, f"#!/bin/bash\n{text}\n")

    def test_a_step_that_fails_is_told_whichever_it_is(self):
        for tool, words in (("npm", "npm could not fetch what .*package-lock.json names"),
                            ("tar", "could not be built, log: .*build.log"), ("rm", ".*build/package/npm: could not be made")):
            self.write(self.tools / tool, "#!/bin/bash\nexit 1\n")
            run = self.run_script(self.root / "scripts/package")
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertRegex(run.stderr.splitlines()[-1], f"^package: {words}$")
            (self.tools / tool).unlink()
            if tool == "npm":
                self.write(self.tools / tool, "#!/bin/bash\nmkdir -p node_modules/three\n")


class PartsTest(unittest.TestCase):
    """CMake itself, in the place of packages that are missing what it calls disabled."""
    ABSENT = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON"
              for name in ("benchmark", "Catch2", "CycloneDDS", "fastrtps", "PkgConfig", "SUNDIALS")]

    def configure(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            return subprocess.run(["cmake", "--preset", "demo", "-B", folder, *self.ABSENT, *arguments],
                                  cwd=daemons.ROOT, capture_output=True, text=True, check=False)

    def test_the_demo_is_configured_without_the_packages_of_other_parts(self):
        run = self.configure()
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_a_part_that_is_wanted_and_cannot_be_built_is_an_error_that_names_its_package(self):
        run = self.configure("-DSTILLGRID_RELAY=ON")
        self.assertNotEqual(run.returncode, 0)
        self.assertRegex(run.stderr, r"STILLGRID_RELAY=ON: expected Debian's\s+cyclonedds-dev: run scripts/setup")


class DemoTest(TreeTest):
    def setUp(self):
        super().setUp()
        self.write(self.root / "scripts/build", "#!/bin/sh\n")
        self.write(self.tools / "cyclictest", "#!/bin/sh\nexit 1\n")
        (self.root / "build").mkdir()
        (self.root / "build/release").symlink_to(daemons.BUILD)
        for folder in ("sim_server", "shared"):
            (self.root / folder).symlink_to(daemons.ROOT / folder)

    def test_a_folder_where_the_link_to_the_last_run_would_be_stays(self):
        (self.root / "build/demo/latest").mkdir(parents=True)
        demo = subprocess.run([self.root / "scripts/demo", "--seconds", "1"], env=self.environment, text=True,
                              capture_output=True, timeout=60 * daemons.PATIENCE)
        self.assertEqual(demo.returncode, 0, demo.stdout + demo.stderr)
        self.assertIn("build/demo/latest is no link of a run before: it stays as it is", demo.stdout)
        self.assertTrue((self.root / "build/demo/1/force.png").exists())

    def test_two_demos_at_once_write_two_folders(self):
        both = [subprocess.Popen([self.root / "scripts/demo", "--seconds", "1"], env=self.environment, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT) for _ in range(2)]
        texts = [demo.communicate(timeout=60 * daemons.PATIENCE)[0] for demo in both]
        self.assertEqual([demo.returncode for demo in both], [0, 0], "\n".join(texts))
        pictures = {re.search(r"^picture: (build/demo/\d+/force\.png)$", text, re.MULTILINE)[1] for text in texts}
        self.assertEqual(pictures, {f"build/demo/{number}/force.png" for number in (1, 2)})
        for picture in pictures:
            self.assertEqual((self.root / picture).read_bytes()[:4], b"\x89PNG")
            rows = daemons.recording.load((self.root / picture).with_name("recording.csv"))
            self.assertGreater(len(rows), 900)
        self.assertIn(os.readlink(self.root / "build/demo/latest"), ("1", "2"))


if __name__ == "__main__":
    daemons.main()
