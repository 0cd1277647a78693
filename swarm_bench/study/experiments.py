"""Experiments as written in `params/study/*.yaml`, and their runs."""

from __future__ import annotations

import dataclasses
import functools
import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.methods import METHODS
from swarm_bench.runs.scenario import Scenario, load_scenario
from swarm_common.files.convert import located, read
from swarm_common.files.resources import share_directory
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import CONTROL_PERIOD
from swarm_common.model.schema import Count, Share
from swarm_run.loop import InjectedFaults, Span

QUICK_SEEDS = 2
ENDLESS = 10**9  # tick
# CPU [ms] of a robot-second by method, before anything was measured; LiDARs double it.
USUAL_COST = {"central-mapf": 0.8, "orca": 1.6, "dwa": 2.2}
OTHER_COST = 1.2
LIDAR_FACTOR = 2.0
SHARE_OF_LIMIT = 0.35  # of the time limit that a run with an end usually takes
Settings = tuple[tuple[str, Any], ...]  # name and value, by name
_scenario = functools.lru_cache(maxsize=64)(load_scenario)


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One condition under which all methods are run with the same seeds."""

    scenario: str  # name, also of a file in the folder `scenarios` beside the experiments
    robots: Count
    seconds: float = 3600.0  # of simulated time, after which a run with an end is stopped
    seeds: Count = 20
    methods: list[str] | None = None  # None for those of the experiment
    loss: Share = 0.0  # share of the messages
    delay: float = 0.0  # [s]
    lidar: bool = False
    mission: str = ""  # in place of the scenario's; also of a file in the folder `missions`
    fleet: list[str] = []  # models in turn
    actors: str = ""  # file beside the world's, with people who walk about
    at: float = 20.0  # [s] when what follows begins
    until: float | None = None  # [s] when it ends; None: it does not
    dead: Share = 0.0  # share of the robots that die
    outage: bool = False  # whether the centre does nothing
    split: bool = False  # whether half of the robots hear neither the other half nor the centre
    joins: Share = 0.0  # share of the robots that take no order before
    leaves: Share = 0.0  # share of the robots that take no further order
    blocked: list[float] = []  # x, y, width and depth [m] of a box in the way
    label: str = ""  # what the rest does not tell
    quick: bool = False  # whether the short edition has it

    @property
    def name(self) -> str:
        """Name that identifies the cell within an experiment."""
        span = f"{self.until - self.at:g} s" if self.until is not None else "for ever"
        parts = [f"{Path(self.scenario).stem} {self.robots}"]
        parts += ["LiDAR"] if self.lidar else []
        parts += [f"loss {self.loss:g}"] if self.loss else []
        parts += [f"delay {self.delay:g} s"] if self.delay else []
        parts += [f"{self.dead:.0%} dead"] if self.dead else []
        parts += [f"outage {span}"] if self.outage else []
        parts += [f"split {span}"] if self.split else []
        parts += [f"{self.joins:.0%} added"] if self.joins else []
        parts += [f"{self.leaves:.0%} removed"] if self.leaves else []
        parts += ["blocked aisle"] if self.blocked else []
        parts += ["people"] if self.actors else []
        parts += ["mixed fleet"] if self.fleet else []
        parts += [self.label] if self.label else []
        return ", ".join(parts)

    @property
    def twin(self) -> str:
        """Name of the same cell without what disturbs it."""
        plain = Cell(scenario=self.scenario, robots=self.robots, lidar=self.lidar)
        return plain.name

    def loaded_scenario(self) -> Scenario:
        """Return the scenario.

        Raises:
            ConfigError: If there is none, or it does not go with this cell.
        """
        base = _scenario(self.scenario)
        folder = Path(self.scenario).parent.parent
        return dataclasses.replace(
            base,
            mission=_beside(folder, "missions", self.mission or base.mission),
            loss=self.loss,
            delay=self.delay,
            with_lidar=self.lidar or base.with_lidar,
            fleet=tuple(self.fleet) or base.fleet,
            actors=self.actors or base.actors,
            time_limit={self.robots: self.seconds},
        )

    def span(self) -> Span:
        """Return the ticks of the disturbance."""
        end = ENDLESS if self.until is None else round(self.until / CONTROL_PERIOD)
        return round(self.at / CONTROL_PERIOD), end

    def check(self) -> None:
        """Check what types do not.

        Raises:
            ConfigError: For the first thing that is wrong.
        """
        if self.until is not None and self.until <= self.at:
            raise ConfigError(f"{self.name}: until is {self.until:g}; expected more than at")
        if self.blocked and (len(self.blocked) != 4 or not self.lidar):
            raise ConfigError(f"{self.name}: blocked is [x, y, width, depth], and needs lidar")
        self.loaded_scenario()


class Experiment(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A question, what was expected before the first run, and the cells that answer it."""

    question: str
    expected: list[str]
    methods: list[str]
    cells: list[Cell]

    def methods_of(self, cell: Cell) -> list[str]:
        """Return the methods of a cell."""
        return cell.methods or self.methods


