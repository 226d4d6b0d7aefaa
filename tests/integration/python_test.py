#!/usr/bin/python3
"""The Python package over libstillgrid: its structs are the header's, arrays are not copied, errors are one line."""
import copy
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy

import daemons

HEADER = daemons.ROOT / "proto" / "stillgrid.h"
os.environ["STILLGRID_LIBRARY"] = str(daemons.BUILD / "lib" / "libstillgrid.so.1")
import stillgrid  # the path is that of recording, which daemons imports
from stillgrid import _arrays, _library

STRUCTS = {f"stillgrid_{name}": getattr(_library, python) for name, python in (
    ("material", "Material"), ("plane", "Plane"), ("shapes", "Shapes"), ("hand", "Hand"), ("scene", "Scene"),
    ("tool", "Tool"), ("session_state", "SessionState"), ("fixed", "Fixed"), ("snapshot", "Snapshot"),
    ("mesh", "Mesh"), ("cover", "Cover"), ("response", "RESPONSE"), ("push", "PUSH"))}
SCENE = stillgrid.Scene(0.02, 4, [stillgrid.Material(500.0, 1.0)], gives_inertia=True)


def layout_of(struct):
    """Size, and offset and size of each field by name."""
    if isinstance(struct, numpy.dtype):
        return struct.itemsize, {name: (offset, kind.itemsize) for name, (kind, offset) in struct.fields.items()}
    fields = ((name, getattr(struct, name)) for name, _ in struct._fields_)
    return _library.ctypes.sizeof(struct), {name: (field.offset, field.size) for name, field in fields}


class HeaderTest(daemons.SessionTest):
    def ask_compiler(self, *lines):
        source = self.write("ask.c", "#include <stddef.h>\n#include <stdio.h>\n#include <stillgrid.h>\n"
                            "int main(void) {\n" + "\n".join(lines) + "\nreturn 0; }\n")
        program = self.folder / "ask"
        subprocess.run(["cc", "-std=c11", "-Wall", "-Werror", f"-I{HEADER.parent}", source, "-o", program], check=True)
        return subprocess.run([program], check=True, text=True, capture_output=True).stdout.split()

    def test_each_struct_has_the_size_and_the_fields_of_the_header(self):
        text = re.sub(r"/\*.*?\*/", "", HEADER.read_text(), flags=re.S)
        self.assertEqual(set(re.findall(r"^\} (\w+);", text, re.M)), set(STRUCTS))
        for name, struct in STRUCTS.items():
            body = re.search(rf"typedef struct {name} \{{(.*?)^\}}", text, re.S | re.M)[1]
            fields = re.findall(r"(\w+)(?:\[\d+\])?;", body)
            told = self.ask_compiler(f'printf("%zu\\n", sizeof({name}));', *(
                f'printf("%zu %zu\\n", offsetof({name}, {field}), sizeof((({name}*)0)->{field}));'
                for field in fields))
            size, *numbers = map(int, told)
            with self.subTest(name):
                self.assertEqual(layout_of(struct), (size, dict(zip(fields, zip(numbers[::2], numbers[1::2])))))

    def test_each_code_and_each_function_is_that_of_the_header(self):
        text = re.sub(r"/\*.*?\*/", "", HEADER.read_text(), flags=re.S)
        codes = dict(re.findall(r"#define STILLGRID_(?:E_)?([A-Z]+) \(?(-?\d+)\)? *$", text, re.M))
        self.assertEqual({name: int(code) for name, code in codes.items()},
                         {code.name: code.value for code in stillgrid.Code})
        functions = re.findall(r"STILLGRID_API [\w ]+\*?\s?stillgrid_(\w+)\((.*?)\);", text, re.S)
        self.assertEqual({name: 0 if taken == "void" else taken.count(",") + 1 for name, taken in functions},
                         {name: len(signature) - 1 for name, signature in _library.SIGNATURES.items()})


