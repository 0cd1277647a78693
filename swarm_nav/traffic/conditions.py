"""Under which conditions every robot reaches every goal, checked against a map before a run.

What follows from them, and the argument, is in docs/liveness.md. What is looked at: whether each
robot has room at its goals, and a way to them; *places*, as many as keep the distance of two robots
from each other on the floor where two robots can pass, counted on each connected floor that holds a
goal or a start; *single lanes*, where they cannot; the sides of each single lane that holds parts
of the floor together; and the robots that have goals on a single lane. The conditions are not
necessary: a run for which they do not hold starts all the same, and says so.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.grid import Grid
from swarm_common.model.records import RobotSpec
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import PlanError
from swarm_nav.planning import search_kernels
from swarm_nav.planning.cells import label
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.terrain import Lattice, Terrain, as_large_as
from swarm_nav.traffic import single_lane_kernels
from swarm_nav.traffic.lane_group import grown, lane_group
from swarm_nav.traffic.robot_state import terrain_of
from swarm_nav.traffic.single_lanes import Mask, connected_components, passing_areas

Point = tuple[float, float]
MOST_NAMED = 6  # findings that are told one by one
PLACES_PER_ROBOT = 4  # one that stands between four places takes them all


@dataclass(frozen=True, slots=True)
class Conditions:
    """Room that a map has for robots."""

    robots: int  # number asked for
    places: int  # where two robots can pass, on connected floor with goals or starts
    findings: tuple[str, ...]  # conditions that do not hold, a sentence each; empty if all hold

    @property
    def is_guaranteed(self) -> bool:
        """Whether all conditions hold: then every robot arrives, as docs/liveness.md argues."""
        return not self.findings

    def __str__(self) -> str:
        if self.is_guaranteed:
            asked = "the robot has" if self.robots == 1 else f"all {self.robots} robots have"
            room = self.places // PLACES_PER_ROBOT
            return f"{asked} room to reach every known goal (there is room for {room})"
        named = self.findings[:MOST_NAMED]
        more = len(self.findings) - len(named)
        rest = f"; and {more} more" if more else ""
        return f"no guarantee that every goal is reached: {'; '.join(named)}{rest}"


def conditions(
    robots: Sequence[tuple[RobotSpec, NavConfig]],
    grid: Grid,
    starts: Sequence[Point],
    goals: Sequence[Sequence[Point]],
) -> Conditions:
    """Return the conditions that hold for a swarm, as if all robots were as large as the largest.

    Only the floor is that of the smallest: where the largest does not fit is a single lane.

    Args:
        starts: Start of each robot, (x, y) [m] in map.
        goals: Goals of each robot: all places (x, y) [m] in map to which it may be sent.

    Raises:
        MapError: If the map has too many cells when it is divided into finer ones.
    """
    own = {robot: _OwnFloor(*robot, grid) for robot in dict.fromkeys(robots)}
    floors = [own[robot] for robot in robots]
    stands = [
        [floor.stand(goal) for goal in each] for floor, each in zip(floors, goals, strict=True)
    ]
    largest = max(robots, key=lambda robot: robot[0].circumscribed_radius)
    smallest = min(robots, key=lambda robot: robot[0].circumscribed_radius)
    terrain = as_large_as(own[smallest].terrain, largest[0].circumscribed_radius)
    radius = largest[0].circumscribed_radius + largest[1].traffic.safety_margin
    shared = _Floor(terrain, own[largest].terrain, radius)
    known = [[point for point in each if point is not None] for each in stands]
    places, findings = shared.check(starts, known)
    missed = _missed(floors, starts, goals, stands)
    return Conditions(len(goals), places, (*missed, *findings))


class _OwnFloor:
    """Floor on which a robot of one kind can stand, and the places between which it can drive."""

    def __init__(self, spec: RobotSpec, config: NavConfig, grid: Grid) -> None:
        self.terrain = terrain_of(config, spec, grid)
        self._planner = Planner(self.terrain, config.planner)
        is_open = self.terrain.lattice.base < search_kernels.WALL
        self._labels = label(is_open)
        self._stands: dict[Point, Point | None] = {}

    def stand(self, goal: Point) -> Point | None:
        """Return where a robot stands that is sent to a goal; None if it has no room there."""
        if goal not in self._stands:
            try:
                self._stands[goal] = self._planner.goal_node(goal)[1]
            except PlanError:
                self._stands[goal] = None
        return self._stands[goal]

    def part(self, point: Point) -> int:
        """Return the number of the connected floor around a point, 0 for none."""
        node = self.terrain.lattice.node_of(*point)
        return 0 if node is None else int(self._labels.ravel()[node])


def _missed(
    floors: Sequence[_OwnFloor],
    starts: Sequence[Point],
    goals: Sequence[Sequence[Point]],
    stands: Sequence[Sequence[Point | None]],
) -> Iterator[str]:
    """Yield a sentence on goals without room, and one on goals to which no way leads."""
    occupied: dict[Point, None] = {}  # in the order of the robots
    cut_off: dict[Point, None] = {}
    for floor, start, points, places in zip(floors, starts, goals, stands, strict=True):
        from_here = floor.part(start)
        for goal, place in zip(points, places, strict=True):
            if place is None:
                occupied[goal] = None
            elif from_here and floor.part(place) != from_here:
                cut_off[goal] = None
    for what, found in (("no room for the robot at", occupied), ("no way to", cut_off)):
        if found:
            (x, y), *others = found
            more = f" and {len(others)} more" if others else ""
            yield f"{what} the goal ({x:.2f}, {y:.2f}){more}"


class _Floor:
    """The floor of a map, divided into rooms, where two robots pass, and single lanes."""

    def __init__(self, terrain: Terrain, standing: Terrain, radius: float) -> None:
        self._terrain, self._radius = terrain, radius
        self._lattice: Lattice = terrain.lattice
        self._gap = 2.0 * radius / self._lattice.step  # cells between two robots
        self._open: Mask = self._lattice.base < search_kernels.WALL
        self._wide: Mask = passing_areas(terrain, radius)
        self._lanes: Mask = self._open & ~self._wide
        self._standing: Mask = self._wide & (standing.lattice.base < search_kernels.WALL)

    def check(
        self, starts: Sequence[Point], goals: Sequence[Sequence[Point]]
    ) -> tuple[int, list[str]]:
        """Return the number of places, and a sentence for each condition that does not hold."""
        nodes = [self._nodes(each) for each in goals]
        stays = [[*self._nodes([start]), *each] for start, each in zip(starts, nodes, strict=True)]
        used = [
            (part, count)
            for part in connected_components(self._open)
            if (count := _visitors(part, stays))
        ]
        places = [self._places(part & self._standing) for part, _ in used]
        findings: list[str] = []
        for (part, count), room in zip(used, places, strict=True):
            if 0 < room < PLACES_PER_ROBOT * count:
                here = f" on the floor around {self._spot(part)}" if len(used) > 1 else ""
                findings.append(
                    f"room for {_robots(room // PLACES_PER_ROBOT)}{here}; {count} asked for"
                )
        for number, lane in enumerate(connected_components(self._lanes), 1):
            room = lane_group(self._terrain, self._radius, number).capacity
            findings += self._check_lane(lane, room, nodes)
        return sum(places), findings

    def _nodes(self, points: Sequence[Point]) -> list[int]:
        found = (self._lattice.node_of(x, y) for x, y in points)
        return [node for node in found if node is not None]

    def _check_lane(self, lane: Mask, room: int, nodes: Sequence[Sequence[int]]) -> Iterator[str]:
        """Yield a sentence for each condition that a single lane violates.

        Args:
            lane: (h, w) its cells.
            room: For how many robots with goals there it has room.
        """
        robots = len(nodes)
        around = grown(lane) & self._open & ~lane
        sides = [side for side in connected_components(self._open & ~lane) if (side & around).any()]
        here = self._spot(lane)
        guests = _visitors(lane, nodes)
        if guests > room:
            yield (
                f"room for {_robots(room)} on the single lanes around {here};"
                f" {guests} have goals there"
            )
        if len(sides) < 2:
            return
        for side in sides:
            if not _visitors(side, nodes):
                continue
            places = self._places(side & self._standing, PLACES_PER_ROBOT * robots)
            if places < PLACES_PER_ROBOT * robots:
                fit = _robots(places // PLACES_PER_ROBOT)
                yield f"room for {fit} beyond the single lane around {here}; {robots} asked for"

    def _places(self, part: Mask, most: int = 1_000_000) -> int:
        return int(single_lane_kernels.places(part, self._gap, most))

    def _spot(self, part: Mask) -> str:
        """Return where a part of the floor is, for people: its cell nearest to its middle."""
        points = self._lattice.points_of(np.flatnonzero(part))
        x, y = points[int(np.hypot(*(points - points.mean(0)).T).argmin())]
        return f"({x:.1f}, {y:.1f})"


def _visitors(part: Mask, nodes: Sequence[Sequence[int]]) -> int:
    flat = part.ravel()
    return sum(any(flat[node] for node in each) for each in nodes)


def _robots(count: int) -> str:
    return "1 robot" if count == 1 else f"{count} robots"
