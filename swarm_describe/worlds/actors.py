"""The people and vehicles that move in a world beside the robots (`actors.yaml`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from swarm_common.files.yaml_io import check_keys, field_values, name_in, numbers, read_yaml
from swarm_common.model.errors import ConfigError

ACTORS_FILE = "actors.yaml"
MAX_SPEED = 2.0  # [m/s] of a walker or a vehicle
MAX_EXTENT = 20.0  # [m] of a vehicle, and of other values of it
MAX_PLACE = 10_000.0  # [m] from the origin


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerSpec:
    """A person who walks in a loop, yields to nobody, and does not step into a standing robot."""

    name: str  # as collisions name it
    # points in map; from the last one the walker goes to the first. Two points are walked to and
    # fro
    path: tuple[tuple[float, float], ...]
    speed: float = 0.8  # [m/s]
    radius: float = 0.25  # [m] of the cylinder that stands for the body
    height: float = 1.7  # [m] of it
    pause: float = 1.0  # [s] mean stay at each point of the path
    start: float | None = None  # [m] along the path; None: drawn from the seed
    step_length: float = 0.3  # [m] ahead that must be free of robots that stand
    patience: float = 3.0  # [s] of waiting for one, then the walker turns round

    def __post_init__(self) -> None:
        _check_path(self.name, self.path)
        if not 0.0 < self.speed <= MAX_SPEED:
            raise ConfigError(f"{self.name}: speed is {self.speed} m/s; expected 0 to {MAX_SPEED}")
        for what in ("radius", "height", "step_length", "patience"):
            if getattr(self, what) <= 0.0:
                raise ConfigError(f"{self.name}: {what} is {getattr(self, what)}; must be positive")
        if self.pause < 0.0 or (self.start is not None and self.start < 0.0):
            raise ConfigError(f"{self.name}: pause and start must not be negative")


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSpec:
    """A forklift or the like: a box that drives round a loop, backwards after a sharp corner."""

    name: str  # as collisions name it
    # points in map of its middle; from the last one it drives to the first. Two points are driven
    # to and fro. It turns on the spot at points, by a right angle at most
    path: tuple[tuple[float, float], ...]
    length: float = 2.2  # [m]
    width: float = 1.1  # [m]
    height: float = 2.0  # [m]
    speed: float = 1.0  # [m/s]
    turn_speed: float = 0.6  # [rad/s]
    pause: float = 3.0  # [s] mean stay at each point of the path
    start: float | None = None  # [m] along the path; None: drawn from the seed
    step_length: float = 1.0  # [m] ahead that must be free of robots that stand
    patience: float = 5.0  # [s] of waiting for one, then the vehicle turns round

    def __post_init__(self) -> None:
        _check_path(self.name, self.path)
        if not 0.0 < self.speed <= MAX_SPEED:
            raise ConfigError(f"{self.name}: speed is {self.speed} m/s; expected 0 to {MAX_SPEED}")
        for what in ("length", "width", "height", "turn_speed", "step_length", "patience"):
            value = getattr(self, what)
            if not 0.0 < value <= MAX_EXTENT:
                raise ConfigError(
                    f"{self.name}: {what} is {value}; expected more than 0, at most {MAX_EXTENT:g}"
                )
        if self.pause < 0.0 or (self.start is not None and self.start < 0.0):
            raise ConfigError(f"{self.name}: pause and start must not be negative")

    @property
    def radius(self) -> float:
        """[m] of the circle around it."""
        return math.hypot(self.length, self.width) / 2.0


@dataclass(frozen=True, slots=True)
class Actors:
    """Everybody in an actors file."""

    walkers: tuple[WalkerSpec, ...] = ()
    vehicles: tuple[VehicleSpec, ...] = ()


def load_actors(path: str | Path) -> Actors:
    """Return the actors in a file with lists `walkers:` and `forklifts:`."""
    path = Path(path)
    data = read_yaml(path, as_written=("walkers.*.name", "forklifts.*.name"))
    check_keys(data, ["walkers", "forklifts"], str(path))
    walkers = parse_walkers(data.get("walkers") or [], f"{path}: walkers")
    vehicles = _parse_all(data.get("forklifts") or [], f"{path}: forklifts", VehicleSpec)
    check_names([*walkers, *vehicles], str(path))
    return Actors(walkers, vehicles)


def parse_walkers(value: object, where: str) -> tuple[WalkerSpec, ...]:
    """Return the walkers in a YAML list; each item needs `path`, all else has a default."""
    return _parse_all(value, where, WalkerSpec)


def check_names(specs: Sequence[WalkerSpec | VehicleSpec], where: str) -> None:
    """Refuse a name that occurs twice.

    Raises:
        ConfigError: Naming it.
    """
    names = [spec.name for spec in specs]
    for name in names:
        if names.count(name) > 1:
            raise ConfigError(f"{where}: the name '{name}' occurs twice")


def _parse_all(value: object, where: str, kind: type[Spec]) -> tuple[Spec, ...]:
    if not isinstance(value, list):
        raise ConfigError(f"{where} is {value!r}; expected a list, each item with a path")
    specs = [_spec(item, index, f"{where}[{index}]", kind) for index, item in enumerate(value)]
    check_names(specs, where)
    return tuple(specs)


def _spec(item: object, index: int, where: str, kind: type[Spec]) -> Spec:
    defaults = {"name": f"{_DEFAULT_NAMES[kind]}_{index + 1}", "path": None}
    data = {**defaults, **item} if isinstance(item, dict) else item
    readers: dict[str, Callable[[Any, str], Any]] = {"name": name_in, "path": _path}
    values = field_values(kind, data, where, readers=readers)
    try:
        return kind(**values)
    except ConfigError as cause:
        raise ConfigError(f"{where}: {cause}") from cause


def _check_path(name: str, path: tuple[tuple[float, float], ...]) -> None:
    if len(path) < 2:
        raise ConfigError(f"{name}: path has {len(path)} point; it needs 2 or more")
    for index, (x, y) in enumerate(path):
        if math.dist((x, y), path[index - 1]) < 0.1:
            raise ConfigError(f"{name}: path[{index}] ({x}, {y}) repeats the one before")
        if max(abs(x), abs(y)) > MAX_PLACE:
            raise ConfigError(f"{name}: path[{index}] ({x}, {y}) is beyond {MAX_PLACE:g} m")


Spec = TypeVar("Spec", WalkerSpec, VehicleSpec)
_DEFAULT_NAMES: dict[type, str] = {WalkerSpec: "walker", VehicleSpec: "forklift"}


def _path(value: object, what: str) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list):
        raise ConfigError(f"{what} is {value!r}; expected a list of points [x, y]")
    points: Sequence[tuple[float, ...]] = [
        numbers(point, 2, f"{what}[{index}]") for index, point in enumerate(value)
    ]
    return tuple((x, y) for x, y in points)
