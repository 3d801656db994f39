#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""mmlins evaluate against evo (pip install evo), the tool everybody uses, on the same files."""

import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from program import mmlins

try:
    import numpy as np
except ImportError:
    np = None

SKIPPED = 77

# Runs in whichever interpreter has evo; prints the figures of two files as JSON.
EVO_FIGURES = """
import copy, json, sys
from evo.core import metrics
from evo.core.units import Unit
from evo.tools import file_interface
truth = file_interface.read_tum_trajectory_file(sys.argv[1])
estimate = file_interface.read_tum_trajectory_file(sys.argv[2])
if sys.argv[3] == "se3":
    estimate.align(truth)
def figures(metric):
    metric.process_data((truth, copy.deepcopy(estimate)))
    return metric.get_all_statistics()
relation = metrics.PoseRelation
def rpe(which):
    return figures(metrics.RPE(which, delta=10, delta_unit=Unit.frames, all_pairs=True))
print(json.dumps({
    "ate_m": figures(metrics.APE(relation.translation_part)),
    "rotation_deg": figures(metrics.APE(relation.rotation_angle_deg)),
    "rpe_translation_m": rpe(relation.translation_part),
    "rpe_rotation_deg": rpe(relation.rotation_angle_deg)}))
"""


def python_with_evo():
    """An interpreter that can import evo, or None."""
    for python in [sys.executable, shutil.which("python3")]:
        probe = [python, "-c", "import evo.core.metrics, evo.tools.file_interface"]
        if python and subprocess.run(probe, capture_output=True).returncode == 0:
            return python
    return None


def write_tum(path, stamps, positions, quaternions):
    rows = [f"{ns // 10**9}.{ns % 10**9:09d} " + " ".join(f"{x:.12f}" for x in [*p, *q])
            for ns, p, q in zip(stamps, positions, quaternions)]
    Path(path).write_text("# time x y z qx qy qz qw\n" + "\n".join(rows) + "\n")


def random_trajectories(folder, seed, noise):
    """A smooth random path, ten poses a second, and a noisy copy of it in another frame."""
    rng = np.random.default_rng(seed)

    def multiply(a, b):
        v = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
        return np.append(v, a[3] * b[3] - a[:3] @ b[:3])

    def from_vector(w):
        angle = np.linalg.norm(w)
        return np.append(np.sin(angle / 2) * w / angle, np.cos(angle / 2))

    def rotate(q, v):
        return v + 2 * np.cross(q[:3], np.cross(q[:3], v) + q[3] * v)

    stamps, truth, estimate = [], [], []
    q, p, velocity, rate = from_vector(rng.normal(size=3)), rng.normal(size=3), np.zeros(3), np.zeros(3)
    frame_q, frame_p = from_vector(rng.normal(size=3)), 100 * rng.normal(size=3)
    for i in range(800):
        velocity = 0.95 * velocity + rng.normal(size=3)
        rate = 0.9 * rate + 0.1 * rng.normal(size=3)
        p, q = p + 0.1 * velocity, multiply(q, from_vector(0.1 * rate + 1e-12))
        q = q / np.linalg.norm(q)
        noisy_q = multiply(q, from_vector(noise * rng.normal(size=3)))
        stamps.append(1700000000000000000 + 100000000 * i)
        truth.append((p, q))
        estimate.append((rotate(frame_q, p + noise * rng.normal(size=3)) + frame_p, multiply(frame_q, noisy_q)))
    write_tum(folder / "truth.tum", stamps, *zip(*truth))
    write_tum(folder / "estimate.tum", stamps, *zip(*estimate))


def evaluate(*arguments):
    return mmlins("evaluate", *arguments)


class AgainstEvo(unittest.TestCase):
    def compare(self, ours, theirs, tolerance):
        for name in ["rmse", "mean", "median", "max", "std"]:
            self.assertAlmostEqual(ours[name], theirs[name], delta=tolerance, msg=name)

    def test_all_figures_agree(self):
        for seed, (noise, align) in enumerate([(0.01, "se3"), (0.3, "se3"), (0.05, "none")]):
            with self.subTest(seed=seed), tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                random_trajectories(folder, seed, noise)
                files = [folder / "truth.tum", folder / "estimate.tum"]
                run = subprocess.run([python_with_evo(), "-c", EVO_FIGURES, *map(str, files), align],
                                     capture_output=True, text=True)
                self.assertEqual(run.returncode, 0, run.stderr)
                theirs = json.loads(run.stdout)
                ours = json.loads(evaluate(*files, "--align", align, "--json").stdout)
                self.compare(ours["ate_m"], theirs["ate_m"], 1e-6)
                self.compare(ours["rotation_deg"], theirs["rotation_deg"], 1e-5)
                self.compare(ours["rpe_1s"]["translation_m"], theirs["rpe_translation_m"], 1e-6)
                self.compare(ours["rpe_1s"]["rotation_deg"], theirs["rpe_rotation_deg"], 1e-5)


def main():
    missing = "numpy" if np is None else None if python_with_evo() else "evo (pip install evo)"
    if missing:
        print(f"skipped: {missing} is not installed, nothing to compare with")
        return SKIPPED
    return 0 if unittest.main(argv=sys.argv[:1], exit=False).result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
