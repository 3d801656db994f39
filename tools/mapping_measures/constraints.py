# SPDX-License-Identifier: MIT
"""How many constraints between two maps are sought once they are joined: the paper's enhancement."""
import pathlib

from degeneracy.bench import Item, Section, Wanted
from mapping_measures.common import failures, good, line, median
from mapping_measures.loops import measure
from mapping_measures.merges import counts, item_of
from measure_scenarios import metres

NUMBERS = (0, 1, 2, 3, 5, 10)
NAMES = ["dev_campus_1", "dev_campus_2", "dev_factory_1", "dev_decoy_blind", "dev_event_block_hall32",
         "heldout_campus_1", "heldout_campus_4", "heldout_factory_1"]


def items(wanted: Wanted) -> list[Item]:
    return [item_of(name, seed, f"enhancing_{number}") for seed in wanted.seeds for name in NAMES for number in NUMBERS]


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    chosen = good(all_figures)
    lines = ["| constraints sought | runs | merges: true / false | transform error, median / most [m] | [deg] | "
             "end to end, median [m] | placed ATE, median / most [m] |", "|" + "---|" * 7]
    lines += [row_of(number, group) for number in NUMBERS
              if (group := [f for f in chosen if f["method"] == f"enhancing_{number}"])]
    return lines + failures(all_figures)


def row_of(number: int, chosen: list[dict]) -> str:
    true, false, _ = counts(chosen)
    merges = [m for f in chosen for m in f["merges"] if m["metres"] is not None]
    spread = [f"{median(v):.4f} / {max(v):.4f}" if (v := [m[key] for m in merges]) else "" for key in ("metres", "degrees")]
    placed = [f["ate_m"]["placed"] for f in chosen]
    return (f"| {number} | {len(chosen)} | {true} / {false} | {spread[0]} | {spread[1]} | "
            f"{metres(median([f['end_m'] for f in chosen]))} | {metres(median(placed))} / {metres(max(placed))} |")


SECTION = Section(items, measure, line, table)
