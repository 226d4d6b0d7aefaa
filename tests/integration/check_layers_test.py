#!/usr/bin/python3
"""The checks of layers and format find what is planted, and nothing in what is clean."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import daemons

SCRIPTS = daemons.ROOT / "scripts"


class SourceTreeTest(unittest.TestCase):
    """A small tree of sources that breaks no rule, until a test plants something."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-"))
        self.addCleanup(shutil.rmtree, self.root)
        for folder in ("proto", "shared/publication", "sim_server", "haptic_server",
                       "tests"):
            (self.root / folder).mkdir(parents=True)
        shutil.copy(daemons.ROOT / ".clang-format", self.root)
        self.plant("proto/header.hpp", "#pragma once\n")
        self.plant("shared/publication/segment.hpp",
                   '#include <boost/interprocess/mapped_region.hpp>\n\n#include "proto/header.hpp"\n')
        self.plant("sim_server/dynamics/integrators/solver.cpp",
                   '#include <cvode/cvode.h>\n\n#include "shared/publication/segment.hpp"\n')
        self.plant("tests/solver_test.cpp",
                   '#include "haptic_server/a.hpp"\n#include "sim_server/b.hpp"\n')

    def plant(self, file, text):
        (self.root / file).parent.mkdir(parents=True, exist_ok=True)
        (self.root / file).write_text(text)

    def run_script(self, name):
        return subprocess.run([SCRIPTS / name, self.root], capture_output=True, text=True,
                              timeout=30 * daemons.PATIENCE, check=False)


