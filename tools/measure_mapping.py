#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures whether loops are closed and maps are joined, rightly and well; fills docs/results/mapping.md.

    tools/measure_mapping.py --cache FOLDER --mmlins PROGRAM [--only merges,decoys] [--seeds 1,2] [NAME | GLOB ...]
    tools/measure_mapping.py --cache FOLDER --mmlins PROGRAM --measured --write

Every item's figures are kept in the cache, one JSON each, and are not measured again by the same program: so it
can be done in pieces. --recordings keeps what was simulated; --suspects keeps runs in which something was false, or
the trajectory became worse than the odometry. Needs numpy, and for recordings that end where they begin, scipy.
"""
import argparse
import pathlib
import re
import sys

from degeneracy.bench import Bench, Wanted, all_figures, digest
from mapping_measures import benchmarks, constraints, decoys, gaps, loops, merges, real
from mapping_measures.common import METHODS
from measure_degeneracy import measure_section

SECTIONS = {"loops": loops.SECTION, "merges": merges.SECTION, "decoys": decoys.SECTION, "gaps": gaps.SECTION,
            "constraints": constraints.SECTION, "real": real.SECTION, "recognition": benchmarks.RECOGNITION,
            "graphs": benchmarks.GRAPH}
PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs" / "results" / "mapping.md"


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("names", nargs="*", help="items, or patterns like 'dev_*'; none: all of them")
    parser.add_argument("--mmlins", required=True, help="the program to measure")
    parser.add_argument("--simulator", help="another mmlins, to make the recordings with")
    parser.add_argument("--benchmarks", type=pathlib.Path, help="the folder of bench_place and bench_graph")
    parser.add_argument("--cache", type=pathlib.Path, required=True, help="folder of the figures")
    parser.add_argument("--recordings", type=pathlib.Path, help="folder to keep the simulated recordings in")
    parser.add_argument("--suspects", type=pathlib.Path, help="folder to keep the runs in that look wrong")
    parser.add_argument("--recording", action="append", default=[], metavar="NAME=BAG,RIG,TRUTH[,EVENT...] | FILE.g2o",
                        help="one that was not simulated; may be repeated")
    parser.add_argument("--only", default=",".join(SECTIONS), help="what to measure")
    parser.add_argument("--methods", default="default", help=", ".join(METHODS))
    parser.add_argument("--seeds", default="1", help="of the noise")
    parser.add_argument("--again", action="store_true", help="measure also what the cache holds")
    parser.add_argument("--measured", action="store_true", help="measure nothing: --write what the cache holds of --mmlins")
    parser.add_argument("--write", action="store_true", help="put all figures into the documentation")
    return parser.parse_args()


def write_page(cache: pathlib.Path, program: str) -> None:
    """Of one program; what has been measured with others stays in the cache."""
    text = PAGE.read_text()
    for name, section in SECTIONS.items():
        figures = [f for f in all_figures(cache / name)
                   if f["program"] == digest(program) or f["method"].startswith("bench_")]
        if not figures:
            print(f"{name} is left as it is: nothing was measured")
            continue
        begin, end = f"<!-- {name}: begin (tools/measure_mapping.py) -->", f"<!-- {name}: end -->"
        table = "\n".join([begin, *section.table(figures, cache), end])
        text = re.sub(re.escape(begin) + ".*?" + re.escape(end), lambda _: table, text, flags=re.DOTALL)
    PAGE.write_text(text)


def check(chosen: argparse.Namespace) -> None:
    for what, given, known in (("--only", chosen.only, SECTIONS), ("--methods", chosen.methods, METHODS)):
        if unknown := set(given.split(",")) - set(known):
            sys.exit(f"{what}: there is no {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    for program in filter(None, (chosen.mmlins, chosen.simulator)):
        if not pathlib.Path(program).is_file():
            sys.exit(f"{program}: there is no such program; build it with scripts/build, or name another")
    for folder in filter(None, (chosen.recordings, chosen.suspects)):
        folder.mkdir(parents=True, exist_ok=True)


def main() -> None:
    chosen = options()
    check(chosen)
    bench = Bench(chosen.mmlins, chosen.simulator or chosen.mmlins, None, chosen.recordings, METHODS, chosen.benchmarks,
                  chosen.suspects)
    for name in [] if chosen.measured else chosen.only.split(","):
        kept = [spec for spec in chosen.recording if spec.endswith(".g2o") == (name == "graphs")]
        wanted = Wanted(chosen.methods.split(","), [int(seed) for seed in chosen.seeds.split(",")], chosen.names, kept, None)
        measure_section(name, SECTIONS[name], bench, chosen, wanted)
    if chosen.write:
        write_page(chosen.cache, chosen.mmlins)


if __name__ == "__main__":
    main()
