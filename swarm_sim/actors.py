"""Who moves in a world beside the robots: people who walk (`actors.yaml`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from swarm_common.errors import ConfigError
from swarm_common.yaml_io import check_keys, number, numbers, read_yaml

ACTORS_FILE = "actors.yaml"
MAX_SPEED = 2.0  # [m/s] of a walker


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerSpec:
    """A person who walks round a loop, stops for nobody, and does not step into who stands.

    Attributes:
        name: As collisions name it.
        path: Points in map; from the last one the walker goes to the first. Two points are
            walked to and fro.
    """

    name: str
    path: tuple[tuple[float, float], ...]
    speed: float = 0.8  # [m/s]
    radius: float = 0.25  # [m] of the cylinder that stands for the body
    height: float = 1.7  # [m] of it
    pause: float = 1.0  # [s] mean stay at each point of the path
    start: float | None = None  # [m] along the path; None: drawn from the seed
    step_length: float = 0.3  # [m] ahead that must be free of robots that stand
    patience: float = 3.0  # [s] of waiting for one, then the walker turns round

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        if len(self.path) < 2:
            raise ConfigError(f"{self.name}: path has {len(self.path)} point; it needs 2 or more")
        for index, (x, y) in enumerate(self.path):
            if math.dist((x, y), self.path[index - 1]) < 0.1:
                raise ConfigError(f"{self.name}: path[{index}] ({x}, {y}) repeats the one before")
        if not 0.0 < self.speed <= MAX_SPEED:
            raise ConfigError(f"{self.name}: speed is {self.speed} m/s; expected 0 to {MAX_SPEED}")
        for what in ("radius", "height", "step_length", "patience"):
            if getattr(self, what) <= 0.0:
                raise ConfigError(f"{self.name}: {what} is {getattr(self, what)}; must be positive")
        if self.pause < 0.0 or (self.start is not None and self.start < 0.0):
            raise ConfigError(f"{self.name}: pause and start must not be negative")


def load_actors(path: str | Path) -> tuple[WalkerSpec, ...]:
    """Return the walkers in a file with a list `walkers:`.

    Raises:
        ConfigError: If the file is malformed; the message names file and key.
    """
    path = Path(path)
    data = read_yaml(path)
    check_keys(data, ["walkers"], str(path))
    return parse_walkers(data.get("walkers") or [], f"{path}: walkers")


def parse_walkers(value: object, where: str) -> tuple[WalkerSpec, ...]:
    """Return the walkers in a YAML list; each item needs `path`, all else has a default.

    Raises:
        ConfigError: If an item is unusable; the message begins with `where`.
    """
    if not isinstance(value, list):
        raise ConfigError(f"{where} is {value!r}; expected a list, each item with a path")
    walkers = [_walker(item, index, f"{where}[{index}]") for index, item in enumerate(value)]
    names = [walker.name for walker in walkers]
    for name in names:
        if names.count(name) > 1:
            raise ConfigError(f"{where}: the name '{name}' occurs twice")
    return tuple(walkers)


def _walker(item: object, index: int, where: str) -> WalkerSpec:
    if not isinstance(item, dict):
        raise ConfigError(f"{where} is {item!r}; expected path, speed, ...")
    data: dict[str, Any] = item
    known = [field.name for field in fields(WalkerSpec)]
    check_keys(data, known, where)
    values = {
        key: number(given, f"{where}.{key}")
        for key, given in data.items()
        if key not in ("name", "path")
    }
    name = str(data.get("name", f"walker_{index + 1}"))
    path = _path(data.get("path"), f"{where}.path")
    try:
        return WalkerSpec(name=name, path=path, **values)
    except ConfigError as cause:
        raise ConfigError(f"{where}: {cause}") from cause


def _path(value: object, what: str) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list):
        raise ConfigError(f"{what} is {value!r}; expected a list of points [x, y]")
    points: Sequence[tuple[float, ...]] = [
        numbers(point, 2, f"{what}[{index}]") for index, point in enumerate(value)
    ]
    return tuple((x, y) for x, y in points)
