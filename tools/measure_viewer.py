#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures mmlins view in headless Chromium: time until something, and until everything, is shown; pictures per second
while the camera goes round; and the odometry's time per scan with and without --view in alternating runs.

  cmake --build build/release --target make_large_run
  build/python/bin/python3 tools/measure_viewer.py                        # 1, 5 and 20 million points
  build/python/bin/python3 tools/measure_viewer.py --run RECORDING.bag --rig rig.yaml
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/cli"))
import chromium  # noqa: E402

# Goes round for some seconds; what it took from one picture to the next [ms], and points in each.
ROUND = """(seconds) => new Promise((done) => {
  const { stage, cloud } = mmlins, { camera, controls } = stage, times = [], drawn = [];
  const begin = performance.now();
  let last = begin;
  const turn = (now) => {
    const x = camera.position.x - controls.target.x, y = camera.position.y - controls.target.y, a = 0.02;
    camera.position.x = controls.target.x + x * Math.cos(a) - y * Math.sin(a);
    camera.position.y = controls.target.y + x * Math.sin(a) + y * Math.cos(a);
    stage.moved();
    times.push(now - last); drawn.push(cloud.drawn); last = now;
    if (now - begin < 1000 * seconds) requestAnimationFrame(turn); else done([times.slice(10), drawn.slice(10)]);
  };
  requestAnimationFrame(turn);
})"""
CLOSE = """() => { const { stage } = mmlins, t = stage.controls.target;
  stage.moveCamera(t.clone().add({x: -45, y: 0, z: 25}), t.clone(), true); }"""


def until(page, condition, limit=300):
    begin = time.monotonic()
    while not page.evaluate(condition):
        if time.monotonic() - begin > limit:
            raise SystemExit(f"never: {condition}")
        page.wait_for_timeout(20)
    return time.monotonic()


def memory_mb(pid):
    return int(re.search(r"VmHWM:\s+(\d+)", Path(f"/proc/{pid}/status").read_text()).group(1)) / 1024


