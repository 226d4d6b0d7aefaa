#!/usr/bin/python3
"""THIRD_PARTY_NOTICES.md lists what the programs contain, link and serve, and nothing else."""
import fnmatch
import json
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "integration"))
import daemons  # after the path it needs

NOTICES = (ROOT / "THIRD_PARTY_NOTICES.md").read_text()
SOURCES = ("proto", "shared", "sim_server", "haptic_server", "tests/laboratory")  # fit_run is installed
OF_THE_SYSTEM = {"arpa/", "linux/", "net/", "netinet/", "sys/"}


def rows():
    """The tables' rows: component, licence, patterns."""
    for line in NOTICES.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| ") and cells[0] != "component":
            yield cells[0], cells[1], re.findall(r"`([^`]+)`", cells[-1])


def page_packages():
    return json.loads((ROOT / "shared/tools/scene_viewer/page/package.json").read_text())["dependencies"]


def linked_libraries():
    """Libraries that programs and plugins of the build link directly, but Open MPI, which a SUNDIALS brings along."""
    folders = (daemons.BUILD / "bin", daemons.BUILD / "lib" / "stillgrid")
    files = [file for folder in folders for file in folder.rglob("*") if file.is_file()]
    dynamic = subprocess.run(["readelf", "--dynamic", "--wide", *files], capture_output=True, text=True, check=True)
    return {name for name in re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic.stdout) if not name.startswith("libmpi")}


def included_folders():
    """That headers of others are included from, such as "Eigen/"."""
    include = re.compile(r"^\s*#\s*include\s*<([^/>]+/)", re.MULTILINE)
    return {folder for place in SOURCES for file in (ROOT / place).rglob("*") if file.suffix in (".cpp", ".hpp", ".h")
            for folder in include.findall(file.read_text(errors="replace"))} - OF_THE_SYSTEM - {"catch2/"}


class NoticesTest(unittest.TestCase):
    def setUp(self):
        self.patterns = {pattern: component for component, _, patterns in rows() for pattern in patterns}

    def assert_listed(self, names):
        missing = [name for name in sorted(names)
                   if not any(fnmatch.fnmatch(name, pattern) for pattern in self.patterns)]
        self.assertEqual(missing, [], "not in THIRD_PARTY_NOTICES.md")

    def test_every_library_that_a_program_links_is_listed(self):
        libraries = linked_libraries()
        self.assertIn("libc.so.6", libraries)
        self.assert_listed(libraries)

    def test_every_library_whose_headers_are_compiled_in_is_listed(self):
        folders = included_folders()
        self.assertIn("Eigen/", folders)
        self.assert_listed(folders)

    def test_every_package_that_the_page_serves_is_listed_under_its_licence(self):
        licences = {pattern: licence for _, licence, patterns in rows() for pattern in patterns}
        locked = json.loads((ROOT / "shared/tools/scene_viewer/page/package-lock.json").read_text())["packages"]
        for package in page_packages():
            self.assertEqual(licences.get(package), locked[f"node_modules/{package}"]["license"], package)

    def test_nothing_is_listed_that_is_not_there(self):
        there = linked_libraries() | included_folders() | set(page_packages())
        stale = {pattern: component for pattern, component in self.patterns.items() if not fnmatch.filter(there, pattern)}
        self.assertEqual(stale, {})

    def test_each_licence_is_written_out_with_the_copyright_of_each_component(self):
        ours = [(component, licence) for component, licence, _ in rows() if "GPL" not in licence]  # not the system's
        self.assertEqual({licence for _, licence in ours}, set(re.findall(r"^### (.*)$", NOTICES, re.MULTILINE)))
        words = " ".join(NOTICES.split())
        self.assertEqual([component for component, _ in ours if f"{component}: Copyright" not in words], [])


if __name__ == "__main__":
    daemons.main()
