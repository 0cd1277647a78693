"""Reading of `sites.yaml`: stations, holding circuits, spawns, places and zones of a world."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from swarm_common.files.convert import convert, read
from swarm_common.files.zones_io import Mask, Masks, ZonesEntry, make_zones, with_lanes
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose
from swarm_common.model.schema import Name, Polygon, PoseNumbers, Schema, told
from swarm_common.model.sites import Sites, Spawn, SpawnArea, SpawnAreas, SpawnCircle
from swarm_common.model.zones import keepout_area

Stations = Annotated[tuple[str, ...], told("a list of stations, like [station_1]")]
Places = Annotated[tuple[PoseNumbers, ...], told("a list of poses [x, y, yaw]")]


class SitesFile(Schema):
    """Content of the file."""

    description: str | None = None
    stations: dict[Name, PoseNumbers] | None = None
    circuits: dict[Name, Polygon] | None = None
    spawn: Any = None
    spawns: dict[Name, Any] | None = None
    places: Places | None = None
    charging: Stations | None = None
    zones: ZonesEntry | None = None
    lanes: Mask | None = None  # likewise `zones.lanes`
    groups: dict[Name, Stations] | None = None

    def __post_init__(self) -> None:
        if self.lanes is not None and self.zones is not None and self.zones.lanes is not None:
            raise ConfigError("lanes: zones names lanes, too; expected one of them")
        stations = self.stations or {}
        named = {"charging": self.charging or ()}
        named |= {f"groups.{name}": names for name, names in (self.groups or {}).items()}
        for key, names in named.items():
            for name in names:
                if name not in stations:
                    raise UnknownNameError("station", name, stations, key)


def load_sites(path: str | Path, masks: Masks | None = None) -> Sites:
    """Return the sites in a file, which may name none.

    Args:
        path: YAML file; with masks it may be missing.
        masks: Filter masks by their key in `zones:`, which replace those of the file.
    """
    path = Path(path)
    is_there = not masks or path.is_file()
    file = read(path, SitesFile, may_be_empty=True) if is_there else SitesFile()
    sites = Sites(
        stations={name: Pose(*pose) for name, pose in (file.stations or {}).items()},
        circuits=file.circuits or {},
        spawn=None if file.spawn is None else parse_spawn(file.spawn, f"{path}: spawn"),
        spawns={
            name: parse_spawn(value, f"{path}: spawns.{name}")
            for name, value in (file.spawns or {}).items()
        },
        places=tuple(Pose(*pose) for pose in file.places or ()),
        zones=make_zones(with_lanes(file.zones, file.lanes), path, masks or {}),
        charging=tuple(dict.fromkeys(file.charging or ())),
        groups={name: tuple(dict.fromkeys(names)) for name, names in (file.groups or {}).items()},
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


def parse_spawn(value: object, what: str) -> Spawn:
    """Return a spawn: an area, a list of areas, or a circle."""
    if isinstance(value, list) and value:
        return SpawnAreas(convert(value, tuple[SpawnArea, ...], what))
    if isinstance(value, dict) and "radius" in value:
        return convert(value, SpawnCircle, what)
    return convert(value, SpawnArea, what)
