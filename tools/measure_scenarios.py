#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Says what odometry makes of the scenarios, and fills the tables of docs/scenarios.md.

    tools/measure_scenarios.py --cache FOLDER --mmlins PROGRAM [--simulator PROGRAM] [--again] [NAME | GLOB ...]
    tools/measure_scenarios.py --cache FOLDER --write

Every scenario is simulated twice, as it is and without its events, run with one thread and compared with
the truth. An event that begins after another one has already broken the odometry is measured once more, in
a recording in which it is the only one. Results are kept in the cache, one JSON for each scenario, so that
a long catalogue can be measured in pieces; scenarios that have not changed since, comments aside, are not
measured again by the same program. --write puts what the cache holds into the documentation and into the
comments of the scenarios.
"""
import argparse
import csv
import fnmatch
import hashlib
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap
import time
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENARIOS = ROOT / "config" / "scenarios"
PAGE = ROOT / "docs" / "scenarios.md"
AFTER = 5.0  # drift is looked at again this long after an event [s]
BEFORE = 2.0  # and over this time before it, to see whether the odometry was still sound [s]
SOUND = 0.1  # drift over BEFORE of an odometry that is sound [m]
MARKS = ("<!-- measured: begin (tools/measure_scenarios.py) -->", "<!-- measured: end -->")

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]  # x y z w


class Pose(NamedTuple):
    time: float
    p: Vector
    q: Quaternion


class Programs(NamedTuple):
    mmlins: str
    simulator: str
    identity: str  # of the program that is measured


# ---- poses


def rotate(q: Quaternion, v: Vector) -> Vector:
    x, y, z, w = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


def read_tum(path: pathlib.Path) -> list[Pose]:
    rows = [tuple(map(float, line.split())) for line in path.read_text().splitlines() if not line.startswith("#")]
    return [Pose(row[0], row[1:4], row[4:8]) for row in rows]


def pose_at(poses: list[Pose], stamp: float) -> Pose:
    """Between two poses in proportion; before the first and after the last one, those."""
    low, high = 0, len(poses) - 1
    if stamp <= poses[0].time:
        return poses[0]
    if stamp >= poses[-1].time:
        return poses[-1]
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if poses[middle].time <= stamp else (low, middle)
    a, b = poses[low], poses[high]
    share = (stamp - a.time) / (b.time - a.time)
    sign = 1.0 if sum(u * v for u, v in zip(a.q, b.q)) >= 0.0 else -1.0
    q = [(1.0 - share) * u + sign * share * v for u, v in zip(a.q, b.q)]
    norm = math.sqrt(sum(u * u for u in q))
    return Pose(stamp, tuple(u + share * (v - u) for u, v in zip(a.p, b.p)), tuple(u / norm for u in q))


def motion(poses: list[Pose], start: float, end: float) -> Vector:
    """Where the later pose is, seen from the earlier one [m]."""
    a, b = pose_at(poses, start), pose_at(poses, end)
    conjugate = (-a.q[0], -a.q[1], -a.q[2], a.q[3])
    return rotate(conjugate, tuple(v - u for u, v in zip(a.p, b.p)))


def drift(truth: list[Pose], odometry: list[Pose], start: float, end: float) -> float:
    return math.dist(motion(truth, start, end), motion(odometry, start, end))


def path_length(poses: list[Pose], start: float, end: float) -> float:
    inside = [pose.p for pose in poses if start <= pose.time <= end]
    return sum(math.dist(a, b) for a, b in zip(inside, inside[1:]))


# ---- scenarios


def essence_of(text: str) -> str:
    """The scenario without its comments."""
    return "\n".join(line for line in text.splitlines() if line and not line.startswith("#"))


def twin_of(essence: str) -> str:
    """The scenario without its events: the same for all that differ in nothing else."""
    return re.sub(r"^events:.*\n?(^[ -].*\n?)*", "", essence, flags=re.MULTILINE)


def fingerprint(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def model_of(text: str, group: str) -> str:
    found = re.search(rf"^{group}: {{(?:[^}}]*, )?model: (\w+)", text, flags=re.MULTILINE)
    return found[1] if found else "default"


# ---- measuring


def call(program: str, *arguments: object) -> str:
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{program} {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return done.stdout


def read_events(path: pathlib.Path, origin: float) -> list[dict]:
    rows = list(csv.DictReader(path.open()))
    return [{"kind": row["kind"], "start_s": float(row["start"]) - origin, "end_s": float(row["end"]) - origin,
             "severity": float(row["severity"])} for row in rows]


def judged(event: dict, truth: list[Pose], odometry: list[Pose]) -> dict:
    """The event with what the odometry made of it."""
    origin = truth[0].time
    start, end = origin + event["start_s"], origin + event["end_s"]
    after = min(end + AFTER, odometry[-1].time)
    figures = {"path_m": path_length(truth, start, end), "path_after_m": path_length(truth, start, after),
               "drift_before_m": drift(truth, odometry, max(start - BEFORE, odometry[0].time), start),
               "drift_end_m": drift(truth, odometry, start, end),
               "drift_after_m": drift(truth, odometry, start, after)}
    return event | figures


def verdict(event: dict) -> str:
    left = event["drift_after_m"]
    if left >= 1.0:
        return "lost" if left >= 10.0 else "broken"
    return "harmless" if left < 0.1 and left < 0.005 * event["path_after_m"] else "noticeable"


def measured(programs: Programs, name: str, overrides: list[str]) -> dict:
    """Simulates, runs, compares; nothing of the recording is kept."""
    with tempfile.TemporaryDirectory(prefix="measure_") as work:
        made, out = pathlib.Path(work) / "made", pathlib.Path(work) / "out"
        settings = [word for override in overrides for word in ("--set", override)]
        call(programs.simulator, "simulate", SCENARIOS / f"{name}.yaml", "--out", made, *settings)
        bag, rig, truth_file, estimate = (made / "recording.bag", made / "rig.yaml", made / "truth.tum",
                                          out / "odometry.tum")
        call(programs.mmlins, "run", bag, "--rig", rig, "--out", out, "--threads", 1)
        figures = json.loads(call(programs.mmlins, "evaluate", truth_file, estimate, "--json"))
        summary = json.loads((out / "summary.json").read_text())
        truth, odometry = read_tum(truth_file), read_tum(estimate)
        events = read_events(made / "events.csv", truth[0].time)
        return {"path_m": figures["path_length_m"], "duration_s": figures["duration_s"],
                "ate_m": figures["ate_m"]["rmse"], "ate_max_m": figures["ate_m"]["max"],
                "end_to_end_m": figures["end_to_end"]["translation_m"], "states": summary["scans_by_state"],
                "events": [judged(event, truth, odometry) for event in events]}


def measured_alone(programs: Programs, name: str, event: dict) -> dict:
    duration = event["end_s"] - event["start_s"]
    only = (f"events=[{{kind: {event['kind']}, start: {event['start_s']:.6f}, duration: {duration:.6f}, "
            f"severity: {event['severity']}}}]")
    return measured(programs, name, [only])["events"][0] | {"alone": True}


def load(path: pathlib.Path, identity: str) -> dict | None:
    kept = json.loads(path.read_text()) if path.exists() else {}
    return kept if kept.get("identity") == identity else None


def keep(path: pathlib.Path, figures: dict) -> None:
    scratch = path.with_suffix(".part")
    scratch.write_text(json.dumps(figures, indent=1) + "\n")
    scratch.replace(path)


def measure(programs: Programs, name: str, cache: pathlib.Path, again: bool) -> dict:
    essence = essence_of((SCENARIOS / f"{name}.yaml").read_text())
    identity = fingerprint(programs.identity, essence)
    if not again and (kept := load(cache / f"{name}.json", identity)):
        return kept
    twin_identity = fingerprint(programs.identity, twin_of(essence))
    twin_path = cache / "twins" / f"{twin_identity}.json"
    twin = None if again else load(twin_path, twin_identity)
    if twin is None:
        twin = measured(programs, name, ["events=[]"]) | {"identity": twin_identity}
        keep(twin_path, twin)
    figures = {"name": name, "identity": identity, "scenario": fingerprint(essence), "twin": twin, "with": None}
    if essence != twin_of(essence):
        figures["with"] = measured(programs, name, [])
        events = figures["with"]["events"]
        if len(events) > 1:
            events[:] = [measured_alone(programs, name, event) if event["drift_before_m"] > SOUND else event
                         for event in events]
    keep(cache / f"{name}.json", figures)
    return figures


# ---- writing


def metres(value: float) -> str:
    return f"{value:.3f}" if value < 0.1 else f"{value:.2f}" if value < 10.0 else f"{value:.0f}"


def event_words(event: dict) -> str:
    severity = "" if event["kind"] in ("blackout", "packet_loss") else f" {event['severity']:g}"
    return f"`{event['kind']}`{severity}, {event['end_s'] - event['start_s']:g} s"


def scenario_row(figures: dict) -> str:
    text = (SCENARIOS / f"{figures['name']}.yaml").read_text()
    twin, spoilt = figures["twin"], figures["with"]
    states = (spoilt or twin)["states"]
    ate_spoilt = metres(spoilt["ate_m"]) if spoilt else ""
    return (f"| `{figures['name']}` | {model_of(text, 'sensor')}, {model_of(text, 'imu')} | "
            f"{twin['path_m']:.0f} m, {twin['duration_s']:.0f} s | {metres(twin['ate_m'])} | {ate_spoilt} | "
            f"{states['DEGRADED']} / {states['BRIDGING']} of {sum(states.values())} |")


def event_row(name: str, event: dict) -> str:
    note = " *" if event.get("alone") else ""
    return (f"| `{name}` | {event['start_s']:.0f} s{note} | {event_words(event)} | "
            f"{event['path_m']:.0f} m | {metres(event['drift_end_m'])} | "
            f"{metres(event['drift_after_m'])} | {verdict(event)} |")


def count_line(what: str, events: list[dict]) -> str:
    words = [verdict(event) for event in events]
    counts = ", ".join(f"{words.count(word)} {word}" for word in ("harmless", "noticeable", "broken", "lost"))
    share = sum(word in ("broken", "lost") for word in words) / max(1, len(words))
    return f"| {what} | {len(words)} | {counts} | {100.0 * share:.0f} % |"


def tables(catalogue: list[dict]) -> list[str]:
    events = [(figures["name"], event) for figures in catalogue if figures["with"]
              for event in figures["with"]["events"]]
    held_out = [event for name, event in events if name.startswith("heldout")]
    others = [event for name, event in events if not name.startswith("heldout")]
    lines = ["| set | events | of which | broken or lost |", "|---|---|---|---|",
             count_line("development", others), count_line("held out", held_out), ""]
    lines += ["| scenario | sensor, IMU | path | ATE without events [m] | with events [m] | "
              "DEGRADED / BRIDGING scans |", "|---|---|---|---|---|---|",
              *map(scenario_row, catalogue), ""]
    lines += ["| scenario | begins at | event | path in it | drift at its end [m] | 5 s later [m] | |",
              "|---|---|---|---|---|---|---|", *(event_row(name, event) for name, event in events)]
    return lines


def write_page(catalogue: list[dict], left_out: list[str]) -> None:
    before, rest = PAGE.read_text().split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    lines = tables(catalogue)
    if left_out:
        lines += ["", f"Not in these tables: {', '.join(f'`{name}`' for name in left_out)}."]
    PAGE.write_text("\n".join([before + MARKS[0], *lines, MARKS[1]]) + after)


def comment_of(figures: dict) -> list[str]:
    twin, spoilt = figures["twin"], figures["with"]
    words = f"ATE {metres(twin['ate_m'])} m."
    if spoilt:
        parts = [f"{event['kind']} at {event['start_s']:.0f} s {verdict(event)} "
                 f"({metres(event['drift_after_m'])} m)" for event in spoilt["events"]]
        words = f"{'; '.join(parts)}; ATE {metres(spoilt['ate_m'])} m, {metres(twin['ate_m'])} m without events."
    return textwrap.wrap("Plain odometry: " + words, 105, initial_indent="# ", subsequent_indent="#   ")


def write_comment(figures: dict) -> None:
    path = SCENARIOS / f"{figures['name']}.yaml"
    lines = path.read_text().splitlines()
    size = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    head = [line for line in lines[:size] if not re.match(r"#   |# (What p|P)lain odometry|# What plain", line)]
    path.write_text("\n".join([*head, *comment_of(figures), *lines[size:]]) + "\n")


# ---- the command


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--mmlins", help="the program to measure")
    parser.add_argument("names", nargs="*", help="scenarios, or patterns like 'dev_*'; none: all of them")
    parser.add_argument("--simulator", help="another mmlins, to make the recordings with")
    parser.add_argument("--cache", type=pathlib.Path, required=True, help="folder of the figures")
    parser.add_argument("--again", action="store_true", help="measure also what the cache holds")
    parser.add_argument("--write", action="store_true", help="put all figures into the documentation")
    return parser.parse_args()


def names_of(patterns: list[str]) -> list[str]:
    names = sorted(path.stem for path in SCENARIOS.glob("*.yaml"))
    wanted = patterns or ["dev_*", "heldout_*"]
    chosen = [name for name in names if any(fnmatch.fnmatch(name, pattern) for pattern in wanted)]
    return chosen or sys.exit(f"no scenario is called {' or '.join(patterns)}")


def line_of(figures: dict) -> str:
    spoilt = figures["with"]
    line = f"ATE {metres(figures['twin']['ate_m'])} m"
    if spoilt is None:
        return line
    words = [f"{event['kind']} {metres(event['drift_end_m'])} -> {metres(event['drift_after_m'])} {verdict(event)}"
             for event in spoilt["events"]]
    return f"{line}, with events {metres(spoilt['ate_m'])} m: {'; '.join(words)}"


def measure_all(chosen: argparse.Namespace) -> None:
    program = pathlib.Path(chosen.mmlins)
    identity = hashlib.sha256(program.read_bytes()).hexdigest()
    programs = Programs(str(program), chosen.simulator or str(program), identity)
    names = names_of(chosen.names)
    for number, name in enumerate(names, 1):
        begun = time.monotonic()
        print(f"[{number}/{len(names)}] {name} ...", end=" ", flush=True)
        line = line_of(measure(programs, name, chosen.cache, chosen.again))
        print(f"{time.monotonic() - begun:.0f} s: {line}", flush=True)


def write_all(cache: pathlib.Path) -> None:
    catalogue, left_out = [], []
    for name in names_of([]):
        path = cache / f"{name}.json"
        figures = json.loads(path.read_text()) if path.exists() else {}
        if figures.get("scenario") == fingerprint(essence_of((SCENARIOS / f"{name}.yaml").read_text())):
            catalogue.append(figures)
        else:
            left_out.append(name)
            print(f"{name} is left out: {'it has changed since' if figures else 'not measured yet'}")
    write_page(catalogue, left_out)
    for figures in catalogue:
        write_comment(figures)


def main() -> None:
    chosen = options()
    for program in filter(None, (chosen.mmlins, chosen.simulator)):
        if not pathlib.Path(program).is_file():
            sys.exit(f"{program}: there is no such program; build it with scripts/build, or name another")
    (chosen.cache / "twins").mkdir(parents=True, exist_ok=True)
    if chosen.mmlins:
        measure_all(chosen)
    if chosen.write:
        write_all(chosen.cache)


if __name__ == "__main__":
    main()
