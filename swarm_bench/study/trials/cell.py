"""Conditions under which methods run on the same seeds, and the runs in them."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import msgspec

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.scenario import Scenario, load_scenario
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import CONTROL_PERIOD
from swarm_common.model.schema import Count, Share
from swarm_run.loop import InjectedFaults, Span

ENDLESS = 10**9  # tick
# CPU [ms] of a robot-second by method, where nothing was measured yet; LiDARs double it.
USUAL_COST = {"central-mapf": 1.4, "central-reservation": 1.9, "orca": 1.8, "dwa": 4.0}
OTHER_COST = 1.65
LIDAR_FACTOR = 2.0
SHARE_OF_LIMIT = 0.45  # of the time limit that a run with an end usually takes
DIGITS = 8  # of a condition's digest
Settings = tuple[tuple[str, Any], ...]  # name and value, by name
Rates = Mapping[tuple[str, bool], float]  # CPU [ms] of a robot-second by method and LiDARs
_scenario = functools.lru_cache(maxsize=64)(load_scenario)


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One condition under which all methods are run with the same seeds."""

    scenario: str  # name, also of a file in the folder `scenarios` beside the experiments
    robots: Count
    # [s] of simulated time at which a run with an end is stopped: where its restricted mean ends
    seconds: float = 3600.0
    methods: list[str] | None = None  # None for those of the experiment
    loss: Share = 0.0  # share of the messages
    delay: float = 0.0  # [s]
    lidar: bool = False
    fleet: list[str] = []  # models in turn
    lanes: Literal["", "none"] = ""  # those of the world, or none
    actors: str = ""  # file beside the world's, with people who walk about
    at: float = 20.0  # [s] when what follows begins
    until: float | None = None  # [s] when it ends; None: it does not
    dead: Share = 0.0  # share of the robots that die
    outage: bool = False  # whether the centre does nothing
    split: bool = False  # whether half of the robots hear neither the other half nor the centre
    leaves: Share = 0.0  # share of the robots that take no further order
    blocked: list[float] = []  # x, y, width and depth [m] of a box in the way
    quick: bool = False  # whether the short edition has it

    @property
    def name(self) -> str:
        """Name that identifies the cell."""
        span = f"{self.until - self.at:g} s" if self.until is not None else "for ever"
        parts = [f"{Path(self.scenario).stem} {self.robots}"]
        parts += ["no lanes"] if self.lanes else []
        parts += ["LiDAR"] if self.lidar else []
        parts += [f"loss {self.loss:g}"] if self.loss else []
        parts += [f"delay {self.delay:g} s"] if self.delay else []
        parts += [f"{self.dead:.0%} dead"] if self.dead else []
        parts += [f"outage {span}"] if self.outage else []
        parts += [f"split {span}"] if self.split else []
        parts += [f"{self.leaves:.0%} away {span}"] if self.leaves else []
        parts += ["blocked aisle"] if self.blocked else []
        parts += ["people"] if self.actors else []
        parts += ["mixed fleet"] if self.fleet else []
        return ", ".join(parts)

    @property
    def twin(self) -> str:
        """Name of the same cell without what disturbs it."""
        return Cell(
            scenario=self.scenario, robots=self.robots, lidar=self.lidar, lanes=self.lanes
        ).name

    @property
    def condition(self) -> str:
        """Digest of everything that the cell says of its runs; names alone do not say all."""
        plain = msgspec.structs.replace(
            self, scenario=Path(self.scenario).stem, methods=None, quick=False
        )
        return hashlib.sha256(msgspec.json.encode(plain)).hexdigest()[:DIGITS]

    @property
    def has_end(self) -> bool:
        """Whether a run is over once its work is done."""
        return not _scenario(self.scenario).duration

    def loaded_scenario(self) -> Scenario:
        """Return the scenario.

        Raises:
            ConfigError: If there is none, or it does not go with this cell.
        """
        base = _scenario(self.scenario)
        return dataclasses.replace(
            base,
            mission=beside(Path(self.scenario).parent.parent, "missions", base.mission),
            loss=self.loss,
            delay=self.delay,
            with_lidar=self.lidar or base.with_lidar,
            fleet=tuple(self.fleet) or base.fleet,
            actors=self.actors or base.actors,
            lanes=self.lanes or base.lanes,
            time_limit={self.robots: self.seconds},
        )

    def span(self) -> Span:
        """Return the ticks of the disturbance."""
        end = ENDLESS if self.until is None else round(self.until / CONTROL_PERIOD)
        return round(self.at / CONTROL_PERIOD), end

    def placed(self, folder: Path) -> Cell:
        """Return the cell with the path of its scenario, where that lies beside the experiments.

        Raises:
            ConfigError: If something in it is wrong.
        """
        cell = msgspec.structs.replace(self, scenario=beside(folder, "scenarios", self.scenario))
        if cell.until is not None and cell.until <= cell.at:
            raise ConfigError(f"{cell.name}: until is {cell.until:g}; expected more than at")
        if cell.blocked and (len(cell.blocked) != 4 or not cell.lidar):
            raise ConfigError(f"{cell.name}: blocked is [x, y, width, depth], and needs lidar")
        cell.loaded_scenario()
        return cell


def beside(folder: Path, kind: str, name: str) -> str:
    """Return the path of a file in a folder of a folder; the name where there is none."""
    path = folder / kind / f"{name}.yaml"
    return str(path) if path.is_file() else name


@dataclasses.dataclass(frozen=True, slots=True)
class StudyRun:
    """One run of the study."""

    experiment: str
    cell: Cell
    method: str
    seed: int
    settings: Settings = ()  # of the method, beside its defaults

    @property
    def key(self) -> tuple[str, str, str, int, str, str]:
        """Key that identifies the run."""
        cell, text = self.cell, settings_text(self.settings)
        return self.experiment, cell.name, self.method, self.seed, text, cell.condition

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
        return InjectedFaults(
            dead=dict.fromkeys(order[: round(cell.dead * cell.robots)], first),
            off_duty=dict.fromkeys(order[: round(cell.leaves * cell.robots)], (first, end)),
            split=(first, end) if cell.split else None,
        )

    def cost(self, rates: Rates | None = None) -> float:
        """Return the CPU [s] that the run will take."""
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
