#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The rigs of common sensors in config/rigs: each is accepted, and what it says is what is used."""

import os
import re
import sys
import unittest
from pathlib import Path

from program import mmlins, shared

PRESETS = sorted((Path(__file__).resolve().parents[2] / "config" / "rigs").glob("*.yaml"))
BAG = shared("a/recording.bag")


def values_of(text):
    """Key to numbers or text; the presets and what mmlins writes are flat."""
    values = {}
    for line in text.splitlines():
        key, colon, value = line.split("#")[0].partition(":")
        if not colon:
            continue
        numbers = re.findall(r"[-+]?\d[\d.]*(?:[eE][-+]?\d+)?", value)
        is_number = re.fullmatch(r"[\s\[\],\d.eE+-]*", value) and numbers
        values[key.strip()] = [float(number) for number in numbers] if is_number else value.strip().strip("\"'")
    return values


def setUpModule():
    result = mmlins("simulate", "demo", "--out", os.path.dirname(BAG), "--set", "duration=2", "--set",
                    "trajectory.stand_still=1.5", "--set", "sensor.columns=120")
    assert result.returncode == 0, result.stderr


class Presets(unittest.TestCase):
    def test_there_is_one_for_every_common_sensor(self):
        self.assertEqual([preset.stem for preset in PRESETS],
                         ["hdl32e", "hesai_xt32", "livox_avia", "livox_mid360", "ouster_os1", "robosense_rs16", "vlp16"])

    def test_info_accepts_each(self):
        for preset in PRESETS:
            with self.subTest(preset=preset.stem):
                result = mmlins("info", BAG, "--rig", preset)
                self.assertEqual(result.returncode, 0, result.stderr)

    def test_run_uses_what_each_says_and_the_defaults_for_the_rest(self):
        defaults = values_of(mmlins("config", "--rig").stdout)
        for preset in PRESETS:
            with self.subTest(preset=preset.stem):
                out = Path(shared(preset.stem))
                result = mmlins("run", BAG, "--rig", preset, "--out", out)
                self.assertEqual(result.returncode, 0, result.stderr)
                given = values_of(preset.read_text())
                self.assertTrue({"lidar_model", "min_range", "max_range", "range_noise"} <= set(given), given)
                used = values_of((out / "rig.yaml").read_text())
                topics = {key: used[key] for key in ("lidar_topic", "imu_topic")}
                self.assertEqual(used, {**defaults, **topics, **given})


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
