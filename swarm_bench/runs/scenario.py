"""Scenarios: the rows of the traffic suite, as written in `params/scenarios/*.yaml`."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta

from swarm_common.files.convert import read
from swarm_common.files.resources import share_directory
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.schema import Count, NotNegative, PoseNumbers, Positive, Share, check_fields

MOST_ROBOTS = 1000
MOST_SECONDS = 604_800.0  # of a run: a week
SUITE_SEEDS = 20


Size = Annotated[
    int, Meta(ge=1, le=MOST_ROBOTS, description=f"a swarm size from 1 to {MOST_ROBOTS}")
]
Sizes = Annotated[tuple[Size, ...], Meta(min_length=1)]
Seconds = Annotated[float, Meta(ge=0.0, le=MOST_SECONDS)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Makespans [s] that a row of the suite is measured by; None where none was set."""

    release: float | None = None
    stretch: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A world, what the robots do in it, and what makes it hard."""

    name: str  # of the file
    description: str = ""  # one line for tables
    world: str = "slim_blockage"  # name or path
    mission: str = "loading_route"  # name or path; empty for robots that stand (from programs)
    robots: Sizes = (20,)  # swarm sizes of the suite
    robot: str = "turtlebot3_waffle"  # model of every robot where there is no fleet
    fleet: tuple[str, ...] = ()  # models in turn: robot k is of fleet[(k - 1) % len(fleet)]
    loss: Share = 0.0  # share of the beacons that are lost
    delay: NotNegative = 0.0  # [s] that beacons are late, beyond the one tick that they always take
    with_lidar: bool = False  # whether LiDARs run; without them map and beacons are all
    actors: str = ""  # file beside the world's, with people who walk about; empty for its own
    lanes: str = ""  # file of preferred lanes; empty for the world's own, none for no lanes
    noise: NotNegative = 0.02  # standard deviation of each speed in each tick, as a share of it
    dead: tuple[PoseNumbers, ...] = ()  # poses of the last robots, which never do or say anything
    # Number of seeds of the suite by swarm size; `SUITE_SEEDS` where nothing is said.
    seeds: Mapping[Size, Count] = field(default_factory=dict)
    # [s] of simulated time by swarm size, after which missing goals are missed
    time_limit: Mapping[Size, Positive] = field(default_factory=dict)
    stall_limit: Positive = 600.0  # [s] without a goal reached after which a run is deadlocked
    targets: Mapping[Size, Target] = field(default_factory=dict)  # by swarm size
    laps: Count = 1  # times that each robot does its route, each with an order of its own
    # [s] of a run in which robots go on lap by lap, and what they finish is counted; 0: until all
    # laps are done
    duration: Seconds = 0.0
    warm_up: float = 0.0  # [s] at the beginning of such a run in which nothing is counted
    dispatch: str = ""  # who gets an order, in place of what the mission says

    def __post_init__(self) -> None:
        for size in self.robots:
            check_size(size, "robots")
        check_fields(self)
        if len(self.dead) >= min(self.robots):
            raise ConfigError(f"{len(self.dead)} dead robots leave none of {min(self.robots)}")
        if not 0.0 <= self.warm_up < max(self.duration, 1e-9):
            raise ConfigError(
                f"warm_up is {self.warm_up} s; expected 0 or more, and less than the duration of "
                f"{self.duration} s"
            )

    def limit_of(self, robots: int) -> float:
        """Return the time limit [s] of a swarm size: that of the next larger size known.

        Args:
            robots: The swarm size.

        Returns:
            The duration where there is one. Without a larger size the longest limit that there
            is; one hour if there is none.
        """
        if self.duration:
            return self.duration
        larger = [size for size in sorted(self.time_limit) if size >= robots]
        if larger:
            return self.time_limit[larger[0]]
        return max(self.time_limit.values(), default=3600.0)

    def seeds_of(self, robots: int) -> int:
        """Return the number of seeds of the suite for a swarm size.

        Args:
            robots: The swarm size.
        """
        return self.seeds.get(robots, SUITE_SEEDS)

    def models(self, robots: int) -> list[str]:
        """Return the model of each robot.

        Args:
            robots: The swarm size, dead robots included.

        Returns:
            Names or paths of models, by index of the robot.
        """
        fleet = self.fleet or (self.robot,)
        return [fleet[index % len(fleet)] for index in range(robots)]


def check_size(size: int, what: str) -> int:
    """Return a swarm size.

    Args:
        size: The swarm size.
        what: Where it was given, for the error.

    Raises:
        ConfigError: If it is out of bounds.
    """
    if not (isinstance(size, int) and 1 <= size <= MOST_ROBOTS):
        raise ConfigError(f"{what} is {size}; expected a swarm size from 1 to {MOST_ROBOTS}")
    return size


def scenario_names() -> list[str]:
    """Return the names of the scenarios that come with the project."""
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def load_scenario(name_or_path: str) -> Scenario:
    """Return a scenario of `params/scenarios` by name, or one from the user's own file.

    Args:
        name_or_path: Name of a scenario, or a path that ends in `.yaml` or has a folder.

    Raises:
        ConfigError: If there is no such scenario or something in it is wrong.
    """
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml") and len(path.parts) == 1:
        if name_or_path not in scenario_names():
            raise UnknownNameError("scenario", name_or_path, scenario_names())
        path = _folder() / f"{name_or_path}.yaml"
    return read(path, Scenario, prepare=functools.partial(_prepared, path))


def _prepared(path: Path, content: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a file with its name, and one swarm size as a list."""
    if "name" in content:
        raise ConfigError(f"{path}: a scenario has the name of its file; leave 'name' out")
    sizes = content.get("robots", [20])
    return {"name": path.stem, **content, "robots": sizes if isinstance(sizes, list) else [sizes]}


def _folder() -> Path:
    return share_directory("params") / "params" / "scenarios"
