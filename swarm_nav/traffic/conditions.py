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
from numpy.typing import NDArray

from swarm_common.model.grid import Grid
from swarm_common.model.records import RobotSpec
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import PlanError
from swarm_nav.planning import search_kernels
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.terrain import Lattice, Terrain, as_large_as
from swarm_nav.traffic import single_lane_kernels
from swarm_nav.traffic.lane_capacity import capacity, grown
from swarm_nav.traffic.single_lanes import Mask, parts, rooms
from swarm_nav.traffic.situation import terrain_of

Point = tuple[float, float]
MOST_NAMED = 6  # findings that are told one by one
SPARE = 4  # places for each robot: one that stands between four places takes them all


@dataclass(frozen=True, slots=True)
class Conditions:
    """What a map has room for."""

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
            return f"{asked} room to reach every known goal (room for {self.places // SPARE})"
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
    """Return what holds on a map for a swarm, as if all robots were as large as the largest.

    Only the floor is that of the smallest: where the largest does not fit is a single lane.

    Args:
        robots: Body and parameters of each.
        grid: The map.
        starts: Of each robot: (x, y) [m] in map.
        goals: Of each robot: all places (x, y) [m] in map where it may be told to go.

    Raises:
        MapError: If the map has too many cells when it is divided into finer ones.
    """
    sites = _Sites(robots, grid)
    stands = [[sites.stand(k, goal) for goal in each] for k, each in enumerate(goals)]
    findings = sites.findings(starts, goals, stands)
    known = [[point for point in each if point is not None] for each in stands]
    bodies = [spec.circumscribed_radius for spec, _ in robots]
    largest, smallest = int(np.argmax(bodies)), int(np.argmin(bodies))
    terrain, standing = sites.terrains[smallest], sites.terrains[largest]
    if round(bodies[largest] - bodies[smallest], 3) > 0.0:  # as robots tell it by their beacons
        terrain = as_large_as(terrain, bodies[largest])
    radius = bodies[largest] + robots[largest][1].traffic.safety_margin
    return _Floor(terrain, standing, radius).check(starts, known, findings)


class _Sites:
    """Where robots can stand, and to where they can drive, each on the floor for its own size."""

    def __init__(self, robots: Sequence[tuple[RobotSpec, NavConfig]], grid: Grid) -> None:
        self.terrains = [terrain_of(config, spec, grid) for spec, config in robots]
        self._tolerances = [config.planner.tolerance for _, config in robots]
        self._planners = {
            (terrain, config.planner.tolerance): Planner(terrain, config.planner, config.costmap)
            for terrain, (_, config) in zip(self.terrains, robots, strict=True)
        }
        self._stands: dict[tuple[Planner, Point], Point | None] = {}
        self._labels: dict[Terrain, NDArray[np.int16]] = {}

    def stand(self, robot: int, goal: Point) -> Point | None:
        """Return where a robot stands that is sent to a goal; None if it has no room there."""
        planner = self._planners[self.terrains[robot], self._tolerances[robot]]
        key = planner, goal
        if key not in self._stands:
            try:
                self._stands[key] = planner.goal_node(goal)[1]
            except PlanError:
                self._stands[key] = None
        return self._stands[key]

    def findings(
        self,
        starts: Sequence[Point],
        goals: Sequence[Sequence[Point]],
        stands: Sequence[Sequence[Point | None]],
    ) -> list[str]:
        """Return a sentence on goals without room, and one on goals to which no way leads."""
        occupied: dict[Point, None] = {}
        cut_off: dict[Point, None] = {}
        for robot, (start, points, places) in enumerate(zip(starts, goals, stands, strict=True)):
            from_here = self._part(robot, start)
            for goal, place in zip(points, places, strict=True):
                if place is None:
                    occupied[goal] = None
                elif from_here and self._part(robot, place) != from_here:
                    cut_off[goal] = None
        told = (("no room for the robot at", occupied), ("no way to", cut_off))
        return [_on_goals(what, list(found)) for what, found in told if found]

    def _part(self, robot: int, point: Point) -> int:
        """Return the number of the connected floor around a point, 0 for none."""
        terrain = self.terrains[robot]
        if terrain not in self._labels:
            is_open = terrain.lattice.base < search_kernels.WALL
            labels = np.zeros(is_open.shape, np.int16)
            single_lane_kernels.label(is_open, labels)
            self._labels[terrain] = labels
        node = terrain.lattice.node_of(*point)
        return 0 if node is None else int(self._labels[terrain].ravel()[node])


