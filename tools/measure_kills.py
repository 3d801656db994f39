#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Kills `mmlins run` at random moments and looks at what the atlas still holds.

    tools/measure_kills.py --mmlins PROGRAM RECORDING RIG [--kills 50] [--seed 1]

A watcher reads the last keyframe's time just before the kill; what was committed then must be there afterwards. What
was lost is the time of the recording between the last keyframe of the atlas and the last that an undisturbed run has
written by that wall time (the back end works beside the odometry and may be behind it)."""
import argparse
import pathlib
import random
import sqlite3
import subprocess
import sys
import tempfile
import time

SETTLE = 0.02  # between the last look and the kill [s]


def last_keyframe(folder: pathlib.Path) -> float | None:
    """Time of the recording [s]; none while there is no atlas yet."""
    index = folder / "atlas" / "index.sqlite"
    try:
        with sqlite3.connect(f"file:{index}?mode=ro", uri=True, timeout=1.0) as database:
            (latest,) = database.execute("SELECT max(time_ns) FROM keyframe").fetchone()
    except sqlite3.Error:
        return None
    return None if latest is None else latest * 1e-9


def started(chosen: argparse.Namespace, folder: pathlib.Path) -> subprocess.Popen:
    return subprocess.Popen([chosen.mmlins, "run", chosen.recording, "--rig", chosen.rig, "--out", str(folder)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--mmlins", required=True)
    parser.add_argument("recording")
    parser.add_argument("rig")
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    generator = random.Random(chosen.seed)
    with tempfile.TemporaryDirectory() as work:
        begun = time.monotonic()
        started(chosen, pathlib.Path(work) / "whole").wait()
        whole = time.monotonic() - begun
        opened, gone, kept = 0, [], []
        for kill in range(chosen.kills):
            folder = pathlib.Path(work) / f"kill{kill}"
            process = started(chosen, folder)
            time.sleep(generator.uniform(0.05, 0.95) * whole)
            before = last_keyframe(folder)
            time.sleep(SETTLE)
            process.kill()
            process.wait()
            checked = subprocess.run([chosen.mmlins, "maps", str(folder), "check"], capture_output=True, text=True)
            after = last_keyframe(folder)
            well = checked.returncode == 0 or before is None
            opened += well
            kept.append(after or 0.0)
            gone.append(max(0.0, (before or 0.0) - (after or 0.0)))
            print(f"[{kill + 1}/{chosen.kills}] {'ok' if well else 'DAMAGED'}: {checked.stdout.strip() or checked.stderr.strip()}", flush=True)
        print(f"opened and sound: {opened} of {chosen.kills}; of what had been committed was lost: {max(gone):.3f} s at most")
        sys.exit(0 if opened == chosen.kills and max(gone) == 0.0 else 1)


if __name__ == "__main__":
    main()
