# SPDX-License-Identifier: MIT
"""The catalogue with its events: what is declared, how many maps there are, and whether odometry goes on evenly."""
import json
import pathlib
import re
import tempfile
from typing import NamedTuple

from degeneracy.bench import Bench, Item, Recording, Section, Wanted, all_figures, catalogue_text, group_of
from degeneracy.health import Episode, Health, episodes_of, percent, quantile, read_health, steps_of
from measure_scenarios import SCENARIOS, judged as drifts, metres, read_events, read_tum, twin_of, verdict

ALWAYS = ("blackout", "bag", "kidnap", "elevator")  # what must be declared, whatever it does
DRIFT = 0.1  # of plain odometry; events that cause more must be declared as well [m]
AROUND = 1.0  # of an event: what is declared there belongs to it [s]
IN_TIME = 0.3  # from the beginning of blindness [s]
AFTER = 5.0  # a map that begins so long after an event is due to it [s]


class Event(NamedTuple):
    kind: str
    start: float
    end: float
    severity: float
    must: bool  # be declared
    survived: bool  # by plain odometry


# ---- what is expected; pure


def must_be_declared(kind: str, severity: float, drift: float, num_scans: int) -> bool:
    if kind in ALWAYS:
        return True
    if kind == "packet_loss" and severity >= 1.0:
        return num_scans > 0
    return drift > DRIFT


def belongs(episode: Episode, event: Event) -> bool:
    return episode.start <= event.end + AROUND and episode.end >= event.start - AROUND


def delay_of(event: Event, rows: list[Health], episodes: list[Episode]) -> float | None:
    """From the beginning of the event, or where it leaves no scans, from the last moment without news."""
    if not any(belongs(episode, event) for episode in episodes):
        return None
    flagged = {"BRIDGING", "LOST", "RELOCATING"}
    first = next((row.time for row in rows if row.time > event.start and row.state in flagged), None)
    seen = [row.time for row in rows if event.start < row.time]
    if first is None or not seen:
        return None
    return first - (event.start if seen[0] <= event.end else event.end)


def false_episodes(episodes: list[Episode], events: list[Event]) -> list[Episode]:
    return [episode for episode in episodes if not any(belongs(episode, event) for event in events)]


def excused_episodes(episodes: list[Episode], events: list[Event]) -> list[Episode]:
    """Those that belong only to events which may be declared and need not."""
    touched = [(episode, [event for event in events if belongs(episode, event)]) for episode in episodes]
    return [episode for episode, causes in touched if causes and not any(event.must for event in causes)]


def needless_splits(begins: list[float], events: list[Event]) -> list[float]:
    """Maps that begin without an event, or after one that plain odometry survives."""
    def due(begin: float, event: Event) -> bool:
        return event.start <= begin <= event.end + AFTER and not event.survived
    return [begin for begin in begins if not any(due(begin, event) for event in events)]


# ---- measuring


def items(wanted: Wanted) -> list[Item]:
    names = [path.stem for path in sorted(SCENARIOS.glob("*_*.yaml")) if path.stem.startswith(("dev_", "heldout_"))]
    return [item_of(name, seed, method, wanted.catalogue) for method in wanted.methods for seed in wanted.seeds
            for name in names if catalogue_text(name) != twin_of(catalogue_text(name))]


def item_of(name: str, seed: int, method: str, catalogue: pathlib.Path | None) -> Item:
    text = catalogue_text(name)
    own = int(re.search(r"^seed: (\d+)", text, flags=re.MULTILINE)[1])
    settings = () if seed == 1 else (f"seed={own + 10000 * (seed - 1)}",)
    return Item(f"{name}-{seed}-{method}", group_of(name), text, settings, (), method,
                {"scenario": name, "seed": seed, "catalogue": str(catalogue) if catalogue else ""})


class Plain(NamedTuple):
    """What plain odometry makes of a scenario."""

    events: list[dict]
    ate_m: float
    twin_ate_m: float | None  # without events


