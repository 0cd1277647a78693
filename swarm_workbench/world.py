"""Worlds: those that come along or lie in a file, and new ones from walls, boxes and stations."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import yaml

from swarm_common.files.map_io import load_map, map_of_world
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds import reader
from swarm_describe.worlds.scene import Scene
from swarm_describe.worlds.world_file import find_world
from swarm_sim.maps.draw_map import draw_world, reach_of

WORLD_FILE, SITES_FILE = "world.sdf", "sites.yaml"
HEIGHT = 1.0  # [m] of walls and boxes
THICKNESS = 0.1  # [m] of walls
MAPPED_BY = "turtlebot3_waffle"  # at the height of its LiDAR the map is drawn
Line = Sequence[float]  # x, y of both ends [m]
Rectangle = Sequence[float]  # x, y of the centre, width, depth [m]


@dataclass(frozen=True)
class World:
    """A world file with what lies beside it.

    Attributes:
        name: Name of its folder.
        file: The world file.
        stations: Poses in map by name.
    """

    name: str
    file: Path
    stations: Mapping[str, Pose]

    @functools.cached_property
    def scene(self) -> Scene:
        """Bodies, sites and people, as the simulator reads them."""
        return reader.load_world(str(self.file))

    @functools.cached_property
    def map(self) -> Grid:
        """Occupancy; the map file that comes with the world, or drawn from its bodies."""
        path = map_of_world(self.file)
        if path is not None:
            return load_map(path).upright()
        spec = load_robot(MAPPED_BY)
        return draw_world(self.scene, spec.lidar.z, reach=reach_of([spec]))

    @classmethod
    def create(
        cls,
        folder: str | Path,
        *,
        walls: Iterable[Line] = (),
        boxes: Iterable[Rectangle] = (),
        stations: Mapping[str, Sequence[float]] | None = None,
    ) -> World:
        """Write a new world into a folder and return it.

        Args:
            walls: x, y of both ends [m] of each.
            boxes: x, y of the centre, width and depth [m] of each.
            stations: x, y [m], yaw [rad] in map by name.

        Raises:
            ConfigError: If a number is missing or not finite, or the folder cannot be written.
        """
        path = Path(folder).absolute()
        bodies = [_wall(f"wall_{i}", line) for i, line in enumerate(walls, 1)]
        bodies += [_box(f"box_{i}", box) for i, box in enumerate(boxes, 1)]
        places = {
            name: _numbers(f"station {name}", pose, 3) for name, pose in (stations or {}).items()
        }
        text = f"<sdf version='1.9'><world name={quoteattr(path.name)}>{''.join(bodies)}"
        try:
            path.mkdir(parents=True, exist_ok=True)
            (path / WORLD_FILE).write_text(f"{text}</world></sdf>\n", encoding="utf-8")
            sites = yaml.safe_dump({"stations": places}, sort_keys=False)
            (path / SITES_FILE).write_text(sites, encoding="utf-8")
        except OSError as error:
            raise ConfigError(f"cannot write the world {path}: {error.strerror}") from None
        return load_world(path)


def load_world(name_or_path: str | Path) -> World:
    """Return a world by name, or from a file or folder.

    Raises:
        SwarmError: If there is no such world, or its files are unusable.
    """
    file = find_world(str(name_or_path)).absolute()
    scene = reader.load_world(str(file))
    world = World(scene.name, file, dict(scene.sites.stations))
    world.__dict__["scene"] = scene
    return world


def _wall(name: str, line: Line) -> str:
    x0, y0, x1, y1 = _numbers(name, line, 4)
    length = math.hypot(x1 - x0, y1 - y0) + THICKNESS
    yaw = math.atan2(y1 - y0, x1 - x0)
    return _body(name, 0.5 * (x0 + x1), 0.5 * (y0 + y1), yaw, length, THICKNESS)


def _box(name: str, box: Rectangle) -> str:
    x, y, width, depth = _numbers(name, box, 4)
    if min(width, depth) <= 0.0:
        raise ConfigError(f"{name} is {width} m by {depth} m; both must be positive")
    return _body(name, x, y, 0.0, width, depth)


def _body(name: str, x: float, y: float, yaw: float, width: float, depth: float) -> str:
    geometry = f"<geometry><box><size>{width} {depth} {HEIGHT}</size></box></geometry>"
    return (
        f"<model name='{name}'><static>true</static><pose>{x} {y} {HEIGHT / 2} 0 0 {yaw}</pose>"
        f"<link name='link'><collision name='body'>{geometry}</collision>"
        f"<visual name='body'>{geometry}</visual></link></model>"
    )


def _numbers(what: str, values: Sequence[float], count: int) -> list[float]:
    try:
        numbers = [float(value) for value in values]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ConfigError(f"{what} is {values!r}; expected {count} finite numbers")
    return numbers
