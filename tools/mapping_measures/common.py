# SPDX-License-Identifier: MIT
"""A recording run and judged: what several sections share."""
import pathlib
import shutil
import tempfile

import numpy as np

from degeneracy.bench import Bench, Failed, Item, Recording
from degeneracy.health import quantile
from mapping_measures.judge import (CLOSE_DEG, CLOSE_M, end_to_end, false_closures, judged_merges, length,
                                    missed_worlds)
from mapping_measures.poses import Track, ate, read_track, track_at
from mapping_measures.run_files import Run, read_run
from measure_scenarios import metres

METHODS = {
    "default": (),
    "off": ("mapping.enabled=false",),  # odometry alone; its maps hang together by their gaps
    "apart": ("mapping.fusion=off",),  # loops are closed, maps are not joined
    "paper": ("mapping.fusion=paper",),
    "single": ("mapping.fusion=single",),
    **{f"enhancing_{n}": (f"mapping.merge.num_enhancing={n}",) for n in (0, 1, 2, 3, 5, 10)},
}
USED = ("counts", "confirmed")  # states of closures that were believed
WORSE = 1.02  # times the error of odometry.tum: more is asked never to be
LEAST = 0.002  # differences below are not told from noise [m]


def measured(bench: Bench, item: Item, made: Recording) -> dict:
    """Runs and judges; what looks wrong is kept."""
    with tempfile.TemporaryDirectory(prefix="mapping_") as name:
        out = pathlib.Path(name)
        try:
            bench.run(item.method, made, out)
            figures = judged(read_run(out), read_track(made.truth))
        except Failed:
            keep_suspect(bench, item, out)
            raise
        if suspicion(figures):
            keep_suspect(bench, item, out)
    return figures


def keep_suspect(bench: Bench, item: Item, out: pathlib.Path) -> None:
    if bench.suspects is not None:
        shutil.rmtree(bench.suspects / item.name, ignore_errors=True)
        shutil.copytree(out, bench.suspects / item.name)


def judged(run: Run, truth: Track) -> dict:
    summary = run.summary
    mapping = summary.get("mapping", {})
    worlds = sorted(set(run.worlds.values()))
    begins = [float(m["begin"]) - truth.time[0] for m in summary["maps"]]
    return {
        "path_m": length(truth, run), "duration_s": summary["duration_s"],
        "ate_m": ates(run, truth), "end_m": end_to_end(run, truth),
        "maps": len(run.worlds), "worlds": len(worlds), "begins": begins,
        "merges": [{"map": m.map, "into": m.into, "time": m.time - truth.time[0], "false": bool(m.is_false),
                    "metres": m.error and m.error.metres, "degrees": m.error and m.error.degrees}
                   for m in judged_merges(run, truth)],
        "missed": missed_worlds(run, truth),
        "closures": {state: sum(c.state == state for c in run.closures)
                     for state in ("counts", "confirmed", "waiting", "rejected", "refused")},
        "false_closures": false_closures(run, truth, USED),
        "false_waiting": len(false_closures(run, truth, ("waiting",))),
        "wall_s": summary["wall_s"], "peak_mib": summary["peak_memory_mib"],
        "back_end_s": mapping.get("seconds", {}), "keyframes": mapping.get("keyframes", 0), "work_s": work_of(summary)}


def work_of(summary: dict) -> dict:
    """Seconds of work: all of it, and what of it went into detection, initialisation and fusion."""
    stages, scans, mapping = summary["stages"], summary["scans"], summary.get("mapping", {})
    back_end = sum(mapping.get("seconds", {}).values())
    seconds = {name: 1e-3 * scans * stages[name]["mean_ms"] for name in ("total", "health", "start")}
    return {"all": seconds["total"] + back_end, "detection": seconds["health"], "initialisation": seconds["start"],
            "fusion": mapping.get("seconds_between_maps", 0.0)}


