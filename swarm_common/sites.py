"""Named places of a world: stations, holding circuits and the spawn area (`sites.yaml`)."""

from __future__ import annotations

from dataclasses import dataclass, field

from swarm_common.records import Pose


@dataclass(frozen=True, slots=True)
class SpawnArea:
    """Rectangle in the map frame in which robots start, on a lattice of `pitch`."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float
    pitch: float = 1.0
    yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class Sites:
    """What `worlds/<name>/sites.yaml` says.

    Attributes:
        stations: Pose in the map frame of each station by name, in file order.
        circuits: Closed polylines [(x, y), ...] by name, in driving order.
        spawn: Where robots start; None lets the world choose free places.
    """

    stations: dict[str, Pose] = field(default_factory=dict)
    circuits: dict[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    spawn: SpawnArea | None = None
