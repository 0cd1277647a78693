"""Experiments as written in `params/study/*.yaml`: cells, and what is expected of them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import msgspec
from msgspec import Meta

from swarm_bench.runs.methods import METHODS
from swarm_bench.study.trials.cell import Cell, Settings, StudyRun
from swarm_common.files.convert import located, read
from swarm_common.files.resources import share_directory
from swarm_common.model.errors import ConfigError, UnknownNameError

OURS = "ours"
FIRST_SEED = 6000  # of the study: none is used for development, tuning, learning or --quick
FIRST_QUICK_SEED, QUICK_SEEDS = 4900, 2
LOOKS = (20, 30, 40, 50, 60)  # numbers of paired seeds at which a comparison is looked at
BUDGET = 20.0  # [h] of CPU of all lines, after which nobody gets more seeds than the first look's
Verdict = Literal["ahead", "behind", "equal", "open"]
Expectation = Literal["ahead", "behind", "equal", "not behind"]
Words = Annotated[list[str], Meta(min_length=1)]


class Hypothesis(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """An expectation written down before the first run, and the comparisons that judge it."""

    says: str
    cells: Words  # names of cells
    expected: Expectation  # of our rules, or of `method`
    since: Literal["", "development"] = ""  # runs of which it was written after; empty: before any
    method: str = OURS
    against: list[str] = []  # methods in the same cell
    than: str = ""  # or a cell, with the same method
    measure: Literal["", "throughput", "success", "cost"] = ""  # empty: by the cell


class PairedComparison(NamedTuple):
    """Two samples on the same seeds; the first is hoped to be better."""

    experiment: str
    measure: str  # name in `MEASURES`
    cell: str
    method: str
    base_cell: str
    base_method: str
    expected: Expectation

    @property
    def samples(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Cell and method of both."""
        return (self.cell, self.method), (self.base_cell, self.base_method)

    @property
    def what(self) -> str:
        """The cell, and the other side, for a table."""
        other = self.base_method if self.cell == self.base_cell else f"{self.method} in it"
        return f"{self.cell} | {other}"


class Experiment(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A question, what was expected before the first run, and the cells that answer it."""

    question: str
    methods: Words
    cells: list[Cell]
    hypotheses: list[Hypothesis] = []

    def methods_of(self, cell: Cell) -> list[str]:
        """Return the methods of a cell."""
        return cell.methods or self.methods

    def comparisons(self, name: str, hypothesis: Hypothesis) -> list[PairedComparison]:
        """Return what a hypothesis compares.

        Args:
            name: Identifies the experiment in lines.
        """
        by_name = {cell.name: cell for cell in self.cells}
        return [
            PairedComparison(
                name, hypothesis.measure or measure_of(by_name[cell]), cell, hypothesis.method,
                hypothesis.than or cell, other, hypothesis.expected,
            )
            for cell in hypothesis.cells
            for other in (hypothesis.against or [hypothesis.method])
        ]  # fmt: skip

    def all_comparisons(self, name: str) -> list[PairedComparison]:
        """Return what all hypotheses compare: the family of tests of the experiment."""
        return [each for said in self.hypotheses for each in self.comparisons(name, said)]


Experiments = Mapping[str, Experiment]


def measure_of(cell: Cell) -> str:
    """Return the measure by which methods are compared in a cell."""
    if cell.has_end:
        return "makespan"
    return "throughput" if cell.name == cell.twin else "kept"


def study_folder() -> Path:
    """Return the folder of the experiments that come with the project."""
    return share_directory("params") / "params" / "study"


def load_experiments(folder: Path) -> dict[str, Experiment]:
    """Return the experiments of a folder by name.

    Args:
        folder: With one YAML file per experiment, and folders `scenarios` and `missions`.

    Raises:
        ConfigError: If there are none, or something in them is wrong.
    """
    files = sorted(folder.glob("*.yaml"))
    if not files:
        raise ConfigError(f"{folder} has no experiments; expected files like scalability.yaml")
    found = {path.stem: _load(path) for path in files}
    names = [cell.name for each in found.values() for cell in each.cells]
    if twice := {name for name in names if names.count(name) > 1}:
        raise ConfigError(f"{folder}: two cells are the same: {min(twice)}; no run is made twice")
    methods = dict(_methods(found.values()))
    for path, experiment in zip(files, found.values(), strict=True):
        for number, said in enumerate(experiment.hypotheses, 1):
            with located(path):
                _check(said, f"hypothesis {number}", experiment, methods)
    return found


def _methods(experiments: Collection[Experiment]) -> Iterator[tuple[str, list[str]]]:
    for experiment in experiments:
        for cell in experiment.cells:
            yield cell.name, experiment.methods_of(cell)


def _load(path: Path) -> Experiment:
    experiment = read(path, Experiment)
    with located(path):
        cells = [cell.placed(path.parent) for cell in experiment.cells]
    for cell in cells:
        for method in experiment.methods_of(cell):
            if method not in METHODS:
                raise UnknownNameError(f"{path}: method", method, METHODS)
    return msgspec.structs.replace(experiment, cells=cells)


def _check(
    said: Hypothesis, which: str, experiment: Experiment, methods: Mapping[str, list[str]]
) -> None:
    own = {cell.name: cell for cell in experiment.cells}
    for name in said.cells:
        if name not in own:
            raise UnknownNameError(f"cell of {which}:", name, own)
    if bool(said.against) == bool(said.than):
        raise ConfigError(f"{which}: expected one of 'against' and 'than'")
    if said.than and said.than not in methods:
        raise UnknownNameError(f"cell of {which}:", said.than, methods)
    for name in said.cells:
        needed = [(name, method) for method in (said.method, *said.against)]
        needed += [(said.than, said.method)] if said.than else []
        if not said.measure and measure_of(own[name]) == "kept":
            needed += [(own[name].twin, method) for _, method in needed]
        for place, method in needed:
            if method not in methods.get(place, ()):
                raise ConfigError(f"{which}: {place} is not run with {method}")


def quick_runs(experiments: Experiments, settings: Mapping[str, Settings]) -> list[StudyRun]:
    """Return the runs of the short edition, on seeds that the study never uses."""
    return [
        StudyRun(name, cell, method, seed, settings.get(method, ()))
        for seed in range(FIRST_QUICK_SEED, FIRST_QUICK_SEED + QUICK_SEEDS)
        for name, experiment in experiments.items()
        for cell in experiment.cells
        if cell.quick
        for method in experiment.methods_of(cell)
    ]