class CheckLayersTest(SourceTreeTest):
    def assert_found(self, file, include, *words):
        self.plant(file, f"#pragma once\n\n#include {include}\n")
        result = self.run_script("check_layers")
        self.assertEqual(result.returncode, 1, result.stderr)
        lines = result.stdout.splitlines()
        self.assertEqual(len(lines), 1, lines)
        self.assertTrue(lines[0].startswith(f"{file}:3: "), lines)
        for word in words:
            self.assertIn(word, lines[0])

    def test_a_clean_tree_has_no_violation(self):
        result = self.run_script("check_layers")
        self.assertEqual((result.returncode, result.stdout), (0, ""), result.stderr)

    def test_proto_may_include_nothing_of_ours(self):
        self.assert_found("proto/bad.hpp", '"shared/publication/segment.hpp"', "shared/")

    def test_shared_may_not_include_a_server(self):
        self.assert_found("shared/bad.hpp", '"sim_server/world.hpp"', "sim_server/")

    def test_sim_server_may_not_include_haptic_server(self):
        self.assert_found("sim_server/bad.cpp", '"haptic_server/server.hpp"', "haptic_server/")

    def test_haptic_server_may_not_include_sim_server(self):
        self.assert_found("haptic_server/bad.cpp", '"sim_server/server.hpp"', "sim_server/")

    def test_a_program_may_not_include_tests(self):
        self.assert_found("sim_server/bad.cpp", '"tests/helper.hpp"', "tests/")

    def test_angle_brackets_hide_nothing(self):
        self.assert_found("shared/bad.hpp", "<haptic_server/server.hpp>", "haptic_server/")

    def test_an_include_is_written_from_the_root(self):
        self.assert_found("shared/bad.hpp", '"segment.hpp"', "root")
        self.assert_found("shared/bad.hpp", '"proto/../shared/segment.hpp"', "root")

    def test_boost_interprocess_is_for_publication_only(self):
        self.assert_found("haptic_server/bad.cpp", "<boost/interprocess/mapped_region.hpp>",
                          "shared/publication")

    def test_sundials_is_for_dynamics_only(self):
        self.assert_found("sim_server/bad.cpp", "<sundials/sundials_types.h>",
                          "sim_server/dynamics")

    def test_highway_is_for_contact_and_dynamics_only(self):
        self.plant("sim_server/dynamics/forces.cpp", "#include <hwy/highway.h>\n")
        self.assert_found("sim_server/bad.cpp", "<hwy/highway.h>", "sim_server/contact",
                          "sim_server/dynamics")

    def test_a_folder_below_the_top_includes_what_its_arrows_name(self):
        self.plant("sim_server/scene/reader.cpp", '#include "sim_server/bodies/world.hpp"\n')
        self.test_a_clean_tree_has_no_violation()
        self.assert_found("sim_server/bodies/bad.hpp", '"sim_server/scene/scene_file.hpp"',
                          "sim_server/bodies/ may not include sim_server/scene/")

    def test_a_folder_without_arrows_is_refused(self):
        self.assert_found("sim_server/garage/bad.hpp", '"sim_server/bodies/world.hpp"',
                          "sim_server/garage/ is not in the table")

    def assert_lines(self, *lines):
        result = self.run_script("check_layers")
        self.assertEqual((result.returncode, result.stdout.splitlines()), (1, list(lines)), result.stderr)

    def test_a_circle_of_arrows_is_refused(self):
        text = (SCRIPTS / "check_layers").read_text()
        arrow = '"sim_server/bodies": {'
        self.assertIn(arrow, text)
        script = self.root / "check_layers"
        script.write_text(text.replace(arrow, arrow + '"sim_server/scene", '))
        result = subprocess.run(["python3", script, self.root], capture_output=True, text=True,
                                timeout=30 * daemons.PATIENCE, check=False)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("a circle: sim_server/bodies > sim_server/scene > sim_server/bodies\n", result.stdout)

    def test_a_circle_of_folders_by_way_of_a_top_folder_is_refused(self):
        self.plant("sim_server/world.hpp", '#include "sim_server/scene/method.hpp"\n')
        self.test_a_clean_tree_has_no_violation()
        self.plant("sim_server/scene/reader.hpp", '#pragma once\n#include "sim_server/world.hpp"\n')
        self.assert_lines("sim_server/world.hpp:1: a circle: sim_server > sim_server/scene > sim_server")

    def test_a_circle_of_headers_is_refused(self):
        self.plant("shared/files/a.hpp", '#include "shared/files/b.hpp"\n')
        self.plant("shared/files/b.hpp", '#include "shared/files/c.hpp"\n')
        self.test_a_clean_tree_has_no_violation()
        self.plant("shared/files/c.hpp", '#pragma once\n#include "shared/files/a.hpp"\n')
        self.assert_lines("shared/files/a.hpp:1: a circle: shared/files/a.hpp > shared/files/b.hpp > "
                          "shared/files/c.hpp > shared/files/a.hpp")

    def test_a_file_stands_in_the_namespace_of_its_folder(self):
        for file, namespace in {
                "proto/a.hpp": "proto", "sim_server/a.hpp": "sim_server",
                "sim_server/dynamics/solvers/a.hpp": "dynamics",
                "tests/laboratory/fit_run/a.cpp": "fit_run::detail",
                "tests/sim_server/a.cpp": "sim_server", "tests/sim_server/mesh/a.cpp": "mesh",
                "tests/laws/a.cpp": "laws",
                "tests/stability/rivals/a.cpp": "laboratory"}.items():
            self.plant(file, "namespace stillgrid::toml {\nclass Reader;\n}\n\n"
                             f"namespace stillgrid::{namespace} {{\nnamespace {{\nint a();\n}}  // namespace\n"
                             f"}}  // namespace stillgrid::{namespace}\n")
        self.test_a_clean_tree_has_no_violation()
        text = "namespace stillgrid::bodies {\nint a();\n}  // namespace stillgrid::bodies\n"
        self.plant("tests/sim_server/mesh/a.cpp", text.replace("::bodies", ""))
        self.plant("sim_server/mesh/a.hpp", text)
        self.assert_lines(
            "sim_server/mesh/a.hpp:1: namespace stillgrid::bodies where its folder's is stillgrid::mesh",
            "tests/sim_server/mesh/a.cpp:1: namespace stillgrid where its folder's is stillgrid::mesh")

    def test_two_types_of_one_name_in_one_namespace_are_refused(self):
        point = "namespace stillgrid::mesh {\n\n%s\n\n}  // namespace stillgrid::mesh\n"
        first = point % "struct Point {\n  double x = 0.0;\n};"
        self.plant("sim_server/mesh/point.hpp", "namespace stillgrid::mesh {\nint a();\n}\n\n" + first)
        self.plant("sim_server/mesh/unnamed.cpp", point % "namespace {\nstruct Point {};\n}  // namespace")
        self.plant("shared/collision/other.hpp", first.replace("mesh", "collision"))
        self.plant("sim_server/mesh/user.hpp", point % "struct Point;\nPoint moved(const Point& point);")
        self.test_a_clean_tree_has_no_violation()
        for type_ in ("struct Point {\n  int x;\n};", "class [[nodiscard]] Point final {};",
                      "template <typename T>\nstruct Point : Base<T> {\n  T x;\n};",
                      "template <int n> struct Point {};", "enum class Point { kOne };",
                      "struct alignas(alignof(double)) Point { int x; };", "union Point { int x; };"):
            self.plant("sim_server/mesh/second.hpp", point % type_)
            number = 4 if type_.startswith("template <typename") else 3
            self.assert_lines(f"sim_server/mesh/second.hpp:{number}: stillgrid::mesh::Point is defined in "
                              "sim_server/mesh/point.hpp too")


@unittest.skipUnless(shutil.which("clang-format-14"), "skipped: clang-format-14 is not installed, see scripts/setup")
class CheckFormatTest(SourceTreeTest):
    def test_a_clean_tree_is_formatted(self):
        result = self.run_script("check_format")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_what_is_not_formatted_is_named(self):
        self.plant("shared/bad.hpp", "#pragma once\nint  x ;\n")
        result = self.run_script("check_format")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("shared/bad.hpp:2:", result.stdout)


class WithoutClangFormatTest(SourceTreeTest):
    def test_the_check_of_the_format_is_skipped_where_its_program_is_not_installed(self):
        tools = self.root / "tools"
        tools.mkdir()
        for name in ("bash", "dirname"):
            (tools / name).symlink_to(shutil.which(name))
        result = subprocess.run([daemons.ROOT / "scripts" / "check_format", self.root], env={"PATH": str(tools)},
                                capture_output=True, text=True, check=False)
        self.assertEqual((result.returncode, result.stdout), (77, "check_format: skipped: no clang-format-14\n"))


if __name__ == "__main__":
    daemons.main()
