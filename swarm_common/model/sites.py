"""Named places of a world: stations, circuits, spawns, places and zones (`sites.yaml`)."""

from __future__ import annotations

from dataclasses import dataclass, field

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose
from swarm_common.model.schema import Positive, Yaw
from swarm_common.model.zones import NO_ZONES, Zones


@dataclass(frozen=True, slots=True)
class SpawnArea:
    """Rectangle in the map frame in which robots start, on a lattice of `pitch`."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float
    pitch: Positive = 1.0
    yaw: Yaw = 0.0

    def __post_init__(self) -> None:
        if self.x_max < self.x_min or self.y_max < self.y_min:
            raise ConfigError(f"it is empty: {self}; expected x_min <= x_max, y_min <= y_max")


@dataclass(frozen=True, slots=True)
class SpawnAreas:
    """Several areas: robots are dealt to them in turn, the first to the first area."""

    areas: tuple[SpawnArea, ...]


@dataclass(frozen=True, slots=True)
class SpawnCircle:
    """Circle in the map frame on which robots start, evenly spaced and facing its centre."""

    x: float
    y: float
    radius: Positive


Spawn = SpawnArea | SpawnAreas | SpawnCircle


@dataclass(frozen=True, slots=True)
class Sites:
    """Content of `worlds/<name>/sites.yaml`.

    Attributes:
        stations: Pose in the map frame of each station by name, in file order.
        circuits: Closed polylines [(x, y), ...] by name, in driving order.
        spawn: Places where robots start; None lets the world choose free places.
        spawns: Other starts, which a mission may ask for by name.
        places: Poses in the map frame to which missions send robots at random.
        zones: Zones where robots may not be, or not be fast.
        charging: Names of the stations that charge robots which stand there.
        groups: Names of stations by the name of their group, for orders.
    """

    stations: dict[str, Pose] = field(default_factory=dict)
    circuits: dict[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    spawn: Spawn | None = None
    spawns: dict[str, Spawn] = field(default_factory=dict)
    places: tuple[Pose, ...] = ()
    zones: Zones = NO_ZONES
    charging: tuple[str, ...] = ()
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def chargers(self) -> dict[str, Pose]:
        """The charging stations by name."""
        return {name: self.stations[name] for name in self.charging}

    @property
    def work_stations(self) -> tuple[str, ...]:
        """Names of the stations that do not charge."""
        return tuple(name for name in self.stations if name not in self.charging)

    def spawn_named(self, name: str) -> Spawn | None:
        """Return a start by name; the default one for an empty name.

        Args:
            name: Key of `spawns`; empty for `spawn`.
        """
        if not name:
            return self.spawn
        if name not in self.spawns:
            raise UnknownNameError("spawn", name, self.spawns, "sites.yaml")
        return self.spawns[name]


def area_count(spawn: Spawn | None) -> int:
    """Return the number of areas that robots are dealt to in turn."""
    return len(spawn.areas) if isinstance(spawn, SpawnAreas) else 1
