# SPDX-License-Identifier: MIT
"""Makes recordings, spoils them, runs a program on them, and keeps the figures."""
import contextlib
import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from typing import NamedTuple

from measure_scenarios import SCENARIOS, essence_of, fingerprint, keep, load

METHODS = {  # what is handed to `run`; `plain` is another program
    "default": (),
    "paper": ("odometry.detector=paper",),
    "published": ("odometry.detector=published",),
    "zhang": ("odometry.detector=zhang",),
    "start_paper": ("odometry.initialization.mode=paper",),
    "softened": ("odometry.matching.soften_weak_directions=true",),
    "plain": (),
}


class Failed(Exception):
    """A program refused or broke down; the text is what it said."""


class Recording(NamedTuple):
    bag: pathlib.Path
    rig: pathlib.Path
    truth: pathlib.Path
    events: pathlib.Path


class Item(NamedTuple):
    """One thing that is measured."""

    name: str  # of the file of its figures
    group: str  # "development" or "held out"
    scenario: str  # text of a scenario
    settings: tuple[str, ...] = ()  # for `simulate`
    spoil: tuple[str, ...] = ()  # events for `degrade`, kind:start:duration[:severity]
    method: str = "default"
    about: dict = {}  # what the tables group by


class Section(NamedTuple):
    items: Callable[["Wanted"], list[Item]]
    measure: Callable[["Bench", Item], dict]
    line: Callable[[dict], str]  # of one item, for the screen
    table: Callable[[list[dict], pathlib.Path], list[str]]  # of all items; the folder holds the other sections' figures


class Wanted(NamedTuple):
    methods: list[str]
    seeds: list[int]
    names: list[str]  # patterns
    recordings: list[str]  # BAG:RIG:TRUTH:START:END of recordings that were not simulated
    catalogue: pathlib.Path | None  # cache of measure_scenarios.py


class Bench(NamedTuple):
    mmlins: str
    simulator: str
    plain: str | None
    recordings: pathlib.Path | None  # recordings are kept here, if anywhere
    methods: dict[str, tuple[str, ...]] = METHODS
    benchmarks: pathlib.Path | None = None  # folder of the programs bench_*
    suspects: pathlib.Path | None = None  # runs that look wrong are kept here, if anywhere

    def program_of(self, method: str) -> str:
        if method.startswith("bench_"):
            if self.benchmarks is None or not (self.benchmarks / method).is_file():
                raise Failed(f"--benchmarks is needed: the folder in which {method} is")
            return str(self.benchmarks / method)
        if method != "plain":
            return self.mmlins
        if self.plain is None:
            raise Failed("--plain is needed for the program of before")
        return self.plain

    def identity_of(self, item: Item) -> str:
        return fingerprint(digest(self.program_of(item.method)), digest(self.simulator), item.scenario,
                           *item.settings, "|", *item.spoil, "|", *self.methods.get(item.method, ()))

    @contextlib.contextmanager
    def recording_of(self, item: Item) -> Iterator[Recording]:
        """Simulated, and spoilt by the item's `spoil`."""
        with tempfile.TemporaryDirectory(prefix="degeneracy_") as work:
            folder = self.simulated(item, pathlib.Path(work))
            made = Recording(*(folder / name for name in ("recording.bag", "rig.yaml", "truth.tum", "events.csv")))
            if item.spoil:
                made = spoilt(self.simulator, made, item, pathlib.Path(work) / "spoilt")
            yield made

    def simulated(self, item: Item, work: pathlib.Path) -> pathlib.Path:
        home = self.recordings or work
        folder = home / fingerprint(digest(self.simulator), item.scenario, *item.settings)
        if folder.exists():
            return folder
        scratch, scenario = folder.with_suffix(".part"), work / "scenario.yaml"
        shutil.rmtree(scratch, ignore_errors=True)
        scenario.write_text(item.scenario + "\n")
        call(self.simulator, "simulate", scenario, "--out", scratch, *settings_words(item.settings))
        scratch.rename(folder)
        return folder

    def run(self, method: str, recording: Recording, out: pathlib.Path) -> str:
        """What it said on the way."""
        return call(self.program_of(method), "run", recording.bag, "--rig", recording.rig, "--out", out,
                    "--threads", 1, *settings_words(self.methods[method]))

    def evaluated(self, truth: pathlib.Path, estimate: pathlib.Path) -> dict:
        said = call(self.mmlins, "evaluate", truth, estimate, "--json")
        return json.JSONDecoder().raw_decode(said)[0]


def call(program: str, *arguments: object) -> str:
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        said = done.stderr.strip().splitlines()
        raise Failed(f"{arguments[0]} ended with {done.returncode}: {said[-1] if said else 'nothing said'}")
    return done.stdout + done.stderr


def settings_words(settings: tuple[str, ...]) -> list[str]:
    return [word for setting in settings for word in ("--set", setting)]


def spoilt(program: str, made: Recording, item: Item, folder: pathlib.Path) -> Recording:
    folder.mkdir()
    events = [word for event in item.spoil for word in ("--event", event)]
    seed = next((setting.removeprefix("seed=") for setting in item.settings if setting.startswith("seed=")), "1")
    call(program, "degrade", made.bag, folder / "spoilt.bag", *events, "--rig", made.rig, "--seed", seed)
    return made._replace(bag=folder / "spoilt.bag", events=folder / "spoilt.events.csv")


_digests: dict[str, str] = {}


def digest(program: str) -> str:
    if program not in _digests:
        _digests[program] = hashlib.sha256(pathlib.Path(program).read_bytes()).hexdigest()[:16]
    return _digests[program]


# ---- scenarios


def catalogue_text(name: str) -> str:
    return essence_of((SCENARIOS / f"{name}.yaml").read_text())


def group_of(name: str) -> str:
    return "held out" if name.startswith("heldout") else "development"


def duration_of(scenario: str) -> float:
    return float(re.search(r"^duration: ([\d.]+)", scenario, flags=re.MULTILINE)[1])


# ---- figures


def figures_of(bench: Bench, item: Item, measure: Callable[[Bench, Item], dict], folder: pathlib.Path,
               again: bool) -> dict:
    """From the cache, or measured now."""
    path = folder / f"{item.name}.json"
    identity = bench.identity_of(item)
    if not again and (kept := load(path, identity)):
        return kept
    figures = {"identity": identity, "program": digest(bench.program_of(item.method)), "name": item.name,
               "group": item.group, "method": item.method, "about": item.about}
    try:
        figures |= measure(bench, item)
    except Failed as failure:
        figures["failed"] = str(failure)
    keep(path, figures)
    return figures


def all_figures(folder: pathlib.Path) -> list[dict]:
    return [json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))]