class ArrayTest(unittest.TestCase):
    def test_an_array_that_is_so_already_is_read_where_it_is(self):
        whole = numpy.zeros((5, 3))
        whole.flags.writeable = False
        self.assertIs(_arrays.floats(whole, "a", None, 3), whole)
        self.assertIs(_arrays.floats(whole[1:3], "a", None, 3).base, whole)
        numbers = numpy.zeros(5, numpy.uint32)
        self.assertIs(_arrays.indices(numbers, "a", None), numbers)

    def test_any_other_array_of_numbers_is_converted_to_the_same_values(self):
        values = numpy.arange(12.0).reshape(4, 3)
        for other in (values.tolist(), values.astype("f4"), values.astype(int), values.astype(">f8"),
                      numpy.asfortranarray(values), numpy.repeat(values, 2, axis=0)[::2]):
            read = _arrays.floats(other, "a", None, 3)
            self.assertTrue((read == values).all() and read.flags.c_contiguous and read.dtype == float)
        self.assertEqual(_arrays.floats([], "a", None).shape, (0,))

    def test_a_wrong_shape_or_type_is_refused_in_one_line(self):
        for read, values, line in (
                (_arrays.floats, numpy.zeros((3, 2)), r"a: shape \(3, 2\): expected \(N, 3\)"),
                (_arrays.floats, numpy.zeros(3), r"a: shape \(3,\): expected \(N, 3\)"),
                (_arrays.floats, [["x"] * 3], "a: dtype <U1: expected numbers"),
                (_arrays.floats, numpy.zeros((1, 3), complex), "a: dtype complex128: expected numbers"),
                (_arrays.floats, [[1, 2], [3]], "a: expected an array of numbers"),
                (_arrays.indices, [[0.5, 1, 2]], "a: dtype float64: expected whole numbers"),
                (_arrays.indices, [[-1, 0, 1]], "a: -1 to 1: expected 0 to 4294967295")):
            with self.subTest(line), self.assertRaisesRegex(ValueError, f"^{line}$"):
                read(values, "a", None, 3)


class HandleTest(unittest.TestCase):
    def test_a_publisher_is_not_copied_and_numbers_do_not_wrap(self):
        scene = stillgrid.Scene(0.02, 1, [stillgrid.Material(500.0)])
        with stillgrid.Publisher(scene, f"copied-{os.getpid()}") as publisher:
            for copied in (copy.copy, copy.deepcopy):
                with self.assertRaises(TypeError):
                    copied(publisher)
            for call in (lambda: publisher.publish(2**64 + 5), lambda: publisher.publish(1.5),
                         lambda: publisher.tool(-1), lambda: publisher.tool(2**32)):
                with self.assertRaisesRegex(ValueError, "expected"):
                    call()



@unittest.skipUnless(pathlib.Path("/usr/bin/mypy").exists(), "skipped: mypy is not installed, see scripts/setup")
class TypesTest(unittest.TestCase):
    def test_the_packages_type_hints_are_whole_and_right(self):
        package = pathlib.Path(stillgrid.__file__).parent
        result = subprocess.run(["/usr/bin/mypy", "--strict", "--cache-dir", os.devnull, "--python-executable",
                                 "/usr/bin/python3", package], text=True, capture_output=True)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


