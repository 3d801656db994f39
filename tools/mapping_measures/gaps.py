# SPDX-License-Identifier: MIT
"""Short blindness in a place that is known already: is the old map resumed, and how soon?"""
import pathlib

from degeneracy.bench import Bench, Item, Section, Wanted, catalogue_text, group_of
from degeneracy.health import percent
from mapping_measures import common
from mapping_measures.common import failures, good, measured, median
from mapping_measures.loops import seed_settings
from measure_scenarios import fingerprint, metres, twin_of

# Where the way leads past what was seen before, and goes on long enough [s]
BASES = {"dev_event_nine_hall32": 100.0, "dev_decoy": 118.0, "dev_kidnap": 80.0,
         "heldout_event_nine_yard_mid360": 110.0, "heldout_decoy": 122.0, "heldout_kidnap": 150.0}
KINDS = {"blackout": "", "bag": ":0.7"}
DURATIONS = [2, 5, 10]


def items(wanted: Wanted) -> list[Item]:
    return [item_of(base, kind, seconds, seed, method) for method in wanted.methods for seed in wanted.seeds
            for base in BASES for kind in KINDS for seconds in DURATIONS]


def item_of(base: str, kind: str, seconds: int, seed: int, method: str) -> Item:
    text = twin_of(catalogue_text(base))
    return Item(f"{base}-{kind}-{seconds}-{seed}-{method}", group_of(base), text, seed_settings(text, seed),
                (f"{kind}:{BASES[base]:g}:{seconds}{KINDS[kind]}",), method,
                {"base": base, "kind": kind, "seconds": seconds, "seed": seed, "twin": fingerprint(text)})


def measure(bench: Bench, item: Item) -> dict:
    with bench.recording_of(item) as made:
        figures = measured(bench, item, made)
    return figures | {"back": back(figures), "delay_s": delay(figures, BASES[item.about["base"]] + item.about["seconds"])}


def back(figures: dict) -> str:
    """How the rest of the drive belongs to what was before."""
    if figures["maps"] == 1:
        return "resumed"
    return "joined" if figures["worlds"] == 1 and not any(m["false"] for m in figures["merges"]) else "apart"


def delay(figures: dict, end: float) -> float | None:
    """From the end of the blindness to the merge; nothing if there is none or none is needed."""
    return max(m["time"] for m in figures["merges"]) - end if back(figures) == "joined" else None


def line(figures: dict) -> str:
    words = "" if figures["delay_s"] is None else f" after {figures['delay_s']:.1f} s"
    return f"{figures['back']}{words}; {common.line(figures)}"


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    chosen = good(all_figures)
    lines = ["| set | method | gap | n | resumed in the old map | or joined to it | apart | delay of the join, median / most "
             "[s] | ATE of odometry.tum, median [m] | of trajectory.tum | false merges |", "|" + "---|" * 11]
    for key in sorted({(f["group"], f["method"], f["about"]["seconds"]) for f in chosen}):
        lines.append(row_of(key, [f for f in chosen if (f["group"], f["method"], f["about"]["seconds"]) == key]))
    return lines + failures(all_figures)


def row_of(key: tuple, chosen: list[dict]) -> str:
    kinds, n = [f["back"] for f in chosen], len(chosen)
    waits = [f["delay_s"] for f in chosen if f["delay_s"] is not None]
    words = f"{median(waits):.1f} / {max(waits):.1f}" if waits else ""
    before, after = (median([f["ate_m"][name] for f in chosen]) for name in ("odometry", "trajectory"))
    return (f"| {key[0]} | {key[1]} | {key[2]} s | {n} | {percent(kinds.count('resumed'), n)} | "
            f"{percent(kinds.count('joined'), n)} | {kinds.count('apart')} | {words} | {metres(before)} | {metres(after)} | "
            f"{sum(m['false'] for f in chosen for m in f['merges'])} |")


SECTION = Section(items, measure, line, table)
