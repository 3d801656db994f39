# SPDX-License-Identifier: MIT
"""mmlins simulate as a user runs it: files, determinism, and one clear line for everything that is wrong."""

import filecmp
import os
import subprocess
import sys
import tempfile
import unittest

MMLINS = sys.argv[1]
FILES = ["events.csv", "map.svg", "recording.bag", "rig.yaml", "scenario.yaml", "truth.tum"]
# Small enough for a second: 2 s, few columns.
SHORT = ["--set", "duration=2", "--set", "trajectory.stand_still=0.5", "--set", "sensor.columns=120"]


def text_of(path):
    with open(path) as file:
        return file.read()


def simulate(*arguments):
    return subprocess.run([MMLINS, "simulate", *arguments], capture_output=True, text=True, timeout=120)


class Simulate(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)

    def assert_refused(self, result, *words):
        self.assertNotEqual(result.returncode, 0)
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        self.assertEqual(len(lines), 1, result.stderr)
        for word in words:
            self.assertIn(word, lines[0])

    def test_writes_recording_truth_rig_and_scenario(self):
        result = simulate("demo", "--out", self.path("a"), *SHORT)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(sorted(os.listdir(self.path("a"))), FILES)
        rows = [line.split() for line in text_of(self.path("a/truth.tum")).splitlines()]
        self.assertEqual(len(rows), 201)  # 100 Hz, both ends
        self.assertTrue(all(len(row) == 8 for row in rows))
        self.assertEqual(rows[0][0], "1700000000.000000000")
        self.assertEqual(rows[-1][0], "1700000002.000000000")

    def test_same_seed_gives_the_same_bytes_and_another_seed_others(self):
        for name, seed in (("a", "5"), ("b", "5"), ("c", "6")):
            result = simulate("demo", "--out", self.path(name), *SHORT, "--set", "seed=" + seed)
            self.assertEqual(result.returncode, 0, result.stderr)
        for name in FILES:
            self.assertTrue(filecmp.cmp(self.path("a/" + name), self.path("b/" + name), shallow=False), name)
        self.assertFalse(filecmp.cmp(self.path("a/recording.bag"), self.path("c/recording.bag"), shallow=False))

    def test_the_scenario_that_it_writes_makes_the_same_recording(self):
        self.assertEqual(simulate("dev_office_mid360", "--out", self.path("a"), *SHORT).returncode, 0)
        self.assertEqual(simulate(self.path("a/scenario.yaml"), "--out", self.path("b")).returncode, 0)
        for name in FILES:
            self.assertTrue(filecmp.cmp(self.path("a/" + name), self.path("b/" + name), shallow=False), name)

    def test_a_path_through_a_wall_and_a_missing_cloud_are_refused_and_leave_nothing(self):
        self.assert_refused(simulate("demo", "--out", self.path("a"), "--set", "trajectory.semi_axis_x=30"), "leads through", "demo")
        cloud = ["demo", "--out", self.path("a"), "--set", "world.scene=cloud", "--set"]
        self.assert_refused(simulate(*cloud, "world.file=/missing.pcd"), "/missing.pcd")
        self.assertFalse(os.path.exists(self.path("a")))

    def test_a_cloud_becomes_a_world(self):
        with open(self.path("site.ply"), "w", encoding="ascii") as file:  # the floor and four walls of a hall
            points = [(0.1 * i, 0.1 * k, 0.0) for i in range(-200, 201) for k in range(-200, 201)]
            for z in range(60):
                for i in range(-200, 201):
                    points += [(0.1 * i, 20, 0.1 * z), (0.1 * i, -20, 0.1 * z)]
                    points += [(20, 0.1 * i, 0.1 * z), (-20, 0.1 * i, 0.1 * z)]
            header = "ply\nformat ascii 1.0\nelement vertex %d\n" % len(points)
            file.write(header + "".join("property float %s\n" % axis for axis in "xyz") + "end_header\n")
            file.writelines("%.2f %.2f %.2f\n" % point for point in points)
        options = ["--set", "world.scene=cloud", "--set", "world.file=" + self.path("site.ply")]
        result = simulate("demo", "--out", self.path("a"), *SHORT, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn(" 0 points", result.stdout)

    def test_events_are_written_with_absolute_times(self):
        event = "events=[{kind: bag, start: 0.5, duration: 1}, {kind: packet_loss, start: 1.75, duration: 0.1}]"
        self.assertEqual(simulate("demo", "--out", self.path("a"), *SHORT, "--set", event).returncode, 0)
        self.assertEqual(
            text_of(self.path("a/events.csv")),
            "kind,start,end,severity\n"
            "bag,1700000000.500000000,1700000001.500000000,0.6\n"
            "packet_loss,1700000001.750000000,1700000001.850000000,1\n",
        )

    def test_an_event_outside_of_the_recording_is_refused(self):
        event = "events=[{kind: bag, start: 1.5, duration: 1}]"
        result = simulate("demo", "--out", self.path("a"), *SHORT, "--set", event)
        self.assert_refused(result, "bag:1.5:1", "2.000 s")
        self.assertFalse(os.path.exists(self.path("a")))

    def test_lists_the_scenarios_with_what_they_are(self):
        result = simulate("--list")
        self.assertEqual(result.returncode, 0)
        scenarios, parts = result.stdout.split("\n\n")
        names = [line.split()[0] for line in scenarios.splitlines()]
        for name in ("demo", "dev_hall16", "heldout_street32", "long_drive"):
            self.assertIn(name, names)
        self.assertTrue(all(len(line.split()) > 3 for line in scenarios.splitlines()))
        for part in ("floors", "os1_64", "consumer", "quadruped", "elevator"):
            self.assertIn(part, parts)

    def test_an_unknown_scenario_gets_the_nearest_name(self):
        self.assert_refused(simulate("dmo", "--out", self.path("a")), "dmo", "'demo'")
        self.assertFalse(os.path.exists(self.path("a")))

    def test_a_missing_file_is_named(self):
        self.assert_refused(simulate(self.path("none.yaml"), "--out", self.path("a")), "none.yaml")

    def test_an_unknown_key_is_named_with_file_and_line(self):
        self.write("bad.yaml", "duration: 3\ntrajectory: {sped: 2}\n")
        self.assert_refused(simulate(self.path("bad.yaml"), "--out", self.path("a")), "bad.yaml", "2", "sped", "speed")

    def test_a_value_out_of_range_is_refused(self):
        self.assert_refused(simulate("demo", "--out", self.path("a"), "--set", "duration=-1"), "duration")
        self.assertFalse(os.path.exists(self.path("a")))

    def test_an_unwritable_folder_is_named(self):
        self.write("file", "in the way")
        self.assert_refused(simulate("demo", "--out", self.path("file/out"), *SHORT), "file/out")

    def test_an_existing_file_as_folder_is_refused_and_kept(self):
        self.write("file", "in the way")
        self.assert_refused(simulate("demo", "--out", self.path("file"), *SHORT), "file")
        self.assertEqual(text_of(self.path("file")), "in the way")

    def test_nothing_is_said_twice_when_arguments_are_missing(self):
        self.assert_refused(simulate("demo"), "--out")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
