"""Floor plans in YAML: walls as lines, boxes, posts, and named places, to make a world from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise, product
from pathlib import Path
from typing import Any

from swarm_common.files.yaml_io import check_keys, name_in, number, numbers, read_yaml, yaw_number
from swarm_common.model.errors import ConfigError
from swarm_describe.worlds.scene import Box, Color, Cylinder

KEYS = ("name", "wall_thickness", "wall_height", "wall_color", "walls", "boxes", "posts")
NAMES = ("name", "walls.*.name", "boxes.*.name", "posts.*.name")  # texts as written
SITE_KEYS = ("stations", "circuits", "spawn", "spawns", "places", "zones")
COPY_KEYS = ("name", "at", "z", "color", "mass", "friction", "repeat")  # of boxes and posts
WALL_COLOR: Color = (0.75, 0.75, 0.75, 1.0)
BOX_COLOR: Color = (0.6, 0.42, 0.25, 1.0)
LIMIT = 1000.0  # [m] of lengths and places
MOST = 20_000  # things in a plan


@dataclass(frozen=True, slots=True)
class Thing:
    """A body on the floor."""

    name: str  # of its model
    shape: Box | Cylinder
    x: float  # [m]
    y: float  # [m]
    z: float = 0.0  # [m] of its underside
    yaw: float = 0.0  # [rad]
    color: Color = BOX_COLOR
    mass: float | None = None  # [kg]; None if it can never move
    friction: float = 0.5  # against the floor, of things that can move


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """Content of a plan: things, and sites as `sites.yaml` has them; `notes` are for its author."""

    name: str
    things: tuple[Thing, ...]
    sites: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def load_plan(path: Path) -> FloorPlan:
    """Return the plan in a YAML file; docs/creating.md describes the format."""
    data = read_yaml(path, as_written=NAMES)
    check_keys(data, (*KEYS, *SITE_KEYS), str(path))
    things = [*_walls(data, path), *_boxes(data, path), *_posts(data, path)]
    names = [thing.name for thing in things]
    doubles = {name for name in names if names.count(name) > 1} if len(names) < MOST else set()
    if len(names) >= MOST or doubles:
        reason = f"the names {', '.join(sorted(doubles))} occur twice" if doubles else "too large"
        raise ConfigError(f"{path}: {len(names)} things; {reason}")
    sites = {key: data[key] for key in SITE_KEYS if data.get(key) is not None}
    if "stations" in sites:
        sites["stations"] = _stations(sites["stations"], f"{path}: stations")
    name = path.stem if data.get("name") is None else data["name"]
    if not name.replace("_", "").replace("-", "").isalnum():
        raise ConfigError(f"{path}: name is '{name}'; expected letters, digits, _ and -")
    return FloorPlan(name, tuple(things), sites)


def _walls(data: Mapping[str, Any], path: Path) -> Iterator[Thing]:
    """Return a box for each piece of each line; corners are filled by making pieces overlap."""
    thickness = _length(data.get("wall_thickness", 0.15), f"{path}: wall_thickness")
    height = _length(data.get("wall_height", 2.5), f"{path}: wall_height")
    color = _color(data.get("wall_color"), WALL_COLOR, f"{path}: wall_color")
    for index, item in enumerate(_items(data, "walls", path)):
        where = f"{path}: walls[{index}]"
        check_keys(item, ("name", "points", "closed", "thickness", "height", "color"), where)
        width = _length(item.get("thickness", thickness), f"{where}.thickness")
        tall = _length(item.get("height", height), f"{where}.height")
        points = item.get("points")
        if not isinstance(points, list) or len(points) < 2:
            raise ConfigError(f"{where}.points is {points!r}; expected 2 or more points [x, y]")
        line = [_place(point, 2, f"{where}.points[{i}]") for i, point in enumerate(points)]
        if not isinstance(closed := item.get("closed", False), bool):
            raise ConfigError(f"{where}.closed is {closed!r}; expected true or false")
        if closed:
            line.append(line[0])
        name = name_in(item.get("name", f"wall_{index + 1}"), f"{where}.name")
        for piece, ((x0, y0), (x1, y1)) in enumerate(pairwise(line)):
            length = math.hypot(x1 - x0, y1 - y0)
            if length < 1e-3:
                raise ConfigError(f"{where}.points[{piece + 1}] repeats the one before")
            yield Thing(
                name if len(line) == 2 else f"{name}_{piece + 1}",
                Box((rounded(length + width), width, tall)),
                rounded((x0 + x1) / 2.0),
                rounded((y0 + y1) / 2.0),
                yaw=math.atan2(y1 - y0, x1 - x0),
                color=_color(item.get("color"), color, f"{where}.color"),
            )


def _boxes(data: Mapping[str, Any], path: Path) -> Iterator[Thing]:
    for index, item in enumerate(_items(data, "boxes", path)):
        where = f"{path}: boxes[{index}]"
        check_keys(item, (*COPY_KEYS, "size"), where)
        sizes = numbers(item.get("size"), 3, f"{where}.size [x, y, z]")
        x, y, z = (_length(value, f"{where}.size") for value in sizes)
        yield from _copies(item, f"box_{index + 1}", Box((x, y, z)), where)


def _posts(data: Mapping[str, Any], path: Path) -> Iterator[Thing]:
    for index, item in enumerate(_items(data, "posts", path)):
        where = f"{path}: posts[{index}]"
        check_keys(item, (*COPY_KEYS, "radius", "height"), where)
        radius = _length(item.get("radius"), f"{where}.radius")
        height = _length(item.get("height", 2.5), f"{where}.height")
        yield from _copies(item, f"post_{index + 1}", Cylinder(radius, height), where)


def _copies(
    item: Mapping[str, Any], default: str, shape: Box | Cylinder, where: str
) -> Iterator[Thing]:
    name = name_in(item.get("name", default), f"{where}.name")
    at = item.get("at")
    count = len(at) if isinstance(at, list) and len(at) in (2, 3) else 2
    x, y, turn = (*_place(at, count, f"{where}.at [x, y, yaw]"), 0.0)[:3]
    mass = item.get("mass")
    thing: dict[str, Any] = {
        "z": number(item.get("z", 0.0), f"{where}.z"),
        "yaw": yaw_number(turn, f"{where}.at"),
        "color": _color(item.get("color"), BOX_COLOR, f"{where}.color"),
        "mass": None if mass is None else _length(mass, f"{where}.mass"),
        "friction": number(item.get("friction", 0.5), f"{where}.friction"),
    }
    for suffix, dx, dy in _repeated(item.get("repeat"), where):
        yield Thing(f"{name}{suffix}", shape, rounded(x + dx), rounded(y + dy), **thing)


def _stations(value: object, where: str) -> dict[str, list[float]]:
    """Return stations by name; `{at: [x, y, yaw], repeat: [...]}` stands for a row of them."""
    if not isinstance(value, dict):
        raise ConfigError(f"{where} is {value!r}; expected 'name: [x, y, yaw]' lines")
    stations: dict[str, list[float]] = {}
    for name, item in value.items():
        what = f"{where}.{name_in(name, where)}"
        given = item if isinstance(item, dict) else {"at": item}
        check_keys(given, ("at", "repeat"), what)
        x, y, turn = _place(given.get("at"), 3, f"{what} [x, y, yaw]")
        yaw_number(turn, what)
        for suffix, dx, dy in _repeated(given.get("repeat"), what):
            if f"{name}{suffix}" in stations:
                raise ConfigError(f"{what}: the name '{name}{suffix}' occurs twice")
            stations[f"{name}{suffix}"] = [rounded(x + dx), rounded(y + dy), turn]
    return stations


def _repeated(value: object, where: str) -> Iterator[tuple[str, float, float]]:
    """Return name suffix and offset of each copy: the last of the steps [count, dx, dy] first."""
    if value is None:
        yield "", 0.0, 0.0
        return
    if not isinstance(value, list) or not value:
        raise ConfigError(f"{where}.repeat is {value!r}; expected a list of [count, dx, dy]")
    what = f"{where}.repeat [count, dx, dy]"
    steps = [numbers(item, 3, what) for item in value]
    total = math.prod(step[0] for step in steps)
    if any(step[0] != int(step[0]) or step[0] < 1 for step in steps) or total > MOST:
        raise ConfigError(f"{where}.repeat is {value!r}; expected counts from 1 to {MOST} in all")
    ranges = [range(int(step[0])) for step in steps]
    for index, turn in enumerate(product(*ranges), 1):
        pairs = list(zip(turn, steps, strict=True))
        dx, dy = (sum(times * step[axis] for times, step in pairs) for axis in (1, 2))
        yield f"_{index}", dx, dy


def _items(data: Mapping[str, Any], key: str, path: Path) -> list[dict[str, Any]]:
    value = [] if data.get(key) is None else data[key]
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise ConfigError(f"{path}: {key} is {value!r}; expected a list of {{...}} items")
    return value


def _place(value: object, count: int, what: str) -> tuple[float, ...]:
    place = numbers(value, count, what)
    if max(abs(item) for item in place[:2]) > LIMIT:
        raise ConfigError(f"{what} is {value!r}; expected places within {LIMIT:g} m")
    return place


def _length(value: object, what: str) -> float:
    length = number(value, what)
    if not 1e-3 <= length <= LIMIT:
        raise ConfigError(f"{what} is {length:g}; expected 0.001 to {LIMIT:g}")
    return length


def _color(value: object, default: Color, what: str) -> Color:
    if value is None:
        return default
    count = len(value) if isinstance(value, list) and len(value) in (3, 4) else 3
    parts = numbers(value, count, f"{what} [red, green, blue] from 0 to 1")
    red, green, blue, alpha = (min(1.0, max(0.0, part)) for part in (*parts, 1.0)[:4])
    return red, green, blue, alpha


def rounded(value: float) -> float:
    """Return a length [m] as worlds have it: to the micrometre, and never -0."""
    return round(float(value), 6) + 0.0