def cpu_seconds(pid):
    """Of a process and all that descend from it."""
    stats = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        stats[int(path.parent.name)] = (int(fields[1]), (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"))
    family, size = {pid}, 0
    while len(family) > size:
        size = len(family)
        family |= {child for child, (parent, _) in stats.items() if parent in family}
    return sum(seconds for child, (_, seconds) in stats.items() if child in family)


def round_trip(page):
    """Pictures per second, the time within which 95 % came, points in each, and the processors' time for one [ms]."""
    before = cpu_seconds(os.getpid())
    times, drawn = page.evaluate(ROUND, 8)
    work = cpu_seconds(os.getpid()) - before
    return 1000 * len(times) / sum(times), sorted(times)[int(0.95 * len(times))], statistics.mean(drawn), 1000 * work / (len(times) + 10)


def show(trip):
    return f"{trip[0]:.0f} ({trip[1]:.0f}) | {trip[2] / 1e3:.0f} k | {trip[3]:.0f}"


def measure_folder(arguments, folder, browser):
    server = subprocess.Popen([arguments.mmlins, "view", folder, "--no-browser"], stdout=subprocess.PIPE, text=True)
    url = re.search(r"http://\S+/", server.stdout.readline()).group()
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    begin = time.monotonic()
    page.goto(url)
    first = until(page, "Boolean(window.mmlins?.scene && mmlins.cloud.drawn > 0)") - begin
    coarse = until(page, "mmlins.cloud.isCoarse") - begin
    rest = until(page, "mmlins.cloud.isComplete && mmlins.stage.isAtRest") - begin
    total = page.evaluate("mmlins.cloud.numPoints")
    far = round_trip(page)
    page.evaluate(CLOSE)
    until(page, "mmlins.cloud.isComplete && mmlins.stage.isAtRest")
    near = round_trip(page)
    until(page, "mmlins.cloud.isComplete && mmlins.stage.isAtRest")
    still = page.evaluate("mmlins.cloud.drawn")
    print(f"| {total / 1e6:.0f} M | {first:.1f} | {coarse:.1f} | {rest:.1f} | {cpu_seconds(server.pid):.1f} | {memory_mb(server.pid):.0f} | "
          f"{show(far)} | {show(near)} | {still / 1e6:.2f} M |", flush=True)
    page.close()
    server.terminate()
    server.wait()


def measure_sizes(arguments):
    from playwright.sync_api import sync_playwright
    maker = str(ROOT / "build/release/tests/make_large_run")
    print("| points | first shown [s] | all, coarse [s] | at its best [s] | server: work [s] | memory [MB] | "
          "turning, all in view [1/s] (95 % within [ms]) | points drawn | work for one [ms] | "
          "turning, close [1/s] | points drawn | work for one [ms] | points at rest |\n" + "|---" * 13 + "|")
    with sync_playwright() as driver, tempfile.TemporaryDirectory() as folder:
        for millions in arguments.millions:
            place = os.path.join(folder, f"large_{millions}")
            os.makedirs(place)
            subprocess.run([maker, place, str(millions)], check=True)
            browser = driver.chromium.launch(executable_path=chromium.CHROMIUM, args=chromium.ARGUMENTS)
            measure_folder(arguments, place, browser)
            browser.close()


def run_once(arguments, out, watch):
    command = [arguments.mmlins, "run", arguments.run, "--out", out, *(["--rig", arguments.rig] if arguments.rig else [])]
    if watch == "plain":
        subprocess.run(command, check=True, capture_output=True)
    else:
        run = subprocess.Popen([*command, "--view", "--view-exit", "--no-browser"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        url = re.search(r"http://\S+/", run.stdout.readline()).group()
        client = subprocess.Popen([sys.executable, __file__, "--client", url]) if watch == "client" else None
        run.communicate()
        if client:
            client.kill()
            client.wait()
    with open(os.path.join(out, "summary.json")) as file:
        return json.load(file)


def measure_runs(arguments):
    """Alternating, as the machine may be busier now than then."""
    results = {"plain": [], "view": [], "client": []}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.rounds):
            for watch, list_of in results.items():
                list_of.append(run_once(arguments, os.path.join(folder, watch), watch))
    print("| | ms per scan, mean (median, p99) | whole run [s] | memory [MiB] |\n|---|---|---|---|")
    for watch, name in (("plain", "without --view"), ("view", "--view, nobody looks on"), ("client", "--view, a client that takes everything")):
        total = [summary["stages"]["total"] for summary in results[watch]]
        median = lambda values: statistics.median(values)
        print(f"| {name} | {median([t['mean_ms'] for t in total]):.2f} ({median([t['median_ms'] for t in total]):.2f}, {median([t['p99_ms'] for t in total]):.1f}) | "
              f"{median([s['wall_s'] for s in results[watch]]):.1f} | {median([s['peak_memory_mib'] for s in results[watch]]):.0f} |")


def be_client(url):
    """Takes all news and every tile, as a page does, but draws nothing."""
    import urllib.request
    sys.argv = [sys.argv[0]]
    from run_view_test import Listener
    got = set()
    for message in Listener(int(re.search(r":(\d+)/", url).group(1))).messages():
        for _, first, last, _ in message.get("atlas", {}).get("blocks", []):
            for level in range(5):
                if (first, last, level) in got:
                    continue
                got.add((first, last, level))
                urllib.request.urlopen(f"{url}api/tiles/{first}-{last}/{level}").read()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mmlins", default=str(ROOT / "build/release/apps/cli/mmlins"))
    parser.add_argument("--millions", type=float, nargs="+", default=[1, 5, 20])
    parser.add_argument("--run", help="a recording: measure runs of it instead")
    parser.add_argument("--rig")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--client", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.client:
        be_client(arguments.client)
    elif arguments.run:
        measure_runs(arguments)
    else:
        measure_sizes(arguments)


if __name__ == "__main__":
    main()