def ates(run: Run, truth: Track) -> dict:
    """`placed` is aligned on those scans alone."""
    at_scans = track_at(truth, run.trajectory.time)
    return {"odometry": ate(track_at(truth, run.odometry.time), run.odometry), "trajectory": ate(at_scans, run.trajectory),
            "placed": ate(at_scans.part(run.placed), run.trajectory.part(run.placed)) if np.any(run.placed) else None}


# ---- words


def is_worse(figures: dict) -> bool:
    before, after = figures["ate_m"]["odometry"], figures["ate_m"]["trajectory"]
    return after > WORSE * before and after - before > LEAST


def suspicion(figures: dict) -> list[str]:
    words = [f"FALSE MERGE of {m['map']} into {m['into']} at {m['time']:.0f} s, {m['metres']:.2f} m {m['degrees']:.2f} deg"
             for m in figures["merges"] if m["false"]]
    words += [f"FALSE CLOSURE {c['id']} {c['state']}, {c['metres']:.2f} m {c['degrees']:.2f} deg"
              for c in figures["false_closures"]]
    return words + (["WORSE than odometry"] if is_worse(figures) else [])


def line(figures: dict) -> str:
    errors = figures["ate_m"]
    placed = "" if errors["placed"] is None else f" (placed {metres(errors['placed'])})"
    merges = "; ".join(merge_words(m) for m in figures["merges"])
    words = [f"ATE {metres(errors['odometry'])} -> {metres(errors['trajectory'])} m{placed}",
             f"end {metres(figures['end_m'])} m", f"{figures['maps']} maps, {figures['worlds']} worlds"
             + (f", MISSED {figures['missed']}" if figures["missed"] else ""), merges or "no merges",
             "closures " + " ".join(f"{n} {state}" for state, n in figures["closures"].items() if n),
             f"{figures['wall_s']:.0f} s, {figures['peak_mib']:.0f} MiB", *suspicion(figures)]
    return "; ".join(words)


def merge_words(merge: dict) -> str:
    if merge["metres"] is None:
        return f"{merge['map']} into {merge['into']}: not to be judged"
    return f"{merge['map']} into {merge['into']} at {merge['time']:.0f} s: {metres(merge['metres'])} m {merge['degrees']:.3f} deg"


def closure_words(figures: dict) -> str:
    states = figures["closures"]
    return " / ".join(str(states[state]) for state in ("counts", "confirmed", "waiting", "rejected", "refused"))


CLOSURE_HEAD = "closures: counting / confirmed / waiting / rejected / refused"


def worst_merge(figures: dict) -> str:
    errors = [m for m in figures["merges"] if m["metres"] is not None]
    return f"{metres(max(m['metres'] for m in errors))} / {max(m['degrees'] for m in errors):.2f}" if errors else ""


def is_close(merge: dict) -> bool:
    return merge["metres"] is not None and merge["metres"] <= CLOSE_M and merge["degrees"] <= CLOSE_DEG


def back_end_share(figures: dict) -> str:
    """Of the time that the recording took."""
    return f"{100.0 * sum(figures['back_end_s'].values()) / figures['duration_s']:.1f} %" if figures["back_end_s"] else ""


def work_shares(chosen: list[dict]) -> str:
    """Detection / initialisation / fusion in percent: of all work, and of the time that the recordings last."""
    def shares(whole: float, digits: int) -> str:
        return " / ".join(f"{100.0 * sum(f['work_s'][name] for f in chosen) / whole:.{digits}f}"
                          for name in ("detection", "initialisation", "fusion"))
    return (f"{shares(sum(f['work_s']['all'] for f in chosen), 1)} | "
            f"{shares(sum(f['duration_s'] for f in chosen), 2)}")


def good(figures: list[dict]) -> list[dict]:
    return [f for f in figures if "failed" not in f]


def failures(figures: list[dict]) -> list[str]:
    """To be said under a table."""
    failed = [f for f in figures if "failed" in f]
    return ["", *(f"`{f['name']}` failed: {f['failed']}" for f in failed)] if failed else []


def median(values: list[float]) -> float:
    return quantile(values, 0.5)
