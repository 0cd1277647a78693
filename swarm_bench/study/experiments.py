"""Experiments as written in `params/study/*.yaml`, and their runs."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterator
from pathlib import Path

import msgspec

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import InjectedFaults
from swarm_bench.runs.methods import METHODS
from swarm_bench.runs.scenario import load_scenario
from swarm_common.files.resources import share_directory
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import CONTROL_PERIOD

QUICK_SEEDS = 2


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One condition under which all methods are run with the same seeds."""

    scenario: str
    robots: int
    seconds: float  # of simulated time, after which a run is stopped
    seeds: int = 20
    methods: list[str] | None = None  # None for those of the experiment
    loss: float = 0.0  # share of the messages
    delay: float = 0.0  # [s]
    dead: float = 0.0  # share of the robots that die
    dead_at: float = 20.0  # [s]
    outage: list[float] | None = None  # [s] from and to, in which the centre is dead
    quick: bool = False  # whether the short edition has it

    @property
    def name(self) -> str:
        """What tells it apart within an experiment."""
        parts = [f"{self.scenario} {self.robots}"]
        parts += [f"loss {self.loss:g}"] if self.loss else []
        parts += [f"delay {self.delay:g} s"] if self.delay else []
        parts += [f"{self.dead:.0%} dead"] if self.dead else []
        parts += [f"outage {self.outage[1] - self.outage[0]:g} s"] if self.outage else []
        return ", ".join(parts)


class Experiment(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A question, what was expected before the first run, and the cells that answer it."""

    question: str
    hypothesis: str
    methods: list[str]
    cells: list[Cell]


@dataclasses.dataclass(frozen=True, slots=True)
class StudyRun:
    """One run of the study."""

    experiment: str
    cell: Cell
    method: str
    seed: int

    @property
    def key(self) -> tuple[str, str, str, int]:
        """What tells it apart."""
        return self.experiment, self.cell.name, self.method, self.seed

    def options(self) -> RunOptions:
        """Return the bench's options; faults are not among them."""
        cell = self.cell
        scenario = dataclasses.replace(
            load_scenario(cell.scenario),
            loss=cell.loss,
            delay=cell.delay,
            time_limit={cell.robots: cell.seconds},
        )
        return RunOptions(scenario=scenario, robots=cell.robots, seed=self.seed, method=self.method)

    def faults(self) -> InjectedFaults:
        """Return which robots die; they are the same for all methods."""
        count = round(self.cell.dead * self.cell.robots)
        chosen = random.Random(f"study/{self.seed}").sample(range(self.cell.robots), count)
        tick = round(self.cell.dead_at / CONTROL_PERIOD)
        return InjectedFaults(dead=dict.fromkeys(chosen, tick))

    def outage(self) -> tuple[int, int] | None:
        """Return the first and last tick without a centre."""
        if self.cell.outage is None:
            return None
        first, last = (round(time / CONTROL_PERIOD) for time in self.cell.outage)
        return first, last - 1


def study_folder() -> Path:
    """Return the folder of the experiments that come with the project."""
    return share_directory("params") / "params" / "study"


def load_experiments(folder: Path) -> dict[str, Experiment]:
    """Return the experiments of a folder by name.

    Args:
        folder: With one YAML file per experiment.

    Raises:
        ConfigError: If there are none, or something in them is wrong.
    """
    files = sorted(folder.glob("*.yaml"))
    if not files:
        raise ConfigError(f"{folder} has no experiments; expected files like scalability.yaml")
    return {path.stem: _load(path) for path in files}


def _load(path: Path) -> Experiment:
    try:
        experiment = msgspec.convert(read_yaml(path), Experiment)
    except msgspec.ValidationError as cause:
        raise ConfigError(f"{path}: {cause}") from None
    for cell in experiment.cells:
        load_scenario(cell.scenario)
        for method in cell.methods or experiment.methods:
            if method not in METHODS:
                raise UnknownNameError(f"{path}: method", method, METHODS)
        if not 0.0 <= cell.dead < 1.0 or not 0.0 <= cell.loss < 1.0 or cell.seeds < 1:
            raise ConfigError(f"{path}: {cell.name}: shares are 0 to less than 1, seeds 1 or more")
        if cell.outage is not None and (len(cell.outage) != 2 or cell.outage[0] >= cell.outage[1]):
            raise ConfigError(f"{path}: {cell.name}: outage is {cell.outage}; expected [from, to]")
    names = [cell.name for cell in experiment.cells]
    if len(set(names)) < len(names):
        raise ConfigError(f"{path}: two cells are the same")
    return experiment


def runs_of(experiments: dict[str, Experiment], *, quick: bool) -> Iterator[StudyRun]:
    """Yield all runs, seed by seed, so that a stopped study has something of every cell.

    Args:
        quick: Whether it is the short edition.
    """
    cells = [
        (name, cell, cell.methods or experiment.methods)
        for name, experiment in experiments.items()
        for cell in experiment.cells
        if cell.quick or not quick
    ]
    for seed in range(max(cell.seeds for _, cell, _ in cells)):
        for name, cell, methods in cells:
            if seed < (min(cell.seeds, QUICK_SEEDS) if quick else cell.seeds):
                yield from (StudyRun(name, cell, method, seed) for method in methods)
