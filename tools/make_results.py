#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the table of docs/results.md: simulates scenarios, runs them, compares with the truth.

    tools/make_results.py build/release/apps/cli/mmlins [SCENARIO | RECORDING.bag:RIG.yaml:TRUTH.tum ...]

Without arguments: the development and the held-out scenarios. Every run uses one thread and the
default configuration, once with the map of planes and once with the k-nearest-neighbour baseline.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

SCENARIOS = ["dev_hall16", "dev_hall32", "dev_office_mid360", "dev_start_in_motion", "dev_street32",
             "heldout_hall16", "heldout_yard_mid360", "heldout_start_in_motion", "heldout_street32"]


def mmlins(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return done.stdout


def measure(program, bag, rig, truth, kind, folder):
    mmlins(program, "run", bag, "--rig", rig, "--out", folder, "--threads", 1, "--set", f"odometry.map.kind={kind}")
    summary = json.loads((folder / "summary.json").read_text())
    figures = json.loads(mmlins(program, "evaluate", truth, folder / "odometry.tum", "--json"))
    return summary, figures


def rows_of(program, what, work):
    if ":" in what:
        bag, rig, truth = map(pathlib.Path, what.split(":"))
        name = bag.stem
    else:
        name = what
        mmlins(program, "simulate", what, "--out", work / what)
        bag, rig, truth = (work / what / file for file in ("recording.bag", "rig.yaml", "truth.tum"))
    for kind in ("planes", "knn"):
        summary, figures = measure(program, bag, rig, truth, kind, work / f"{name}_{kind}")
        total, stages = summary["stages"]["total"], summary["stages"]
        yield (f"| {name} | {kind} | {summary['path_length_m']:.0f} | {figures['ate_m']['rmse']:.4f} | "
               f"{figures['ate_m']['max']:.3f} | {figures['rotation_deg']['rmse']:.3f} | "
               f"{total['mean_ms']:.2f} / {total['p99_ms']:.1f} | "
               + " / ".join(f"{stages[s]['mean_ms']:.2f}" for s in ("read", "deskew", "downsample", "update", "insert"))
               + f" | {summary['peak_memory_mib']:.0f} |")


def main():
    program, *what = sys.argv[1:]
    print("| recording | map | path [m] | ATE [m] | max [m] | rotation [deg] | ms per scan, mean / p99 | "
          "read / deskew / downsample / update / insert [ms] | peak [MiB] |")
    print("|---|---|---|---|---|---|---|---|---|")
    for one in what or SCENARIOS:
        with tempfile.TemporaryDirectory() as work:
            for row in rows_of(program, one, pathlib.Path(work)):
                print(row, flush=True)


if __name__ == "__main__":
    main()
