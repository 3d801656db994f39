#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""mmlins config prints every setting, and the commands accept what it prints."""

import sys
import unittest

from program import mmlins


class Config(unittest.TestCase):
    def check_settings(self, *arguments):
        """Every key of the printed YAML stands below a comment."""
        run = mmlins("config", *arguments)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(run.stderr, "")
        lines = run.stdout.splitlines()
        keys = [i for i, line in enumerate(lines) if line.strip() and not line.strip().startswith("#")]
        for i in keys:
            self.assertIn(":", lines[i])
            self.assertTrue(lines[i - 1].strip().startswith("# "), f"no comment above: {lines[i]}")
        for line in lines:
            self.assertLessEqual(len(line), 120, line)
        return run.stdout

    def test_the_method_is_printed_with_comments_and_ranges(self):
        text = self.check_settings()
        self.assertIn("odometry:\n", text)
        self.assertRegex(text, r"# .*\[[0-9.]+ to [0-9.]+ m\]\n *[a-z_]+: [0-9.]+\n")

    def test_the_rig_is_printed_with_every_documented_key(self):
        text = self.check_settings("--rig")
        for key in ["lidar_model", "lidar_topic", "imu_topic", "p_imu_lidar", "q_imu_lidar_xyzw", "imu_rate_hz",
                    "gyro_noise_density", "accel_noise_density", "gyro_bias_walk", "accel_bias_walk"]:
            self.assertRegex(text, rf"(?m)^{key}: ")

    def test_the_same_text_every_time(self):
        self.assertEqual(mmlins("config").stdout, mmlins("config").stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