@dataclasses.dataclass(frozen=True, slots=True)
class StudyRun:
    """One run of the study."""

    experiment: str
    cell: Cell
    method: str
    seed: int
    settings: Settings = ()  # of the method, beside its defaults

    @property
    def key(self) -> tuple[str, str, str, int, str]:
        """Key that identifies the run."""
        text = settings_text(self.settings)
        return self.experiment, self.cell.name, self.method, self.seed, text

    def options(self) -> RunOptions:
        """Return the bench's options; faults and constants of baselines are not among them."""
        plain = {name: value for name, value in self.settings if not is_constant(name)}
        central = {n.partition(".")[2]: v for n, v in plain.items() if n.startswith("central.")}
        return RunOptions(
            scenario=self.cell.loaded_scenario(),
            robots=self.cell.robots,
            seed=self.seed,
            method=self.method,
            parameters={n: v for n, v in plain.items() if not n.startswith("central.")},
            central=central,
        )

    def faults(self) -> InjectedFaults:
        """Return what is wrong with which robots; it is the same for all methods."""
        cell, (first, end) = self.cell, self.cell.span()
        order = random.Random(f"study/{self.seed}").sample(range(cell.robots), cell.robots)
        dead = order[: round(cell.dead * cell.robots)]
        off_duty = {
            **dict.fromkeys(order[: round(cell.joins * cell.robots)], (0, first)),
            **dict.fromkeys(order[: round(cell.leaves * cell.robots)], (first, end)),
        }
        return InjectedFaults(
            dead=dict.fromkeys(dead, first),
            off_duty=off_duty,
            split=(first, end) if cell.split else None,
        )

    def cost(self, rates: Mapping[tuple[str, bool], float] | None = None) -> float:
        """Return the CPU [s] that the run will take.

        Args:
            rates: Measured CPU [ms] of a robot-second by method and LiDARs.
        """
        cell, duration = self.cell, _scenario(self.cell.scenario).duration
        rate = USUAL_COST.get(self.method, OTHER_COST) * (LIDAR_FACTOR if cell.lidar else 1.0)
        rate = (rates or {}).get((self.method, cell.lidar), rate)
        return 1e-3 * rate * cell.robots * (duration or SHARE_OF_LIMIT * cell.seconds)


def is_constant(name: str) -> bool:
    """Return whether a setting is a constant of a baseline's module, like orca.HORIZON."""
    return name.rpartition(".")[2].isupper()


def settings_text(settings: Settings) -> str:
    """Return settings in one line."""
    return ", ".join(f"{name}={value}" for name, value in settings)


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
    return {path.stem: _load(path) for path in files}


def _load(path: Path) -> Experiment:
    experiment = read(path, Experiment)
    cells = [beside(cell, path.parent) for cell in experiment.cells]
    with located(path):
        for cell in cells:
            cell.check()
    for cell in cells:
        for method in experiment.methods_of(cell):
            if method not in METHODS:
                raise UnknownNameError(f"{path}: method", method, METHODS)
    if len({cell.name for cell in cells}) < len(cells):
        raise ConfigError(f"{path}: two cells are the same")
    return msgspec.structs.replace(experiment, cells=cells)


def beside(cell: Cell, folder: Path) -> Cell:
    """Return a cell with the path of its scenario, where that lies beside the experiments."""
    return msgspec.structs.replace(cell, scenario=_beside(folder, "scenarios", cell.scenario))


def _beside(folder: Path, kind: str, name: str) -> str:
    path = folder / kind / f"{name}.yaml"
    return str(path) if path.is_file() else name


def runs_of(
    experiments: Mapping[str, Experiment],
    *,
    quick: bool,
    settings: Mapping[str, Settings] | None = None,
) -> list[StudyRun]:
    """Return all runs in an order in which a study that is stopped tells most.

    All methods of a cell and seed follow each other. The n-th seed of a cell waits in proportion to
    its cost and the square of n: what it adds to the knowledge of a mean falls like that.

    Args:
        quick: Whether it is the short edition.
    """
    groups = []
    for name, experiment in experiments.items():
        for cell in experiment.cells:
            methods = experiment.methods_of(cell)
            count = (min(cell.seeds, QUICK_SEEDS) if cell.quick else 0) if quick else cell.seeds
            for seed in range(count):
                runs = [
                    StudyRun(name, cell, method, seed, (settings or {}).get(method, ()))
                    for method in methods
                ]
                groups.append((sum(run.cost() for run in runs) * (seed + 1) ** 2, runs))
    return [run for _, runs in sorted(groups, key=lambda group: group[0]) for run in runs]
