#!/usr/bin/python3
"""The C interfaces change under nobody's driver or program, and a page shows what was tested."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "integration"))
import daemons  # after the path it needs

CHECK = ROOT / "scripts" / "check_abi"
HEADER = (ROOT / "proto" / "device_plugin.h").read_text()
LIBRARY_HEADER = (ROOT / "proto" / "stillgrid.h").read_text()
LIBRARY = pathlib.Path(os.environ["STILLGRID_BUILD_DIR"]) / "lib" / "libstillgrid.so.1"


def verdict(*arguments):
    """check_abi's exit status and what it says."""
    result = subprocess.run([CHECK, *arguments], text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT)
    return result.returncode, result.stdout


class AbiTest(unittest.TestCase):
    def verdict_on(self, header, name="device_plugin.h"):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / name
            file.write_text(header)
            return verdict(file)

    def changed(self, old, new):
        self.assertEqual(HEADER.count(old), 1, old)
        return self.verdict_on(HEADER.replace(old, new))

    def library_changed(self, old, new):
        self.assertEqual(LIBRARY_HEADER.count(old), 1, old)
        return self.verdict_on(LIBRARY_HEADER.replace(old, new), "stillgrid.h")

    def test_the_device_interface_is_that_of_its_reviewed_baseline(self):
        self.assertEqual(self.verdict_on(HEADER), (0, ""))

    def test_a_change_that_breaks_drivers_is_found(self):
        field = "  double nominal_stiffness_N_m;"
        for old, new in (
                (field, "  double inserted;\n" + field),
                (field, "  float nominal_stiffness_N_m;"),
                ("#define STILLGRID_DEVICE_E_IO (-5)", "#define STILLGRID_DEVICE_E_IO (-7)"),
                ("const double force_N[3]", "const float force_N[3]"),
                ("double motor_time_constant_s", "double motor_time_s"),
                ("int32_t stillgrid_device_negotiate(", "int32_t stillgrid_device_negotiate2("),
                # behind the last field, but in padding that a driver of today counts as its own
                ("  int32_t (*identify)", "  uint32_t a;\n  int32_t (*identify)")):
            with self.subTest(new):
                status, text = self.changed(old, new)
                self.assertEqual(status, 1)
                self.assertIn("would break", text)

    def test_growth_at_a_structs_end_asks_for_a_review_and_no_more(self):
        status, text = self.changed("} stillgrid_device_descriptor;",
                                    "  double later_field;\n} stillgrid_device_descriptor;")
        self.assertEqual(status, 1)
        self.assertIn("has grown", text)
        self.assertIn("later_field", text)

    def test_the_interface_of_libstillgrid_is_that_of_its_reviewed_baseline(self):
        self.assertEqual(self.verdict_on(LIBRARY_HEADER, "stillgrid.h"), (0, ""))

    def test_a_change_that_breaks_programs_of_libstillgrid_is_found(self):
        for old, new in (
                ("#define STILLGRID_E_ORDER (-2)", "#define STILLGRID_E_ORDER (-3)"),
                ("double step_s,", "float step_s,"),
                ("STILLGRID_API void stillgrid_reader_close(stillgrid_reader* reader);", ""),
                ("  uint64_t tick;\n", ""),
                # behind the last field, but of an array that the library strides through
                ("} stillgrid_push;", "  double later_field;\n} stillgrid_push;")):
            with self.subTest(new):
                status, text = self.library_changed(old, new)
                self.assertEqual(status, 1)
                self.assertIn("would break", text)

    def test_a_struct_of_libstillgrid_that_tells_its_size_may_grow(self):
        for old, new in (("} stillgrid_tool;", "  double later_field;\n} stillgrid_tool;"),
                         ("/* Who is there. */", "STILLGRID_API int stillgrid_later_field(void);")):
            status, text = self.library_changed(old, new)
            self.assertEqual(status, 1)
            self.assertIn("has grown", text)
            self.assertIn("later_field", text)

    def test_libstillgrid_shows_the_functions_of_its_header_and_nothing_else(self):
        self.assertEqual(verdict("--library", LIBRARY), (0, ""))
        status, text = verdict("--library", LIBRARY.parent / "stillgrid/devices/phantom.so")
        self.assertEqual(status, 1)
        self.assertIn("not in the library: stillgrid_publisher_open", text)
        self.assertIn("not in the header: stillgrid_device_negotiate", text)


class ReaderPageTest(unittest.TestCase):
    def test_the_page_of_readers_shows_the_logger_that_is_tested(self):
        page = (ROOT / "docs" / "library_reader.md").read_text()
        logger = ROOT / "tests" / "shared" / "library" / "logger.c"
        self.assertIn(f"```c\n{logger.read_text()}```", page)


if __name__ == "__main__":
    daemons.main()
