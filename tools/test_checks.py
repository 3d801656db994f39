#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The checkers find what they are there to find."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
import check_layers  # noqa: E402
import check_sizes  # noqa: E402

TABLE = "add_layer(base PACKAGES fmt::fmt)\nadd_layer(math DEPS base)\nadd_layer(io DEPS base PRIVATE_PACKAGES x::y)\n"


class Repository(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.root = Path(self.temporary.name)
        self.write("src/mmlins/CMakeLists.txt", TABLE)

    def tearDown(self):
        self.temporary.cleanup()

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def assert_finds(self, checker, place, words):
        findings = checker.check(self.root)
        self.assertEqual(len(findings), 1, findings)
        self.assertTrue(findings[0].startswith(f"{self.root / place}:"), findings)
        self.assertIn(words, findings[0])


class Layers(Repository):
    def test_allowed_includes_pass(self):
        self.write("src/mmlins/math/a.cpp", '#include "mmlins/math/a.hpp"\n#include "mmlins/base/b.hpp"\n')
        self.assertEqual(check_layers.check(self.root), [])

    def test_an_include_outside_the_table_is_found(self):
        self.write("src/mmlins/base/a.cpp", '\n#include "mmlins/math/b.hpp"\n')
        self.assert_finds(check_layers, "src/mmlins/base/a.cpp:2", "layer base may not include mmlins/math/b.hpp")

    def test_siblings_may_not_include_each_other(self):
        self.write("src/mmlins/io/sub/a.hpp", "#include <mmlins/math/b.hpp>\n")
        self.assert_finds(check_layers, "src/mmlins/io/sub/a.hpp:1", "layer io may not include")

    def test_an_unknown_layer_is_found(self):
        self.write("src/mmlins/base/a.cpp", '#include "mmlins/nowhere/b.hpp"\n')
        self.assert_finds(check_layers, "src/mmlins/base/a.cpp:1", "in no layer")

    def test_a_folder_outside_the_table_is_found(self):
        self.write("src/mmlins/extra/a.cpp", "\n")
        self.assert_finds(check_layers, "src/mmlins/extra/a.cpp:1", "not in the table")

    def test_a_circle_of_layers_is_found(self):
        self.write("src/mmlins/CMakeLists.txt", "add_layer(base DEPS math)\nadd_layer(math DEPS base)\n")
        self.assert_finds(check_layers, "src/mmlins/CMakeLists.txt:1", "base depends on math")

    def test_wrapped_headers_stay_where_they_are_wrapped(self):
        self.write("src/mmlins/base/a.cpp", "#include <tbb/parallel_for.h>\n")
        self.assertEqual(check_layers.check(self.root), [])
        self.write("src/mmlins/math/a.cpp", "#include <tbb/parallel_for.h>\n")
        self.assert_finds(check_layers, "src/mmlins/math/a.cpp:1", "src/mmlins/base only")

    def test_paths_of_a_machine_are_found(self):
        self.write("tests/a.py", "open('/ho" + "me/somebody/x')\n")
        self.assert_finds(check_layers, "tests/a.py:1", "absolute path")


class Sizes(Repository):
    HEAD = "// SPDX-License-Identifier: MIT\n"

    def function(self, lines, head="int f(int x) {"):
        return head + "\n" + "  if (x) { x = '}'; }  // }\n" * (lines - 2) + "}\n"

    def test_a_function_of_sixty_lines_passes(self):
        self.write("src/a.cpp", self.HEAD + "namespace a {\n" + self.function(60) + "}\n")
        self.assertEqual(check_sizes.check(self.root), [])

    def test_a_longer_function_is_found_wherever_it_stands(self):
        for before, head, after in [("", "int f(int x) {", ""), ("namespace a {\n", "TEST(A, B) {", "}\n"),
                                    ("struct A {\n", "template <class T>\nint f(T x) const {", "};\n"),
                                    ("int y = 1;\n", "A::A(int x) : x_(x) {", "")]:
            with self.subTest(head=head):
                self.write("src/a.cpp", self.HEAD + before + self.function(61, head) + after)
                self.assert_finds(check_sizes, f"src/a.cpp:{2 + before.count(chr(10))}", "lines; at most 60")

    def test_a_long_file_is_found(self):
        self.write("src/a.cpp", self.HEAD + "\n" * 400)
        self.assert_finds(check_sizes, "src/a.cpp:401", "401 lines")

    def test_a_header_without_pragma_once_is_found(self):
        self.write("src/a.hpp", self.HEAD)
        self.assert_finds(check_sizes, "src/a.hpp:1", "pragma once")

    def test_a_file_without_licence_is_found(self):
        self.write("src/a.cpp", "int x;\n")
        self.assert_finds(check_sizes, "src/a.cpp:1", "SPDX")


if __name__ == "__main__":
    unittest.main()