class PublisherTest(daemons.SessionTest):
    def publisher(self, scene=SCENE, **options):
        publisher = stillgrid.Publisher(scene, self.session, **options)
        self.addCleanup(publisher.close)
        return publisher

    def assert_refused(self, code, words, call, *arguments):
        with self.assertRaisesRegex(stillgrid.StillgridError, words) as raised:
            call(*arguments)
        self.assertEqual(raised.exception.code, code)
        self.assertNotIn("\n", raised.exception.line)

    def test_calls_in_a_wrong_order_say_what_comes_first(self):
        publisher, code = self.publisher(), stillgrid.Code.ORDER
        state = numpy.zeros((1, 3))
        self.assert_refused(code, r"expected set_shapes\(\) first", publisher.set_spheres, state)
        publisher.set_shapes([0.01])
        self.assert_refused(code, r"expected set_spheres\(\) first", publisher.publish)
        self.assert_refused(code, r"expected set_spheres\(\) first", publisher.pushes)
        publisher.set_spheres(state, state)
        self.assertEqual(len(publisher.pushes()), 0)
        self.assert_refused(code, r"expected before pushes\(\)", publisher.set_responses, [0], state,
                            numpy.zeros((1, 6)), [numpy.eye(6)])
        publisher.publish()
        self.assertIsNone(publisher.tool())
        publisher.close()
        self.assert_refused(code, "not closed", publisher.publish)

    def test_what_is_no_number_and_what_is_too_much_changes_nothing(self):
        publisher = self.publisher()
        publisher.set_shapes([0.01, 0.01])
        publisher.set_spheres(numpy.zeros((2, 3)))
        argument, capacity = stillgrid.Code.ARGUMENT, stillgrid.Code.CAPACITY
        self.assert_refused(argument, "positions_m", publisher.set_spheres, numpy.full((2, 3), numpy.nan))
        self.assert_refused(argument, "velocities_m_s", publisher.set_spheres, numpy.zeros((2, 3)),
                            numpy.full((2, 3), numpy.inf))
        self.assert_refused(argument, "expected the 2 of", publisher.set_spheres, numpy.zeros((3, 3)))
        self.assert_refused(capacity, "expected the 4 of sphere_capacity", publisher.set_shapes, numpy.ones(5))
        self.assert_refused(argument, "radii_m", publisher.set_shapes, [0.01, -1.0])
        self.assert_refused(argument, "materials", publisher.set_shapes, [0.01], [1])
        with self.assertRaisesRegex(ValueError, r"velocities_m_s: shape \(1, 3\): expected \(2, 3\)"):
            publisher.set_spheres(numpy.zeros((2, 3)), numpy.zeros((1, 3)))
        publisher.publish()
        publisher.set_shapes(numpy.ones(4))  # it may grow to what was declared
        publisher.set_spheres(numpy.zeros((4, 3)))
        publisher.publish()

    def test_a_scene_that_says_nothing_true_is_refused(self):
        material = stillgrid.Material(500.0)
        for scene, words in (
                (stillgrid.Scene(0.0, 1, [material]), "period_s"), (stillgrid.Scene(0.02, 1, []), "materials"),
                (stillgrid.Scene(0.02, 1, [stillgrid.Material(numpy.nan)]), "materials"),
                (stillgrid.Scene(0.02, 1, [material], [stillgrid.Plane((0, 0, 2), 0.0)]), "planes"),
                (stillgrid.Scene(0.02, 1, [material], hands=[stillgrid.Hand(name="a/b")]), "name")):
            with self.subTest(words):
                self.assert_refused(stillgrid.Code.ARGUMENT, words, self.publisher, scene)
        with self.assertRaisesRegex(ValueError, "tool_m"):
            self.publisher(stillgrid.Scene(0.02, 1, [material], hands=[stillgrid.Hand(tool_m=[0.0])]))

    def test_a_session_has_one_publisher_at_a_time(self):
        with self.publisher():
            self.assert_refused(stillgrid.Code.SESSION, self.session, self.publisher)
        self.publisher()

    def test_a_forked_child_that_ends_does_not_end_the_session(self):
        publisher = self.publisher(stillgrid.Scene(0.02, 0, [stillgrid.Material(500.0)]))
        publisher.publish()
        child = os.fork()
        if child == 0:
            publisher.close()
            os._exit(0)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        publisher.publish()
        with stillgrid.Reader(self.session) as reader:
            state = reader.poll()
            self.assertEqual((state.is_published, state.snapshots), (True, 2))

    def test_a_second_thread_inside_a_handle_is_told(self):
        publisher, ended = self.publisher(virtual_time=True), threading.Event()
        publisher.set_shapes([])
        publisher.wait()
        publisher.set_spheres(numpy.zeros((0, 3)))
        publisher.publish()
        codes = []

        def wait():
            while not ended.is_set():
                publisher._call["wait"](publisher._handle, _library.ctypes.byref(_library.c_uint64()))

        def is_told():
            try:
                publisher.set_shapes([])
            except stillgrid.StillgridError as error:
                codes.append(error.code)
            return bool(codes)

        thread = threading.Thread(target=wait)
        thread.start()
        try:
            self.wait_until(is_told, 5, "a thread's error")
        finally:
            ended.set()
            thread.join()
        self.assertEqual(codes, [stillgrid.Code.THREAD])

    def test_interrupt_ends_a_wait_for_a_haptic_server(self):
        program = self.write("waits.py", f"""
import stillgrid
scene = stillgrid.Scene(0.02, 0, [stillgrid.Material(500.0)])
with stillgrid.Publisher(scene, {self.session!r}, virtual_time=True) as publisher:
    for _ in publisher.steps():
        publisher.publish()
        print("published", flush=True)
""")
        process = start_python(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        self.assertEqual(process.stdout.readline(), b"published\n")
        process.send_signal(signal.SIGINT)
        self.assertIn(b"KeyboardInterrupt", process.communicate(timeout=30)[1])


def start_python(program, *arguments, **options):
    path = str(pathlib.Path(stillgrid.__file__).parents[1])
    return subprocess.Popen(["setpriv", "--pdeathsig", "KILL", sys.executable, str(program), *arguments],
                            env=dict(os.environ, PYTHONPATH=path), **options)


if __name__ == "__main__":
    daemons.main()