class _Floor:
    """The floor of a map, divided into rooms, where two robots pass, and single lanes."""

    def __init__(self, terrain: Terrain, standing: Terrain, radius: float) -> None:
        self._terrain, self._radius = terrain, radius
        self._lattice: Lattice = terrain.lattice
        self._gap = 2.0 * radius / self._lattice.step  # cells between two robots
        self._open: Mask = self._lattice.base < search_kernels.WALL
        self._wide: Mask = rooms(terrain, radius)
        self._lanes: Mask = self._open & ~self._wide
        self._standing: Mask = self._wide & (standing.lattice.base < search_kernels.WALL)

    def check(
        self, starts: Sequence[Point], goals: Sequence[Sequence[Point]], findings: Sequence[str]
    ) -> Conditions:
        nodes = [self._nodes(each) for each in goals]
        stays = [[*self._nodes([start]), *each] for start, each in zip(starts, nodes, strict=True)]
        used = [(part, count) for part in parts(self._open) if (count := _visitors(part, stays))]
        places = [self._places(part & self._standing) for part, _ in used]
        found = list(findings)
        for (part, count), room in zip(used, places, strict=True):
            if 0 < room < SPARE * count:
                here = f" on the floor around {self._spot(part)}" if len(used) > 1 else ""
                found.append(f"room for {_robots(room // SPARE)}{here}; {count} asked for")
        for number, lane in enumerate(parts(self._lanes), 1):
            room = capacity(self._terrain, self._radius, number)
            found += self._check_lane(lane, room, nodes)
        return Conditions(len(goals), sum(places), tuple(found))

    def _nodes(self, points: Sequence[Point]) -> list[int]:
        """Return the nodes of those points that are on open floor."""
        found = (self._lattice.node_of(x, y) for x, y in points)
        return [node for node in found if node is not None]

    def _check_lane(self, lane: Mask, room: int, nodes: Sequence[Sequence[int]]) -> Iterator[str]:
        """Yield a sentence for each condition that a single lane violates.

        Args:
            lane: (h, w) its cells.
            room: For how many robots with goals there it has room.
            nodes: The goals of each robot.
        """
        robots = len(nodes)
        around = grown(lane) & self._open & ~lane
        sides = [side for side in parts(self._open & ~lane) if (side & around).any()]
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
            places = self._places(side & self._standing, SPARE * robots)
            if places < SPARE * robots:
                yield (
                    f"room for {_robots(places // SPARE)} beyond the single lane around {here};"
                    f" {robots} asked for"
                )

    def _places(self, part: Mask, most: int = 1_000_000) -> int:
        return int(single_lane_kernels.places(part, self._gap, most))

    def _spot(self, part: Mask) -> str:
        """Return where a part of the floor is, for people: its cell nearest to its middle."""
        points = self._lattice.points_of(np.flatnonzero(part))
        x, y = points[int(np.hypot(*(points - points.mean(0)).T).argmin())]
        return f"({x:.1f}, {y:.1f})"


def _visitors(part: Mask, nodes: Sequence[Sequence[int]]) -> int:
    """Return how many robots have a goal in a part of the floor."""
    flat = part.ravel()
    return sum(any(flat[node] for node in each) for each in nodes)


def _on_goals(what: str, goals: Sequence[Point]) -> str:
    """Return a sentence on goals, of which the first is named."""
    x, y = goals[0]
    more = f" and {len(goals) - 1} more" if len(goals) > 1 else ""
    return f"{what} the goal ({x:.2f}, {y:.2f}){more}"


def _robots(count: int) -> str:
    return "1 robot" if count == 1 else f"{count} robots"