def plain_of(bench: Bench, item: Item, made: Recording, out: pathlib.Path) -> Plain:
    """From the cache of measure_scenarios.py; what is not there, from a run of the program of before."""
    path = pathlib.Path(item.about["catalogue"]) / f"{item.about['scenario']}.json"
    if item.about["catalogue"] and path.exists():
        kept = json.loads(path.read_text())
        return Plain(kept["with"]["events"], kept["with"]["ate_m"], kept["twin"]["ate_m"])
    bench.run("plain", made, out)
    truth, odometry = read_tum(made.truth), read_tum(out / "odometry.tum")
    events = [drifts(event, truth, odometry) for event in read_events(made.events, truth[0].time)]
    return Plain(events, bench.evaluated(made.truth, out / "odometry.tum")["ate_m"]["rmse"], None)


def measure(bench: Bench, item: Item) -> dict:
    with bench.recording_of(item) as made, tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name)
        plain = plain_of(bench, item, made, out / "plain")
        bench.run(item.method, made, out)
        truth, rows = read_tum(made.truth), read_health(out / "health.csv")
        origin = truth[0].time
        events = read_events(made.events, origin)
        summary = json.loads((out / "summary.json").read_text())
        ate = {file: bench.evaluated(made.truth, out / f"{file}.tum")["ate_m"]["rmse"]
               for file in ("odometry", "trajectory")}
        steps = steps_of(read_tum(out / "odometry.tum"), truth)
    rows = [row._replace(time=row.time - origin) for row in rows]
    return (judged(rows, known(events, plain.events, rows), summary, origin) |
            {"ate_m": ate, "plain_ate_m": plain.ate_m, "plain_twin_ate_m": plain.twin_ate_m,
             "scans": summary["scans"], "left_out": summary["scans_left_out"], "states": summary["scans_by_state"],
             "steps": steps._asdict() | {"jump_at": steps.jump_at - origin}})


def known(events: list[dict], plain: list[dict], rows: list[Health]) -> list[Event]:
    result = []
    for event, before in zip(events, plain, strict=True):
        scans = sum(event["start_s"] < row.time <= event["end_s"] for row in rows)
        must = must_be_declared(event["kind"], event["severity"], before["drift_end_m"], scans)
        result.append(Event(event["kind"], event["start_s"], event["end_s"], event["severity"], must,
                            verdict(before) in ("harmless", "noticeable")))
    return result


def judged(rows: list[Health], events: list[Event], summary: dict, origin: float) -> dict:
    episodes = episodes_of(rows)
    begins = [float(record["begin"]) - origin for record in summary.get("maps", [])[1:]]
    return {"events": [event._asdict() | {"declared_s": delay_of(event, rows, episodes)} for event in events],
            "episodes": [[e.start, e.end, *e.causes] for e in episodes],
            "false": [[e.start, e.end, *e.causes] for e in false_episodes(episodes, events)],
            "excused": len(excused_episodes(episodes, events)), "begins": begins,
            "needless": needless_splits(begins, events)}


# ---- tables


def declared(event: dict) -> str:
    if event["declared_s"] is None:
        return "NOT declared" if event["must"] else "not declared"
    return f"{event['declared_s']:.1f} s"


def line(figures: dict) -> str:
    words = [f"{e['kind']} at {e['start']:.0f} s {'must' if e['must'] else 'may'}: {declared(e)}"
             for e in figures["events"]]
    false = "".join(f"; FALSE {e[0]:.1f} to {e[1]:.1f} s {e[2]}" for e in figures["false"])
    needless = "".join(f"; NEEDLESS map at {begin:.1f} s" for begin in figures["needless"])
    ate, steps = figures["ate_m"], figures["steps"]
    return (f"{'; '.join(words)}{false}; {len(figures['begins']) + 1} maps{needless}; ATE {metres(ate['odometry'])} / "
            f"{metres(ate['trajectory'])} m (plain {metres(figures['plain_ate_m'])}); jump {steps['worst_jump_m']:.3f} m "
            f"at {steps['jump_at']:.1f} s")


