"""The people and vehicles that move in a world beside the robots (`actors.yaml`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta

from swarm_common.files.convert import located, read
from swarm_common.model.errors import ConfigError
from swarm_common.model.schema import Name, NotNegative, Point, Positive, Schema, check_fields

ACTORS_FILE = "actors.yaml"
MAX_SPEED = 2.0  # [m/s] of a walker or a vehicle
MAX_EXTENT = 20.0  # [m] of a vehicle, and of other values of it
MAX_PLACE = 10_000.0  # [m] from the origin


Loop = Annotated[tuple[Point, ...], Meta(min_length=2, description="2 or more points [x, y]")]
Speed = Annotated[float, Meta(gt=0.0, le=MAX_SPEED)]
Extent = Annotated[float, Meta(gt=0.0, le=MAX_EXTENT)]


class WalkerSpec(Schema):
    """A person who walks in a loop, yields to nobody, and does not step into a standing robot."""

    name: Name  # as collisions name it
    # points in map; from the last one the walker goes to the first. Two points are walked to and
    # fro
    path: Loop
    speed: Speed = 0.8  # [m/s]
    radius: Positive = 0.25  # [m] of the cylinder that stands for the body
    height: Positive = 1.7  # [m] of it
    pause: NotNegative = 1.0  # [s] mean stay at each point of the path
    start: NotNegative | None = None  # [m] along the path; None: drawn from the seed
    step_length: Positive = 0.3  # [m] ahead that must be free of robots that stand
    patience: Positive = 3.0  # [s] of waiting for one, then the walker turns round

    def __post_init__(self) -> None:
        with located(self.name):
            check_fields(self)
            _check_path(self.path)


class VehicleSpec(Schema):
    """A forklift or the like: a box that drives round a loop, backwards after a sharp corner."""

    name: Name  # as collisions name it
    # points in map of its middle; from the last one it drives to the first. Two points are driven
    # to and fro. It turns on the spot at points, by a right angle at most
    path: Loop
    length: Extent = 2.2  # [m]
    width: Extent = 1.1  # [m]
    height: Extent = 2.0  # [m]
    speed: Speed = 1.0  # [m/s]
    turn_speed: Extent = 0.6  # [rad/s]
    pause: NotNegative = 3.0  # [s] mean stay at each point of the path
    start: NotNegative | None = None  # [m] along the path; None: drawn from the seed
    step_length: Extent = 1.0  # [m] ahead that must be free of robots that stand
    patience: Extent = 5.0  # [s] of waiting for one, then the vehicle turns round

    def __post_init__(self) -> None:
        with located(self.name):
            check_fields(self)
            _check_path(self.path)

    @property
    def radius(self) -> float:
        """[m] of the circle around it."""
        return math.hypot(self.length, self.width) / 2.0


@dataclass(frozen=True, slots=True)
class Actors:
    """Everybody in an actors file."""

    walkers: tuple[WalkerSpec, ...] = ()
    vehicles: tuple[VehicleSpec, ...] = ()


class ActorsFile(Schema):
    """Content of the file; an actor without a name gets one by its number."""

    walkers: tuple[WalkerSpec, ...] | None = None
    forklifts: tuple[VehicleSpec, ...] | None = None


def load_actors(path: str | Path) -> Actors:
    """Return the actors in a file with lists `walkers:` and `forklifts:`."""
    file = read(Path(path), ActorsFile, prepare=_with_names)
    actors = Actors(file.walkers or (), file.forklifts or ())
    check_names([*actors.walkers, *actors.vehicles], str(path))
    return actors


def _with_names(data: dict[str, Any]) -> dict[str, Any]:
    return {
        kind: [
            {"name": f"{kind.removesuffix('s')}_{number}"} | item
            if isinstance(item, dict)
            else item
            for number, item in enumerate(items, 1)
        ]
        if isinstance(items, list)
        else items
        for kind, items in data.items()
    }


def check_names(specs: Sequence[WalkerSpec | VehicleSpec], where: str) -> None:
    """Refuse a name that occurs twice.

    Raises:
        ConfigError: Naming it.
    """
    names = [spec.name for spec in specs]
    for name in names:
        if names.count(name) > 1:
            raise ConfigError(f"{where}: the name '{name}' occurs twice")


def _check_path(path: Loop) -> None:
    for index, (x, y) in enumerate(path):
        if math.dist((x, y), path[index - 1]) < 0.1:
            raise ConfigError(f"path[{index}] ({x}, {y}) repeats the one before")
        if max(abs(x), abs(y)) > MAX_PLACE:
            raise ConfigError(f"path[{index}] ({x}, {y}) is beyond {MAX_PLACE:g} m")
