#!/usr/bin/python3
"""The device interface changes under nobody's driver, and its page shows what was tested."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "integration"))
import daemons  # after the path it needs

HEADER = (ROOT / "proto" / "device_plugin.h").read_text()


class AbiTest(unittest.TestCase):
    def verdict_on(self, header):
        """check_abi's exit status and what it says."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "device_plugin.h"
            file.write_text(header)
            result = subprocess.run([ROOT / "scripts" / "check_abi", file], text=True,
                                    stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return result.returncode, result.stdout

    def changed(self, old, new):
        self.assertEqual(HEADER.count(old), 1, old)
        return self.verdict_on(HEADER.replace(old, new))

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


class DevicePageTest(unittest.TestCase):
    def test_the_page_shows_the_example_that_is_tested(self):
        page = (ROOT / "docs" / "devices.md").read_text()
        example = ROOT / "tests" / "install" / "handle"
        self.assertIn(f"```c\n{(example / 'handle.c').read_text()}```", page)
        self.assertIn(f"```cmake\n{(example / 'CMakeLists.txt').read_text()}```", page)


if __name__ == "__main__":
    daemons.main()
