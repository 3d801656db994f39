# SPDX-License-Identifier: MIT
"""Places that look like others: twin halls, bare corridors, storeys of one building. Nothing false may be believed."""
import pathlib

from degeneracy.bench import Item, Section, Wanted, catalogue_text, group_of
from degeneracy.health import percent
from mapping_measures.common import CLOSURE_HEAD, closure_words, failures, good, line, worst_merge
from mapping_measures.loops import measure, seed_settings
from mapping_measures.merges import counts
from measure_scenarios import metres

# Blind at various times, and long enough to lose the way: kind:start:duration[:severity]
OUTAGES = {
    "decoy": ((), ("blackout:46:22",), ("blackout:30:22",), ("bag:60:25:0.7",), ("blackout:80:22",), ("bag:100:20:0.7",),
              ("blackout:35:20", "blackout:85:20")),
    "corridor": ((), ("blackout:40:25",), ("bag:70:25:0.7",), ("blackout:110:30",), ("blackout:50:20", "blackout:120:25")),
    "elevator": ((), ("blackout:75:20",)),
}
SCENES = {"decoy": "twin halls", "corridor": "corridors", "elevator": "storeys"}


def items(wanted: Wanted) -> list[Item]:
    return [item_of(f"{group}_{scene}", scene, spoil, seed, method)
            for method in wanted.methods for seed in wanted.seeds for scene in OUTAGES for group in ("dev", "heldout")
            for spoil in OUTAGES[scene]]


def item_of(name: str, scene: str, spoil: tuple[str, ...], seed: int, method: str) -> Item:
    text = catalogue_text(name)
    label = "+".join(event.replace(":", "_") for event in spoil) or "alone"
    return Item(f"{name}-{label}-{seed}-{method}", group_of(name), text, seed_settings(text, seed), spoil, method,
                {"scenario": name, "scene": scene, "seed": seed, "spoil": ", ".join(spoil)})


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    chosen = good(all_figures)
    lines = ["| set | method | place | runs | maps | merges: true / false / missed | found | false closures | of those waiting |",
             "|---|---|---|---|---|---|---|---|---|"]
    for key in sorted({(f["group"], f["method"], f["about"]["scene"]) for f in chosen}):
        group = [f for f in chosen if (f["group"], f["method"], f["about"]["scene"]) == key]
        lines.append(total_row(f"{key[0]} | {key[1]} | {SCENES[key[2]]}", group))
    for method in sorted({f["method"] for f in chosen}):
        lines.append(total_row(f"both | {method} | all", [f for f in chosen if f["method"] == method]))
    lines += ["", f"| scenario, seed | blind | method | maps / worlds | merges: true / false / missed | worst merge [m / deg] | "
              f"ATE of odometry.tum [m] | of trajectory.tum | {CLOSURE_HEAD} | false |", "|" + "---|" * 10]
    return lines + [row_of(f) for f in chosen] + failures(all_figures)


def total_row(head: str, chosen: list[dict]) -> str:
    true, false, missed = counts(chosen)
    return (f"| {head} | {len(chosen)} | {sum(f['maps'] for f in chosen)} | {true} / {false} / {missed} | "
            f"{percent(true, true + missed)} | {sum(len(f['false_closures']) for f in chosen)} | "
            f"{sum(f['false_waiting'] for f in chosen)} |")


def row_of(f: dict) -> str:
    true, false, missed = counts([f])
    return (f"| `{f['about']['scenario']}`, {f['about']['seed']} | {f['about']['spoil'] or 'as it is'} | {f['method']} | "
            f"{f['maps']} / {f['worlds']} | {true} / {false} / {missed} | {worst_merge(f)} | "
            f"{metres(f['ate_m']['odometry'])} | {metres(f['ate_m']['trajectory'])} | {closure_words(f)} | "
            f"{len(f['false_closures'])} |")


SECTION = Section(items, measure, line, table)
