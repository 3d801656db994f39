#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Kills `mmlins run` at random moments and looks at what the atlas still holds.

    tools/measure_kills.py --mmlins PROGRAM RECORDING RIG [--kills 50] [--seed 1]

A watcher reads the last keyframe's time just before the kill; what was committed then must be there afterwards. How
far the atlas was behind is told by the scans that the odometry had done (`--progress`) and by the keyframes of an
undisturbed run:

- behind: from the last keyframe in the atlas to the last scan done, in seconds of the recording. Without a kill it
  is up to the time between keyframes, a metre apart;
- missing: from the first keyframe that should be there and is not, to the last scan. These waited for the thread that
  writes, which works beside the odometry. As a run is faster than its recording, also in seconds of real time: that is what
  a robot would lose, on which the recording is no faster than the clock."""
import argparse
import pathlib
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time

SETTLE = 0.02  # between the last look and the kill [s]


def keyframes(folder: pathlib.Path) -> list[int]:
    """Their times [ns]; none while there is no atlas yet."""
    index = folder / "atlas" / "index.sqlite"
    try:
        with sqlite3.connect(f"file:{index}?mode=ro", uri=True, timeout=1.0) as database:
            return [row[0] for row in database.execute("SELECT time_ns FROM keyframe ORDER BY id")]
    except sqlite3.Error:
        return []


def scans_done(folder: pathlib.Path) -> list[int]:
    """Times of the scans whose line is whole [ns]."""
    path = pathlib.Path(f"{folder}.progress")
    lines = path.read_text().split("\n")[:-1] if path.exists() else []
    return [int(line.split()[0].replace(".", "")) for line in lines]


def started(chosen: argparse.Namespace, folder: pathlib.Path) -> subprocess.Popen:
    return subprocess.Popen([chosen.mmlins, "run", chosen.recording, "--rig", chosen.rig, "--out", str(folder),
                             "--progress", f"{folder}.progress"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def losses(expected: list[int], kept: list[int], done: list[int]) -> tuple[float, float]:
    """Seconds of the recording: behind and missing, as above."""
    if not done:
        return 0.0, 0.0
    held = set(kept)
    gone = [stamp for stamp in expected if stamp <= done[-1] and stamp not in held]
    last = kept[-1] if kept else done[0]
    return max(0.0, 1e-9 * (done[-1] - last)), 1e-9 * (done[-1] - gone[0]) if gone else 0.0


def median(values: list[float]) -> float:
    return sorted(values)[len(values) // 2]


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
        reference = pathlib.Path(work) / "whole"
        started(chosen, reference).wait()
        whole = time.monotonic() - begun
        expected, every = keyframes(reference), scans_done(reference)
        rate = 1e-9 * (every[-1] - every[0]) / whole
        opened, uncommitted, behind, missing = 0, [0], [], []
        for kill in range(chosen.kills):
            folder = pathlib.Path(work) / f"kill{kill}"
            process = started(chosen, folder)
            time.sleep(generator.uniform(0.05, 0.95) * whole)
            before = keyframes(folder)
            time.sleep(SETTLE)
            process.kill()
            process.wait()
            checked = subprocess.run([chosen.mmlins, "maps", str(folder), "check"], capture_output=True, text=True)
            after = keyframes(folder)
            well = checked.returncode == 0 or not before
            opened += well
            uncommitted.append(len(set(before) - set(after)))
            loss = losses(expected, after, scans_done(folder))
            behind.append(loss[0])
            missing.append(loss[1])
            shutil.rmtree(folder, ignore_errors=True)
            print(f"[{kill + 1}/{chosen.kills}] {'ok' if well else 'DAMAGED'}: "
                  f"{checked.stdout.strip() or checked.stderr.strip()}; behind {loss[0]:.2f} s, missing {loss[1]:.2f} s", flush=True)
        print(f"opened and sound: {opened} of {chosen.kills}; keyframes lost that had been committed: {max(uncommitted)}")
        print(f"the run is {rate:.1f} times as fast as the recording. Seconds of the recording, median and most: "
              f"behind {median(behind):.2f}, {max(behind):.2f}; missing {median(missing):.2f}, {max(missing):.2f}. "
              f"In real time: missing {median(missing) / rate:.2f}, {max(missing) / rate:.2f}")
        sys.exit(0 if opened == chosen.kills and max(uncommitted) == 0 else 1)


if __name__ == "__main__":
    main()
