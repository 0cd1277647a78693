"""Scenarios: the rows of the traffic suite, as written in `params/scenarios/*.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from swarm_common.files.resources import share_directory
from swarm_common.files.yaml_io import check_keys, number, numbers, read_yaml
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose

NAMES = (
    "description",
    "world",
    "mission",
    "robot",
    "fleet.*",
    "actors",
    "dispatch",
)  # texts as written
MOST_ROBOTS = 1000
MOST_SECONDS = 604_800.0  # of a run: a week
SUITE_SEEDS = 20


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
    robots: tuple[int, ...] = (20,)  # swarm sizes of the suite
    robot: str = "turtlebot3_waffle"  # model of every robot where there is no fleet
    fleet: tuple[str, ...] = ()  # models in turn: robot k is of fleet[(k - 1) % len(fleet)]
    loss: float = 0.0  # share of the beacons that are lost
    delay: float = 0.0  # [s] that beacons are late, beyond the one tick that they always take
    with_lidar: bool = False  # whether LiDARs run; without them map and beacons are all
    actors: str = ""  # file beside the world's, with people who walk about; empty for its own
    noise: float = 0.02  # standard deviation of each speed in each tick, as a share of it
    dead: tuple[Pose, ...] = ()  # where the last robots stand, which never do or say anything
    # Number of seeds of the suite by swarm size; `SUITE_SEEDS` where nothing is said.
    seeds: Mapping[int, int] = field(default_factory=dict)
    # [s] of simulated time by swarm size, after which missing goals are missed
    time_limit: Mapping[int, float] = field(default_factory=dict)
    stall_limit: float = 600.0  # [s] without a goal reached after which a run is deadlocked
    targets: Mapping[int, Target] = field(default_factory=dict)  # by swarm size
    laps: int = 1  # times that each robot does its route, each with an order of its own
    # [s] of a run in which robots go on lap by lap, and what they finish is counted; 0: until all
    # laps are done
    duration: float = 0.0
    warm_up: float = 0.0  # [s] at the beginning of such a run in which nothing is counted
    dispatch: str = ""  # who gets an order, in place of what the mission says

    def __post_init__(self) -> None:
        if not self.robots:
            raise ConfigError("robots is empty; expected at least one swarm size")
        for size in self.robots:
            check_size(size, "robots")
        if not 0.0 <= self.loss < 1.0:
            raise ConfigError(f"loss is {self.loss}; it must be 0 or more and less than 1")
        for name in ("delay", "noise"):
            if getattr(self, name) < 0.0:
                raise ConfigError(f"{name} is {getattr(self, name)}; it must not be negative")
        if len(self.dead) >= min(self.robots):
            raise ConfigError(f"{len(self.dead)} dead robots leave none of {min(self.robots)}")
        if self.stall_limit <= 0.0:
            raise ConfigError(f"stall_limit is {self.stall_limit} s; it must be positive")
        if self.laps < 1:
            raise ConfigError(f"laps is {self.laps}; it must be 1 or more")
        if not 0.0 <= self.duration <= MOST_SECONDS:
            raise ConfigError(f"duration is {self.duration} s; expected 0 to {MOST_SECONDS:g} s")
        if not 0.0 <= self.warm_up < max(self.duration, 1e-9):
            raise ConfigError(
                f"warm_up is {self.warm_up} s; expected 0 or more, and less than the duration of "
                f"{self.duration} s"
            )
        for size, count in self.seeds.items():
            if count < 1:
                raise ConfigError(f"seeds of {size} robots is {count}; it must be 1 or more")
        for size, limit in self.time_limit.items():
            if limit <= 0.0:
                raise ConfigError(f"time_limit of {size} robots is {limit} s; it must be positive")

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
    if not 1 <= size <= MOST_ROBOTS:
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
    content = read_yaml(path, as_written=NAMES)
    check_keys(content, [item.name for item in fields(Scenario) if item.name != "name"], str(path))
    values = {key: _READERS[key](content[key], f"{path}: {key}") for key in content}
    try:
        return Scenario(name=path.stem, **values)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None


def _folder() -> Path:
    return share_directory("params") / "params" / "scenarios"


def _text(value: object, what: str) -> str:
    if not isinstance(value, str) or not value:
        raise ConfigError(f"{what} is {value!r}; expected a text")
    return value


def _texts(value: object, what: str) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise ConfigError(f"{what} is {value!r}; expected a list of names")
    return tuple(_text(item, what) for item in value)


def _flag(value: object, what: str) -> bool:
    if not isinstance(value, bool):
        raise ConfigError(f"{what} is {value!r}; expected true or false")
    return value


def _integer(value: object, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ConfigError(f"{what} is {value!r}; expected an integer")
    return value


def _sizes(value: object, what: str) -> tuple[int, ...]:
    values = value if isinstance(value, list) else [value]
    return tuple(_integer(item, what) for item in values)


def _poses(value: object, what: str) -> tuple[Pose, ...]:
    if not isinstance(value, list):
        raise ConfigError(f"{what} is {value!r}; expected a list of poses [x, y, yaw]")
    return tuple(Pose(*numbers(item, 3, f"{what}[{i}]")) for i, item in enumerate(value))


def _by_size(value: object, what: str) -> dict[int, Any]:
    if not isinstance(value, dict):
        raise ConfigError(f"{what} is {value!r}; expected 'swarm size: value' lines")
    by_size: dict[int, Any] = {}
    for text, item in value.items():
        if not text.isdecimal():
            raise ConfigError(f"{what} is {text!r}; expected an integer, a swarm size")
        if (size := check_size(int(text), what)) in by_size:
            raise ConfigError(f"{what}: the swarm size {size} occurs twice")
        by_size[size] = item
    return by_size


def _counts(value: object, what: str) -> dict[int, int]:
    return {size: _integer(item, f"{what}.{size}") for size, item in _by_size(value, what).items()}


def _limits(value: object, what: str) -> dict[int, float]:
    return {size: number(item, f"{what}.{size}") for size, item in _by_size(value, what).items()}


def _targets(value: object, what: str) -> dict[int, Target]:
    targets = {}
    for size, item in _by_size(value, what).items():
        where = f"{what}.{size}"
        if not isinstance(item, dict):
            raise ConfigError(f"{where} is {item!r}; expected {{release: s, stretch: s}}")
        check_keys(item, ("release", "stretch"), where)
        targets[size] = Target(**{key: number(item[key], f"{where}.{key}") for key in item})
    return targets


_READERS: dict[str, Any] = {
    "description": _text,
    "world": _text,
    "mission": _text,
    "robots": _sizes,
    "robot": _text,
    "fleet": _texts,
    "loss": number,
    "delay": number,
    "with_lidar": _flag,
    "actors": _text,
    "noise": number,
    "dead": _poses,
    "seeds": _counts,
    "time_limit": _limits,
    "stall_limit": number,
    "targets": _targets,
    "laps": _integer,
    "duration": number,
    "warm_up": number,
    "dispatch": _text,
}
