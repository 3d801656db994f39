#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""simulate and degrade on a disk that fills up: one line that says so, and nothing half-written."""

import resource
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from program import MMLINS, mmlins, shared  # noqa: E402

SIZE = 1_000_000  # [bytes] that fit; the recording has 4 MB
SHORT = ["--set", "duration=4", "--set", "sensor.columns=300"]
# A small disk of its own, which no other process sees; what is on it afterwards is printed last.
ON_SMALL_DISK = ["unshare", "--map-root-user", "--mount", "sh", "-c",
                 f'mount -t tmpfs -o size={SIZE} none "$0" || exit 77; "$@"; code=$?; ls -A "$0"; exit $code']


def limit_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (SIZE, SIZE))


def can_mount():
    if shutil.which("unshare") is None:
        return False
    with tempfile.TemporaryDirectory() as folder:
        return subprocess.run([*ON_SMALL_DISK, folder, "true"], capture_output=True).returncode == 0


class FullDisk(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        made = mmlins("simulate", "demo", "--out", shared("whole"), *SHORT)
        assert made.returncode == 0, made.stderr

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def commands(self):
        yield ["simulate", "demo", "--out", self.folder / "made", *SHORT]
        yield ["degrade", Path(shared("whole")) / "recording.bag", self.folder / "out.bag", "--event", "bag:1:1"]

    def assert_one_line(self, run, *words):
        self.assertEqual(run.returncode, 1, run.stderr)
        lines = [line for line in run.stderr.splitlines() if not line.startswith("simulated ")]
        self.assertEqual(len(lines), 1, run.stderr)
        for word in words:
            self.assertIn(word, lines[0])

    def test_a_full_disk_is_named_and_nothing_is_left_on_it(self):
        if not can_mount():
            self.skipTest("no right to mount a small disk")
        for command in self.commands():
            run = subprocess.run([*ON_SMALL_DISK, self.folder, MMLINS, *map(str, command)], capture_output=True, text=True)
            self.assert_one_line(run, ".bag: cannot be written: No space left on device; free some space")
            self.assertEqual(run.stdout, "", "nothing half-written")

    def test_neither_is_anything_left_if_the_system_allows_no_more(self):
        for command in self.commands():
            run = subprocess.run([MMLINS, *map(str, command)], capture_output=True, text=True, preexec_fn=limit_files,
                                 restore_signals=False)  # the signal for too large a file stays ignored
            self.assert_one_line(run, ".bag: cannot be written: File too large")
            self.assertEqual(list(self.folder.iterdir()), [], "nothing half-written")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
