"""Floor plans in YAML: walls as lines, boxes, posts, and named places, to make a world from."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta

from swarm_common.files.convert import located, read
from swarm_common.model.errors import ConfigError
from swarm_common.model.schema import Count, Name, Schema, told
from swarm_common.model.shapes import Box, Color, Cylinder

SITE_KEYS = ("stations", "circuits", "spawn", "spawns", "places", "zones")
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
    layout: Mapping[str, Any] | None = None  # of a fleet control, that it was made of


def _is_plan_name(text: str) -> bool:
    return text.replace("_", "").replace("-", "").isalnum()


def _is_place(value: Sequence[float]) -> bool:
    return max(map(abs, value[:2])) <= LIMIT and abs(sum(value[2:])) <= math.tau + 1e-6


Length = Annotated[float, Meta(ge=1e-3, le=LIMIT)]
NEAR = f"within {LIMIT:g} m, yaw in radians"
Corner = Annotated[tuple[float, float], told(f"[x, y] {NEAR}", _is_place)]
Place = Annotated[
    tuple[float, ...], told(f"[x, y] or [x, y, yaw] {NEAR}", _is_place, min_length=2, max_length=3)
]
Station = Annotated[
    tuple[float, float, float], told(f"a list of 3 numbers [x, y, yaw] {NEAR}", _is_place)
]
Paint = Annotated[
    tuple[float, ...], told("[red, green, blue] from 0 to 1", min_length=3, max_length=4)
]
Step = Annotated[tuple[Count, float, float], told("[count, dx, dy]")]
Repeat = Annotated[tuple[Step, ...], told("a list of [count, dx, dy]", min_length=1)]
PlanName = Annotated[str, told("letters, digits, _ and -", _is_plan_name)]


class WallEntry(Schema):
    """A line of walls."""

    points: Annotated[tuple[Corner, ...], told("2 or more points [x, y]", min_length=2)]
    name: Name | None = None
    closed: bool = False
    thickness: Length | None = None
    height: Length | None = None
    color: Paint | None = None


class CopiedEntry(Schema):
    """Something that stands at one place, or at several."""

    at: Place
    name: Name | None = None
    z: float = 0.0
    color: Paint | None = None
    mass: Length | None = None
    friction: float = 0.5
    repeat: Repeat | None = None


class BoxEntry(CopiedEntry, kw_only=True):
    """A box."""

    size: tuple[Length, Length, Length]


class PostEntry(CopiedEntry, kw_only=True):
    """A cylinder."""

    radius: Length
    height: Length = 2.5


class StationEntry(Schema):
    """A row of stations."""

    at: Station
    repeat: Repeat | None = None


class PlanFile(Schema):
    """Content of a plan; sites are those of `sites.yaml`."""

    name: PlanName | None = None
    wall_thickness: Length = 0.15
    wall_height: Length = 2.5
    wall_color: Paint | None = None
    walls: tuple[WallEntry, ...] | None = None
    boxes: tuple[BoxEntry, ...] | None = None
    posts: tuple[PostEntry, ...] | None = None
    stations: dict[Name, Station | StationEntry] | None = None
    circuits: Any = None
    spawn: Any = None
    spawns: Any = None
    places: Any = None
    zones: Any = None


def load_plan(path: Path) -> FloorPlan:
    """Return the plan in a YAML file; docs/creating.md describes the format."""
    file = read(path, PlanFile)
    with located(path):
        things = [*_walls(file)]
        for index, box in enumerate(file.boxes or (), 1):
            things += _copies(box, f"box_{index}", Box(box.size))
        for index, post in enumerate(file.posts or (), 1):
            things += _copies(post, f"post_{index}", Cylinder(post.radius, post.height))
        names = Counter(thing.name for thing in things)
        doubles = sorted(name for name, count in names.items() if count > 1)
        if len(things) >= MOST or doubles:
            reason = f"the names {', '.join(doubles)} occur twice" if doubles else "too large"
            raise ConfigError(f"{len(things)} things; {reason}")
        sites = {key: getattr(file, key) for key in SITE_KEYS if getattr(file, key) is not None}
        if file.stations is not None:
            sites["stations"] = _stations(file.stations)
    return FloorPlan(file.name or path.stem, tuple(things), sites)


def _walls(file: PlanFile) -> Iterator[Thing]:
    """Return a box for each piece of each line; corners are filled by making pieces overlap."""
    for index, wall in enumerate(file.walls or ()):
        width = wall.thickness or file.wall_thickness
        line = [*wall.points, wall.points[0]] if wall.closed else wall.points
        name = wall.name or f"wall_{index + 1}"
        for piece, ((x0, y0), (x1, y1)) in enumerate(pairwise(line)):
            length = math.hypot(x1 - x0, y1 - y0)
            if length < 1e-3:
                raise ConfigError(f"walls[{index}].points[{piece + 1}] repeats the one before")
            yield Thing(
                name if len(line) == 2 else f"{name}_{piece + 1}",
                Box((rounded(length + width), width, wall.height or file.wall_height)),
                rounded((x0 + x1) / 2.0),
                rounded((y0 + y1) / 2.0),
                yaw=math.atan2(y1 - y0, x1 - x0),
                color=_color(wall.color or file.wall_color, WALL_COLOR),
            )


def _copies(entry: CopiedEntry, usual_name: str, shape: Box | Cylinder) -> Iterator[Thing]:
    name = entry.name or usual_name
    x, y, yaw = (*entry.at, 0.0)[:3]
    for suffix, dx, dy in _repeated(entry.repeat, name):
        yield Thing(
            f"{name}{suffix}",
            shape,
            rounded(x + dx),
            rounded(y + dy),
            z=entry.z,
            yaw=yaw,
            color=_color(entry.color, BOX_COLOR),
            mass=entry.mass,
            friction=entry.friction,
        )


def _stations(entries: Mapping[str, tuple[float, ...] | StationEntry]) -> dict[str, list[float]]:
    """Return stations by name; `{at: [x, y, yaw], repeat: [...]}` stands for a row of them."""
    stations: dict[str, list[float]] = {}
    for name, entry in entries.items():
        at, repeat = (entry.at, entry.repeat) if isinstance(entry, StationEntry) else (entry, None)
        x, y, yaw = at
        for suffix, dx, dy in _repeated(repeat, f"stations.{name}"):
            if f"{name}{suffix}" in stations:
                raise ConfigError(f"stations.{name}: the name '{name}{suffix}' occurs twice")
            stations[f"{name}{suffix}"] = [rounded(x + dx), rounded(y + dy), yaw]
    return stations


def _repeated(steps: Repeat | None, where: str) -> Iterator[tuple[str, float, float]]:
    """Return name suffix and offset of each copy: the last of the steps [count, dx, dy] first."""
    if steps is None:
        yield "", 0.0, 0.0
        return
    if math.prod(step[0] for step in steps) > MOST:
        raise ConfigError(f"{where}.repeat: expected counts from 1 to {MOST} in all")
    for index, turn in enumerate(product(*(range(step[0]) for step in steps)), 1):
        pairs = list(zip(turn, steps, strict=True))
        dx, dy = (sum(times * step[axis] for times, step in pairs) for axis in (1, 2))
        yield f"_{index}", dx, dy


def _color(paint: Paint | None, usual: Color) -> Color:
    red, green, blue, alpha = (min(1.0, max(0.0, part)) for part in (*(paint or usual), 1.0)[:4])
    return red, green, blue, alpha


def rounded(value: float) -> float:
    """Return a length [m] as worlds have it: to the micrometre, and never -0."""
    return round(float(value), 6) + 0.0
