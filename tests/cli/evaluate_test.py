#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""mmlins evaluate as a user meets it: what it prints, and what it says about bad input."""

import json
import sys
import tempfile
import unittest
from pathlib import Path

from program import mmlins


def evaluate(*arguments):
    return mmlins("evaluate", *arguments)


class Evaluate(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.good = self.file("good.tum", "".join(f"{i} {i} {i * i} 0 0 0 0 1\n" for i in range(10)))

    def tearDown(self):
        self.temporary.cleanup()

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def refused(self, *arguments):
        """The one line on standard error of a refused command."""
        run = evaluate(*arguments)
        self.assertEqual(run.returncode, 1)
        self.assertEqual(run.stdout, "")
        lines = run.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, run.stderr)
        return lines[0]

    def test_a_missing_file_is_named(self):
        missing = self.folder / "missing.tum"
        self.assertEqual(self.refused(self.good, missing), f"mmlins: {missing}: no such file; check the path")
        self.assertIn("no such file", self.refused(missing, self.good))

    def test_an_empty_file_is_named(self):
        empty = self.file("empty.tum", "# nothing\n")
        self.assertIn(f"{empty}: holds no pose", self.refused(self.good, empty))

    def test_a_malformed_row_is_named(self):
        bad = self.file("bad.tum", "1 0 0 0 0 0 0 1\n2 0 0 0\n")
        self.assertIn(f"{bad}:2: 4 columns", self.refused(self.good, bad))

    def test_a_folder_is_refused(self):
        self.assertIn("is a folder", self.refused(self.good, self.folder))

    def test_no_common_time_says_both_ranges(self):
        late = self.file("late.tum", "".join(f"{100 + i} {i} {i * i} 0 0 0 0 1\n" for i in range(10)))
        line = self.refused(self.good, late)
        self.assertIn("0.000000000 to 9.000000000 s", line)
        self.assertIn("100.000000000 to 109.000000000 s", line)

    def test_fewer_than_three_poses_are_refused(self):
        few = self.file("few.tum", "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n")
        self.assertIn("only 2 common poses", self.refused(self.good, few))

    def test_rows_out_of_order_are_sorted_with_a_warning(self):
        rows = self.good.read_text().splitlines()
        rows[3], rows[4] = rows[4], rows[3]
        run = evaluate(self.good, self.file("swapped.tum", "\n".join(rows)), "--json")
        self.assertEqual(run.returncode, 0)
        self.assertIn("1 rows out of order", run.stderr)
        self.assertLess(json.loads(run.stdout)["ate_m"]["max"], 1e-9)

    def test_text_tells_every_figure(self):
        run = evaluate(self.good, self.good)
        self.assertEqual(run.returncode, 0)
        for words in ["ATE [m]", "rotation error [deg]", "RPE over 1 s", "RPE per 100 m", "end-to-end", "coverage"]:
            self.assertIn(words, run.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
