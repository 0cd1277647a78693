"""Random halls and what robots do in them, all from one seed: rooms, doors, aisles, stations.

Nobody tunes the navigators to these halls. A hall is valid: its stations are places that the
widest robot reaches, the robots have room, and no goal lies where a dead robot stands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from swarm_common.model.records import Pose
from swarm_common.model.shapes import Box, Part, transform_from_xyz_rpy
from swarm_common.model.sites import Sites
from swarm_describe.worlds.actors import WalkerSpec
from swarm_describe.worlds.scene import Body, Scene

SIDES = (10.0, 30.0)  # [m] of a hall
DOORS = (0.8, 2.0)  # [m] wide
AISLES = (0.9, 2.5)  # [m] wide
WALL_WIDTH = 0.1  # [m]
FLOOR = 3.2  # [m²] of floor that a robot's centre may be on, per robot
Rectangle = tuple[float, float, float, float]


@dataclass(slots=True)
class Hall:
    """A hall from (0, 0) to (width, height), and what happens in it; lists: an entry per robot."""

    width: float
    height: float
    # inner walls, racks, pillars (x_min, y_min, x_max, y_max)
    boxes: list[Rectangle] = field(default_factory=list)
    stations: list[Pose] = field(default_factory=list)  # where goals are
    homes: list[Pose] = field(default_factory=list)
    # of each robot, in order; none of a dead one
    goals: list[list[Pose]] = field(default_factory=list)
    mission: str = ""  # what kind of goals these are
    dead: int = 0  # number of robots, the last ones, that never do anything
    walkers: tuple[WalkerSpec, ...] = ()  # people

    def scene(self) -> Scene:
        """Return the walls as a world, with the stations."""
        w, h, t = self.width, self.height, WALL_WIDTH
        outer = [(-t, -t, w + t, 0.0), (-t, h, w + t, h + t), (-t, 0.0, 0.0, h), (w, 0.0, w + t, h)]
        bodies = []
        for index, (x0, y0, x1, y1) in enumerate([*outer, *self.boxes]):
            part = Part(Box((x1 - x0, y1 - y0, 1.0)), np.eye(4))
            place = transform_from_xyz_rpy((x0 + x1) / 2, (y0 + y1) / 2, 0.5, 0.0, 0.0, 0.0)
            bodies.append(Body(f"wall_{index}::link", place, (part,)))
        names = {f"station_{number}": pose for number, pose in enumerate(self.stations, 1)}
        return Scene("hall", Path("."), tuple(bodies), Sites(stations=names))


def draw_walls(rng: np.random.Generator, robots: int) -> Hall:
    """Return a hall with rooms, racks, alcoves and pillars, without stations and robots.

    Args:
        rng: Random numbers; equal states give equal halls.
        robots: Number for which there is to be floor.
    """
    least = max(SIDES[0], math.sqrt(robots * FLOOR * 1.6))
    width, height = np.round(rng.uniform(least, SIDES[1] if robots > 12 else 20.0, 2), 1).tolist()
    hall = Hall(width, height)
    rooms = _divide(hall, (0.0, 0.0, width, height), rng, int(rng.integers(1, 4)))
    for room in rooms:
        kind = rng.random()
        if kind < 0.35:
            _put_racks(hall, room, rng)
        elif kind < 0.6:
            _put_alcoves(hall, room, rng)
        elif kind < 0.85:
            _put_pillars(hall, room, rng)
    return hall


def _divide(hall: Hall, room: Rectangle, rng: np.random.Generator, depth: int) -> list[Rectangle]:
    """Divide a room by walls with one or two doors; return the rooms."""
    x0, y0, x1, y1 = room
    is_upright = x1 - x0 >= y1 - y0
    low, high = (x0, x1) if is_upright else (y0, y1)
    if depth == 0 or high - low < 7.0:
        return [room]
    cut = round(float(rng.uniform(low + 3.0, high - 3.0)), 1)
    first, last = (y0, y1) if is_upright else (x0, x1)
    start = first
    for piece in np.array_split(np.linspace(first, last, 13), int(rng.integers(1, 3))):
        door = round(float(rng.uniform(*DOORS)), 2)
        at = round(
            float(rng.uniform(piece[0] + 0.3, max(piece[0] + 0.4, piece[-1] - door - 0.3))), 2
        )
        _put(hall, _span(is_upright, cut, start, at))
        start = at + door
    _put(hall, _span(is_upright, cut, start, last))
    half = WALL_WIDTH / 2
    sides = (
        ((x0, y0, cut - half, y1), (cut + half, y0, x1, y1))
        if is_upright
        else ((x0, y0, x1, cut - half), (x0, cut + half, x1, y1))
    )
    return [inner for side in sides for inner in _divide(hall, side, rng, depth - 1)]


def _span(is_upright: bool, cut: float, start: float, end: float) -> Rectangle:
    half = WALL_WIDTH / 2
    if is_upright:
        return cut - half, start, cut + half, end
    return start, cut - half, end, cut + half


def _put(hall: Hall, box: Rectangle) -> None:
    x0, y0, x1, y1 = (round(value, 3) for value in box)
    if x1 - x0 > 0.02 and y1 - y0 > 0.02:
        hall.boxes.append((x0, y0, x1, y1))


def _put_racks(hall: Hall, room: Rectangle, rng: np.random.Generator) -> None:
    """Fill a room with racks that leave aisles, some of them closed at one end."""
    x0, y0, x1, y1 = room
    is_upright = rng.random() < 0.5
    low, high, first, last = (x0, x1, y0, y1) if is_upright else (y0, y1, x0, x1)
    at = low + float(rng.uniform(*AISLES))
    while at + 0.4 + AISLES[0] < high:
        depth = float(rng.uniform(0.4, 0.8))
        head, tail = rng.uniform(*AISLES, 2).tolist()
        if rng.random() < 0.25:
            head = 0.0
        if last - first - head - tail > 1.0 and at + depth + AISLES[0] < high:
            span = (first + head, last - tail)
            _put(
                hall,
                (at, span[0], at + depth, span[1])
                if is_upright
                else (span[0], at, span[1], at + depth),
            )
        at += depth + float(rng.uniform(*AISLES))


def _put_alcoves(hall: Hall, room: Rectangle, rng: np.random.Generator) -> None:
    """Put short walls at the sides of a room that make alcoves."""
    x0, y0, x1, y1 = room
    for _ in range(int(rng.integers(2, 5))):
        deep = float(rng.uniform(0.6, 1.4))
        wide = float(rng.uniform(0.9, 1.6))
        if min(x1 - x0, y1 - y0) < 2.0 * deep + 2.5 or min(x1 - x0, y1 - y0) < wide + 2.5:
            continue
        side = int(rng.integers(4))
        if side < 2:
            at = float(rng.uniform(x0 + 0.9, x1 - wide - 0.9))
            base = (y0, y0 + deep) if side == 0 else (y1 - deep, y1)
            for x in (at, at + wide):
                _put(hall, (x, base[0], x + WALL_WIDTH, base[1]))
        else:
            at = float(rng.uniform(y0 + 0.9, y1 - wide - 0.9))
            base = (x0, x0 + deep) if side == 2 else (x1 - deep, x1)
            for y in (at, at + wide):
                _put(hall, (base[0], y, base[1], y + WALL_WIDTH))


def _put_pillars(hall: Hall, room: Rectangle, rng: np.random.Generator) -> None:
    x0, y0, x1, y1 = room
    for _ in range(int(rng.integers(2, 9))):
        side = float(rng.uniform(0.2, 0.5))
        x, y = rng.uniform((x0 + 0.9, y0 + 0.9), (x1 - side - 0.9, y1 - side - 0.9)).tolist()
        _put(hall, (x, y, x + side, y + side))
