#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures whether odometry knows when it is lost, says so, and starts again; fills docs/results/degeneracy.md.

    tools/measure_degeneracy.py --cache FOLDER --mmlins PROGRAM [--only free,restart] [--seeds 1,2] [NAME | GLOB ...]
    tools/measure_degeneracy.py --cache FOLDER --mmlins PROGRAM --measured --write

Every item's figures are kept in the cache, one JSON each, and are not measured again by the same program: so it
can be done in pieces. --plain names the program of before, for comparison; --recordings keeps what was simulated.
"""
import argparse
import fnmatch
import pathlib
import re
import sys
import time

from degeneracy import bag_map, cold, events, free, recorded, restart, soft
from degeneracy.bench import Bench, Item, Section, Wanted, all_figures, digest, figures_of

SECTIONS = {"events": events.SECTION, "free": free.SECTION, "restart": restart.SECTION, "cold": cold.SECTION,
            "soft": soft.SECTION, "bag": bag_map.SECTION, "recorded": recorded.SECTION}
PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs" / "results" / "degeneracy.md"


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("names", nargs="*", help="items, or patterns like 'dev_*'; none: all of them")
    parser.add_argument("--mmlins", help="the program to measure")
    parser.add_argument("--simulator", help="another mmlins, to make the recordings with")
    parser.add_argument("--plain", help="the program of before, for comparison")
    parser.add_argument("--cache", type=pathlib.Path, required=True, help="folder of the figures")
    parser.add_argument("--catalogue", type=pathlib.Path, help="the cache of measure_scenarios.py")
    parser.add_argument("--recordings", type=pathlib.Path, help="folder to keep the simulated recordings in")
    parser.add_argument("--recording", action="append", default=[], metavar="BAG:RIG:TRUTH:START:END",
                        help="one that was not simulated, blind from START to END [s]; may be repeated")
    parser.add_argument("--only", default=",".join(SECTIONS), help="what to measure")
    parser.add_argument("--methods", default="default", help="detectors and ways to start, and `plain`")
    parser.add_argument("--seeds", default="1", help="of the noise")
    parser.add_argument("--again", action="store_true", help="measure also what the cache holds")
    parser.add_argument("--measured", action="store_true", help="measure nothing: --write what the cache holds of --mmlins")
    parser.add_argument("--write", action="store_true", help="put all figures into the documentation")
    return parser.parse_args()


def measure_section(name: str, section: Section, bench: Bench, chosen: argparse.Namespace, wanted: Wanted) -> None:
    folder = chosen.cache / name
    folder.mkdir(parents=True, exist_ok=True)
    items = [item for item in section.items(wanted) if is_wanted(item, wanted.names)]
    for number, item in enumerate(items, 1):
        begun = time.monotonic()
        figures = figures_of(bench, item, section.measure, folder, chosen.again)
        words = f"FAILED: {figures['failed']}" if "failed" in figures else section.line(figures)
        print(f"[{name} {number}/{len(items)}] {item.name} {time.monotonic() - begun:.0f} s: {words}", flush=True)


def is_wanted(item: Item, patterns: list[str]) -> bool:
    return not patterns or any(fnmatch.fnmatch(item.name, pattern) for pattern in patterns)


def write_page(cache: pathlib.Path, program: str | None) -> None:
    """Of one program, if it is given; what has been measured with others stays in the cache."""
    text = PAGE.read_text()
    for name, section in SECTIONS.items():
        figures = [f for f in all_figures(cache / name)
                   if program is None or f["method"] == "plain" or f["program"] == digest(program)]
        if not figures:
            print(f"{name} is left as it is: nothing was measured")
            continue
        if len({f["program"] for f in figures if f["method"] != "plain"}) > 1:
            print(f"{name}: figures of several programs", file=sys.stderr)
        begin, end = f"<!-- {name}: begin (tools/measure_degeneracy.py) -->", f"<!-- {name}: end -->"
        table = "\n".join([begin, *section.table(figures, cache), end])
        text = re.sub(re.escape(begin) + ".*?" + re.escape(end), lambda _: table, text, flags=re.DOTALL)
    PAGE.write_text(text)


def main() -> None:
    chosen = options()
    names = chosen.only.split(",")
    if unknown := set(names) - set(SECTIONS):
        sys.exit(f"--only: there is no {', '.join(sorted(unknown))}; there are {', '.join(SECTIONS)}")
    for program in filter(None, (chosen.mmlins, chosen.simulator, chosen.plain)):
        if not pathlib.Path(program).is_file():
            sys.exit(f"{program}: there is no such program; build it with scripts/build, or name another")
    if chosen.recordings:
        chosen.recordings.mkdir(parents=True, exist_ok=True)
    wanted = Wanted(chosen.methods.split(","), [int(seed) for seed in chosen.seeds.split(",")], chosen.names,
                    chosen.recording, chosen.catalogue)
    if chosen.mmlins and not chosen.measured:
        bench = Bench(chosen.mmlins, chosen.simulator or chosen.mmlins, chosen.plain, chosen.recordings)
        for name in names:
            measure_section(name, SECTIONS[name], bench, chosen, wanted)
    if chosen.write:
        write_page(chosen.cache, chosen.mmlins)


if __name__ == "__main__":
    main()
