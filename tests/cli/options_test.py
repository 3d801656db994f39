#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What every command does with options, settings and paths that make no sense: one line, and nothing else."""

import sys
import tempfile
import unittest
from pathlib import Path

from program import mmlins

COMMANDS = ["run", "info", "evaluate", "simulate", "config", "maps"]


class Refusals(unittest.TestCase):
    """Runs in an empty folder and checks that it stays as it was."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)

    def tearDown(self):
        self.temporary.cleanup()

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def refused(self, *arguments):
        """The one line that a refused command prints."""
        before = sorted(self.folder.rglob("*"))
        run = mmlins(*arguments, folder=self.folder)
        self.assertGreater(run.returncode, 0, arguments)
        self.assertEqual(run.stdout, "", arguments)
        self.exit_code = run.returncode
        lines = run.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, run.stderr)
        self.assertTrue(lines[0].startswith("mmlins: "), lines[0])
        self.assertEqual(sorted(self.folder.rglob("*")), before, "something was left behind")
        return lines[0]


class Options(Refusals):
    def test_without_a_command_the_commands_are_listed(self):
        line = self.refused()
        for command in COMMANDS:
            self.assertIn(command, line)

    def test_an_unknown_command_is_named(self):
        self.assertIn("there is no command 'frobnicate'", self.refused("frobnicate"))

    def test_an_unknown_option_is_named_by_every_command(self):
        for command in COMMANDS:
            with self.subTest(command=command):
                arguments = {"config": [], "evaluate": ["a", "b"], "maps": ["a", "list"]}.get(command, ["a"])
                line = self.refused(command, *arguments, "--no-such-option")
                self.assertIn("--no-such-option", line)
                self.assertIn("mmlins maps a list --help" if command == "maps" else f"mmlins {command} --help", line)

    def test_missing_arguments_are_named(self):
        self.assertIn("RECORDING", self.refused("run"))
        self.assertIn("TRUTH", self.refused("evaluate"))
        self.assertIn("ESTIMATE", self.refused("evaluate", "a.tum"))

    def test_values_an_option_does_not_take_are_named(self):
        self.assertIn("--threads: Value -1 not in range", self.refused("run", "a.bag", "--threads", "-1"))
        self.assertIn("--threads: Value two not in range", self.refused("run", "a.bag", "--threads", "two"))
        self.assertIn("--align: sim3 not in {se3,yaw,none}", self.refused("evaluate", "a", "b", "--align", "sim3"))

    def test_a_command_line_that_cannot_be_understood_ends_with_2_and_bad_input_with_1(self):
        for arguments in [(), ("frobnicate",), ("run",), ("run", "a.bag", "--threads", "two"), ("maps", ".", "show", "seven"),
                          ("simulate",), ("simulate", "demo")]:
            self.refused(*arguments)
            self.assertEqual(self.exit_code, 2, arguments)
        self.refused("run", "missing.bag")
        self.assertEqual(self.exit_code, 1)

    def test_maps_names_what_it_lacks(self):
        self.assertIn("folder", self.refused("maps"))
        self.assertIn("give a command: list show", self.refused("maps", "."))
        line = self.refused("maps", ".", "foo")
        self.assertIn("there is no command 'foo'; commands are list show", line)
        self.assertIn("mmlins maps --help", line)
        for command in ["show", "export", "delete", "unmerge"]:
            line = self.refused("maps", ".", command)
            self.assertIn("id is required", line)
            self.assertIn(f"mmlins maps . {command} --help", line)
            self.assertIn("not a number: id = seven", self.refused("maps", ".", command, "seven"))

    def test_help_and_version_are_no_errors(self):
        for arguments in [["--help"], ["--version"], *[[command, "--help"] for command in COMMANDS]]:
            with self.subTest(arguments=arguments):
                run = mmlins(*arguments)
                self.assertEqual(run.returncode, 0)
                self.assertEqual(run.stderr, "")
                self.assertTrue(run.stdout.strip())


class Settings(Refusals):
    """Settings are read before the recording, so that no recording is needed here."""

    def test_a_missing_recording_is_named(self):
        for command in ["run", "info"]:
            self.assertIn("missing.bag: no such file", self.refused(command, "missing.bag"))

    def test_missing_settings_are_named(self):
        self.assertIn("no.yaml: no such file", self.refused("run", "a.bag", "--rig", "no.yaml"))
        self.assertIn("no.yaml: no such file", self.refused("run", "a.bag", "--config", "no.yaml"))

    def test_an_unknown_key_is_named_with_line_and_nearest_name(self):
        rig = self.file("rig.yaml", "# sensors\nlidar_topik: /points\n")
        self.assertEqual(self.refused("run", "a.bag", "--rig", rig),
                         f"mmlins: {rig}:2: unknown key lidar_topik; did you mean lidar_topic?")

    def test_a_value_out_of_range_is_named_with_line_and_range(self):
        config = self.file("config.yaml", "output:\n  map_voxel: -1\n")
        line = self.refused("run", "a.bag", "--config", config)
        self.assertIn(f"{config}:2: output.map_voxel is -1, out of range; accepted: a number, 0.01 to 10 m", line)

    def test_text_for_a_number_is_refused(self):
        rig = self.file("rig.yaml", "imu_rate_hz: fast\n")
        self.assertIn(f"{rig}:1: imu_rate_hz is fast; accepted: a number", self.refused("run", "a.bag", "--rig", rig))

    def test_an_extrinsic_rotation_that_is_none_is_refused(self):
        rig = self.file("rig.yaml", "q_imu_lidar_xyzw: [1, 1, 0, 0]\n")
        self.assertIn("q_imu_lidar_xyzw", self.refused("run", "a.bag", "--rig", rig))

    def test_bad_overrides_are_named(self):
        self.assertIn("did you mean output.map_voxel?", self.refused("run", "a.bag", "--set", "output.map_voxl=1"))
        self.assertIn("key=value", self.refused("run", "a.bag", "--set", "output.map_voxel"))

    def test_limits_out_of_order_are_named_with_both_keys_and_values(self):
        leaf = ["--set", "odometry.scan.min_leaf=0.9", "--set", "odometry.scan.max_leaf=0.4"]
        self.assertEqual(self.refused("run", "a.bag", *leaf),
                         "mmlins: config: odometry.scan.min_leaf (0.9 m) must not be above odometry.scan.max_leaf (0.4 m)")
        points = "odometry:\n  map:\n    planes:\n      min_points: 20\n      max_points: 10\n"
        config = self.file("config.yaml", points)
        self.assertEqual(self.refused("run", "a.bag", "--config", config),
                         f"mmlins: {config}: odometry.map.planes.min_points (20) must not be above "
                         "odometry.map.planes.max_points (10)")

    def test_limits_that_are_equal_are_accepted(self):
        equal = ["--set", "odometry.scan.min_leaf=0.4", "--set", "odometry.scan.max_leaf=0.4"]
        self.assertIn("missing.bag: no such file", self.refused("run", "missing.bag", *equal))

    def test_a_recording_given_as_settings_is_refused(self):
        bag = self.folder / "a.bag"
        bag.write_bytes(b"#ROSBAG V2.0\n" + bytes(range(256)))
        self.assertIn("is no text file", self.refused("run", bag, "--config", bag))

    def test_printed_settings_are_accepted(self):
        config = self.file("config.yaml", mmlins("config").stdout)
        rig = self.file("rig.yaml", mmlins("config", "--rig").stdout)
        line = self.refused("run", "missing.bag", "--config", config, "--rig", rig)
        self.assertIn("missing.bag: no such file", line)

    def test_an_unknown_scenario_is_named(self):
        self.assertIn("nowhere_land", self.refused("simulate", "nowhere_land", "--out", "x"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