def table(figures: list[dict], cache: pathlib.Path) -> list[str]:
    good = [f for f in figures if "failed" not in f]
    return [*detection_table(good), "", *nine_table(good), "", *split_table(good, cache), "", *continuity_table(good)]


def detection_table(good: list[dict]) -> list[str]:
    lines = ["| set | method | events that must be declared | recall | declared within 0.3 s | delay, median / most [s] | "
             "episodes | false | precision |", "|---|---|---|---|---|---|---|---|---|"]
    for key in sorted({(f["group"], f["method"]) for f in good}):
        chosen = [f for f in good if (f["group"], f["method"]) == key]
        due = [e for f in chosen for e in f["events"] if e["must"]]
        delays = [e["declared_s"] for e in due if e["declared_s"] is not None]
        false = sum(len(f["false"]) for f in chosen)
        counted = sum(len(f["episodes"]) - f["excused"] for f in chosen)
        lines.append(f"| {key[0]} | {key[1]} | {len(due)} | {percent(len(delays), len(due))} | "
                     f"{percent(sum(d <= IN_TIME for d in delays), len(due))} | "
                     f"{quantile(delays, 0.5):.1f} / {quantile(delays, 1.0):.1f} | {counted} | {false} | "
                     f"{percent(counted - false, counted)} |")
    return lines


def nine_table(good: list[dict]) -> list[str]:
    """The paper's Table IV: nine events, of which each ends a map there."""
    lines = ["| nine events | of them not survived by plain odometry | maps: default | paper | published | zhang |",
             "|---|---|---|---|---|---|"]
    maps = {(f["about"]["scenario"], f["about"]["seed"], f["method"]): len(f["begins"]) + 1 for f in good}
    for f in good:
        scenario, seed = f["about"]["scenario"], f["about"]["seed"]
        if "nine" in scenario and f["method"] == "default":
            made = [maps.get((scenario, seed, method), "") for method in ("default", "paper", "published", "zhang")]
            lines.append(f"| {label_of(f)} | {sum(not e['survived'] for e in f['events'])} | " + " | ".join(map(str, made)) + " |")
    return lines


def label_of(f: dict) -> str:
    seed = f["about"]["seed"]
    return f"`{f['about']['scenario']}`" + (f", seed {seed}" if seed != 1 else "")


def split_table(good: list[dict], cache: pathlib.Path) -> list[str]:
    twins = {f["name"].rsplit("-", 1)[0]: f["ate_m"] for f in all_figures(cache / "free")
             if "failed" not in f and f["method"] == "default"}
    lines = ["| scenario | method | maps | needless | ATE of odometry.tum [m] | of trajectory.tum | plain odometry | "
             "without events: plain, this |", "|---|---|---|---|---|---|---|---|"]
    for f in good:
        twin = metres(twins[f["about"]["scenario"]]) if f["about"]["scenario"] in twins else ""
        lines.append(f"| {label_of(f)} | {f['method']} | {len(f['begins']) + 1} | {len(f['needless'])} | "
                     f"{metres(f['ate_m']['odometry'])} | {metres(f['ate_m']['trajectory'])} | "
                     f"{metres(f['plain_ate_m'])} | {metres(f['plain_twin_ate_m']) if f['plain_twin_ate_m'] else ''}, "
                     f"{twin} |")
    return lines


def continuity_table(good: list[dict]) -> list[str]:
    lines = ["| scenario | method | scans | poses | step longer than the true one by at most [m] | worst jump [m] | at |",
             "|---|---|---|---|---|---|---|"]
    for f in good:
        steps = f["steps"]
        scans = f["scans"] + sum(f["left_out"].values())
        lines.append(f"| {label_of(f)} | {f['method']} | {scans} | {steps['poses']} | "
                     f"{steps['worst_excess_m']:.3f} | {steps['worst_jump_m']:.3f} | {steps['jump_at']:.0f} s |")
    return lines


SECTION = Section(items, measure, line, table)
