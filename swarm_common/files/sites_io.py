"""Reading of `sites.yaml`: stations, holding circuits, spawns, places and zones of a world."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarm_common.files.yaml_io import (
    check_keys,
    field_values,
    name_in,
    numbers,
    pose_numbers,
    read_yaml,
    yaw_number,
)
from swarm_common.files.zones_io import parse_zones
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites, Spawn, SpawnArea, SpawnAreas, SpawnCircle
from swarm_common.model.zones import keepout_area

SECTIONS = (
    "description", "stations", "circuits", "spawn", "spawns", "places", "charging", "zones",
    "groups",
)  # fmt: skip


def load_sites(path: str | Path, masks: Mapping[str, Path] | None = None) -> Sites:
    """Return the sites in a file, which may name none.

    Args:
        path: YAML file; with masks it may be missing.
        masks: Filter masks by their key in `zones:`, which replace those of the file.
    """
    path = Path(path)
    data = (
        read_yaml(path, may_be_empty=True, as_written=("charging.*", "groups.*.*"))
        if not masks or path.is_file()
        else {}
    )
    check_keys(data, SECTIONS, str(path))
    stations = _section(data, "stations", path)
    circuits = _section(data, "circuits", path)
    sites = Sites(
        stations={
            name: Pose(*pose_numbers(value, f"{path}: stations.{name}"))
            for name, value in stations.items()
        },
        circuits={
            name: _circuit(value, f"{path}: circuits.{name}") for name, value in circuits.items()
        },
        spawn=None if data.get("spawn") is None else parse_spawn(data["spawn"], f"{path}: spawn"),
        spawns={
            name: parse_spawn(value, f"{path}: spawns.{name}")
            for name, value in _section(data, "spawns", path).items()
        },
        places=_places(data.get("places"), f"{path}: places"),
        zones=parse_zones(data.get("zones"), path, masks or {}),
        charging=_some_stations(data.get("charging") or [], [*stations], f"{path}: charging"),
        groups={
            name: _some_stations(value, [*stations], f"{path}: groups.{name}")
            for name, value in _section(data, "groups", path).items()
        },
    )
    if sites.zones.has_keepout:
        _check_free(sites, str(path))
    return sites


def _check_free(sites: Sites, where: str) -> None:
    """Raise ConfigError for the first place that robots are sent to and may not be at."""
    named = {f"station '{name}'": pose for name, pose in sites.stations.items()}
    named |= {f"place {i}": pose for i, pose in enumerate(sites.places, 1)}
    for name, pose in named.items():
        if zone := sites.zones.keepout_at(pose.x, pose.y):
            raise ConfigError(
                f"{where}: {name} at ({pose.x:g}, {pose.y:g}) lies in {zone}; no robot may go"
                " there: move one of them"
            )
    area = keepout_area(sites.zones)
    for name, outline in _outlines(sites):
        is_closed = area.contains if name.startswith("spawn") else area.intersects
        if is_closed(outline):
            x, y = area.intersection(outline).representative_point().coords[0]
            zone = sites.zones.keepout_at(x, y) or "a keepout zone"
            what = "lies wholly in" if name.startswith("spawn") else "leads through"
            raise ConfigError(
                f"{where}: {name} {what} {zone} at ({x:g}, {y:g}), where no robot may be:"
                " move one of them"
            )


def _outlines(sites: Sites) -> list[tuple[str, Any]]:
    """Return circuits, and the areas and circles where robots start, as shapes."""
    import shapely

    found = [(f"circuit '{name}'", shapely.LinearRing(c)) for name, c in sites.circuits.items()]
    spawns = {f"spawns.{name}": spawn for name, spawn in sites.spawns.items()}
    for name, spawn in ({"spawn": sites.spawn} | spawns).items():
        if isinstance(spawn, SpawnCircle):
            found.append((name, shapely.Point(spawn.x, spawn.y).buffer(spawn.radius).exterior))
        elif spawn is not None:
            areas = spawn.areas if isinstance(spawn, SpawnAreas) else (spawn,)
            found += [(name, shapely.box(a.x_min, a.y_min, a.x_max, a.y_max)) for a in areas]
    return found


def _section(data: dict[str, Any], name: str, path: Path) -> dict[str, Any]:
    section = {} if data.get(name) is None else data[name]
    if not isinstance(section, dict):
        raise ConfigError(f"{path}: {name} is {section!r}; expected 'name: value' lines")
    for key in section:
        name_in(key, f"{path}: {name}")
    return section


def _circuit(value: object, what: str) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list) or len(value) < 3:
        raise ConfigError(f"{what} is {value!r}; expected a list of at least 3 points [x, y]")
    points = [numbers(point, 2, f"{what}[{index}]") for index, point in enumerate(value)]
    return tuple((x, y) for x, y in points)


def _places(value: object, what: str) -> tuple[Pose, ...]:
    if value is None:
        return ()
    if not isinstance(value, list):
        raise ConfigError(f"{what} is {value!r}; expected a list of poses [x, y, yaw]")
    return tuple(Pose(*pose_numbers(item, f"{what}[{i}]")) for i, item in enumerate(value))


def _some_stations(value: object, stations: list[str], what: str) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise ConfigError(f"{what} is {value!r}; expected a list of stations, like [station_1]")
    names = tuple(dict.fromkeys(map(str, value)))
    for name in names:
        if name not in stations:
            raise UnknownNameError("station", name, stations, what)
    return names


def parse_spawn(value: object, what: str) -> Spawn:
    """Return a spawn: an area, a list of areas, or a circle."""
    if isinstance(value, list) and value:
        return SpawnAreas(tuple(_area(item, f"{what}[{i}]") for i, item in enumerate(value)))
    if isinstance(value, dict) and "radius" in value:
        return _circle(value, what)
    return _area(value, what)


def _circle(value: dict[str, Any], what: str) -> SpawnCircle:
    circle = SpawnCircle(**field_values(SpawnCircle, value, what))
    if circle.radius <= 0.0:
        raise ConfigError(f"{what}.radius is {circle.radius} m; it must be positive")
    return circle


def _area(value: object, what: str) -> SpawnArea:
    area = SpawnArea(**field_values(SpawnArea, value, what))
    yaw_number(area.yaw, what)
    if area.x_max < area.x_min or area.y_max < area.y_min or area.pitch <= 0.0:
        raise ConfigError(f"{what} is empty: {area}; expected x_min <= x_max, y_min <= y_max")
    return area
