"""Global planner: A* on the lattice, smoothed to a path that a differential drive can follow."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import ON_THIS_MAP
from swarm_common.model.records import FloatArray, Pose
from swarm_common.model.zones import DirectedZone
from swarm_nav.core.config import PlannerConfig
from swarm_nav.core.goals import ErrorCode, PlanError
from swarm_nav.planning import path_cost_kernels, path_kernels, search_kernels
from swarm_nav.planning.directed import NARROW, nodes_in, straightened, turns_back
from swarm_nav.planning.oblong import RUN_IN, Slots
from swarm_nav.planning.terrain import NODE_MARGIN, Terrain, sector_of

SPACING = 0.05  # [m] between the points of a path
POCKET = 1.0  # [m] from the robot that a recovery may take it at most
SMOOTHING = path_kernels.Smoothing(passes=3, reach=4, rounds=6)


class Planner:
    """Plans on one terrain; `extra` is the lattice of costs that other robots add.

    Attributes:
        terrain: Terrain of the map, for this size of robot.
        lattice: Lattice of the terrain, which is searched.
        expansions: Nodes that the last search looked at.
    """

    def __init__(self, terrain: Terrain, planner: PlannerConfig) -> None:
        """Plan with the walls of a terrain and the given parameters.

        Args:
            terrain: Terrain of the map, for this size of robot.
            planner: `planner.` parameters.
        """
        self.terrain = terrain
        self.lattice = terrain.lattice
        self._routes = terrain  # with the directions of zones
        self._zones: tuple[DirectedZone, ...] = ()
        # with directed zones: 2 in them, 1 beside them, where smoothing might cut their corners
        self._in_zones = np.zeros((0, 0), np.float32)
        self._config = planner
        self._smooth_walls = path_kernels.WallClearance(terrain.field, terrain.wall_clearance)
        self._plain_walls = path_kernels.WallClearance(terrain.field, terrain.radius + NODE_MARGIN)
        slots = terrain.lattice.slots
        self._anywhere = np.ones(terrain.lattice.base.shape, np.uint8)
        if slots is not None:
            self._anywhere[~slots.room] = 0  # no robot waits in a slot
        self.expansions = 0  # of the last search
        self._to_go: NDArray[np.float32] | None = None  # of the last goal; held, so kept for all

    def direct(self, zones: tuple[DirectedZone, ...]) -> None:
        """Plan ways to goals, and where it can be ways to make way, as directed zones want."""
        self._zones, self._routes = zones, self.terrain.directed(zones)
        if zones:
            frame, shape = self.lattice.frame, self.lattice.base.shape
            layers = [nodes_in(zones, frame, shape, margin) for margin in (NARROW, 1.0 + NARROW)]
            self._in_zones = np.sum(layers, axis=0, dtype=np.float32)

    def no_extra(self) -> NDArray[np.float32]:
        """Return an `extra` lattice that adds nothing."""
        return np.zeros(self.lattice.base.shape, np.float32)

    def free_places(
        self,
        taken: NDArray[np.float32],
        allowed: NDArray[np.uint8] | NDArray[np.bool_] | None = None,
    ) -> NDArray[np.uint8]:
        """Return the nodes on which a robot may be put to wait.

        Args:
            taken: (h, w); not 0 where another robot needs the place.
            allowed: (h, w); 0 where waiting is not allowed. None: everywhere but in slots.

        Returns:
            (h, w), 1 on such nodes, 0 elsewhere.
        """
        allowed = self._anywhere if allowed is None else allowed
        places: NDArray[np.uint8] = ((taken == 0.0) & (allowed != 0)).astype(np.uint8)
        return places

    def plan(
        self,
        start: tuple[float, float],
        goal: tuple[float, float],
        extra: NDArray[np.float32],
        yaw: float = math.nan,
    ) -> FloatArray:
        """Return a path from start to goal, points `SPACING` apart.

        Optimal on the lattice (A* with an exact static heuristic). A goal inside the clearance of
        a wall is moved by at most the planner's tolerance.

        Args:
            start: (x, y) [m] in map.
            goal: (x, y) [m] in map.
            extra: (h, w) cost per metre that other robots add; `search_kernels.WALL` closes a node.
            yaw: [rad] direction that the last metre prefers; NaN for none.

        Returns:
            (n, 2) [m] in map.

        Raises:
            PlanError: With Nav2's code, if start or goal is unusable or no path exists.
        """
        if (way_out := self._way_out(start, extra)) is not None:
            rest = self.plan(_end(way_out), goal, extra, yaw)
            return np.vstack((way_out, rest[1:]))
        start_node = self._start_node(start)
        given = goal
        goal_node, goal = self.goal_node(goal)
        sector = sector_of(yaw)
        nodes, to_go = self._cheapest(self._routes, start_node, goal_node, extra, sector)
        if self._zones and turns_back(self.lattice.points_of(nodes), self._zones):
            routes = self.terrain.directed(straightened(self._zones))
            nodes, to_go = self._cheapest(routes, start_node, goal_node, extra, sector)
        if len(nodes) == 0 and self._zones:
            way_out = self._out_of_zones(start, start_node, extra, to_go)
            if way_out is not None:
                rest = self.plan(_end(way_out), goal, extra, yaw)
                return np.vstack((way_out, rest[1:]))
        if len(nodes) == 0:
            is_for_good = not np.isfinite(to_go.flat[start_node])
            walls = "walls and directed zones" if self._zones else "walls"
            raise PlanError(
                ErrorCode.NO_VALID_PATH,
                f"no path from ({start[0]:.2f}, {start[1]:.2f}) to"
                f" ({given[0]:.2f}, {given[1]:.2f}): every way is closed by"
                f" {f'{walls} {ON_THIS_MAP}' if is_for_good else 'obstacles'}",
                is_final=is_for_good and self._leads_away(start, start_node),
            )
        if self._zones:
            extra = extra + self._in_zones  # smoothing enters no zone
        return self.finish(self.lattice.points_of(nodes), start, goal, extra, True)

    def _cheapest(
        self,
        routes: Terrain,
        start_node: int,
        goal_node: int,
        extra: NDArray[np.float32],
        sector: int,
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Return the nodes from start to goal, none without a way, and the costs to go."""
        to_go = self._to_go = routes.cost_to_go(goal_node, sector)
        with routes.approach(goal_node, sector):
            nodes, self.expansions = routes.search.cheapest(start_node, goal_node, extra, to_go)
        return nodes, to_go

    def _out_of_zones(
        self,
        start: tuple[float, float],
        start_node: int,
        extra: NDArray[np.float32],
        to_go: NDArray[np.float32],
    ) -> FloatArray | None:
        """Return a short path (n, 2) out of the zones in which a start lies; None if there is none.

        Who made way for others may be where the directions of zones lead to no goal.
        """
        if self._in_zones.flat[start_node] < 2.0 or np.isfinite(to_go.flat[start_node]):
            return None
        places = ((self._in_zones < 2.0) & np.isfinite(to_go)).astype(np.uint8)
        nodes = self.terrain.search.nearest(start_node, extra, places, POCKET)
        if len(nodes) == 0:
            return None
        end = self.lattice.point_of(int(nodes[-1]))
        return self.finish(self.lattice.points_of(nodes), start, end, extra, False)

    def cost_to_go(self, goal: tuple[float, float], yaw: float) -> NDArray[np.float32]:
        """Return the cost of driving from every node to a goal, as `plan` uses it.

        Args:
            goal: (x, y) [m] in map.
            yaw: [rad] direction that the last metre prefers; NaN for none.

        Returns:
            (h, w) [m]; inf where there is no way to the goal.

        Raises:
            PlanError: With Nav2's code, if the goal is unusable.
        """
        return self.terrain.cost_to_go(self.goal_node(goal)[0], sector_of(yaw))

    def costs_in_order(self, goal: tuple[float, float]) -> NDArray[np.float32]:
        """Return the costs of driving to a goal from all nodes that reach it, in rising order.

        Args:
            goal: (x, y) [m] in map.

        Returns:
            (n,) [m].

        Raises:
            PlanError: With Nav2's code, if the goal is unusable.
        """
        return self.terrain.costs_in_order(self.goal_node(goal)[0])

    def cost_of(self, path: FloatArray, extra: NDArray[np.float32]) -> float:
        """Return the cost [m] of driving along a path, including what other robots add.

        Args:
            path: (n, 2) [m] in map.
            extra: (h, w) cost per metre that other robots add.
        """
        lattice = self.lattice
        layers = path_cost_kernels.Layers(lattice.base, lattice.lane, lattice.heading)
        return float(path_cost_kernels.path_cost(path, lattice.frame, layers, extra))

    def plan_through(self, points: Sequence[tuple[float, float]]) -> FloatArray:
        """Return the path from the first of some points through the others, without other robots.

        Args:
            points: (x, y) [m] in map.

        Returns:
            (n, 2) [m] in map; empty for fewer than two points.

        Raises:
            PlanError: With Nav2's code, if there is none.
        """
        pieces = [self.plan(a, b, self.no_extra()) for a, b in itertools.pairwise(points)]
        if not pieces:
            return np.zeros((0, 2))
        return np.vstack((pieces[0], *(piece[1:] for piece in pieces[1:])))

    def nearest(
        self,
        start: tuple[float, float],
        extra: NDArray[np.float32],
        places: NDArray[np.uint8],
        reach: float,
        smooth: bool = True,
    ) -> FloatArray | None:
        """Return the path to the cheapest node of a set.

        Args:
            start: (x, y) [m] in map.
            extra: (h, w) cost per metre that other robots add; `search_kernels.WALL` closes a node.
            places: (h, w); above 0 on the nodes of the set.
            reach: Cost [m] beyond which the search ends.
            smooth: Whether to smooth the path.

        Returns:
            (n, 2) [m] in map; None if there is no such node within reach.
        """
        if (way_out := self._way_out(start, extra)) is not None:
            rest = self.nearest(_end(way_out), extra, places, reach, smooth)
            return None if rest is None else np.vstack((way_out, rest[1:]))
        node = self.lattice.node_of(*start, extra)
        if node is None:
            return None
        nodes = self._routes.search.nearest(node, extra, places, reach)
        if len(nodes) == 0 and self._zones:
            nodes = self.terrain.search.nearest(node, extra, places, reach)
        if len(nodes) == 0:
            return None
        points = self.lattice.points_of(nodes)
        goal = (float(points[-1, 0]), float(points[-1, 1]))
        return self.finish(points, start, goal, extra, smooth)

    def finish(
        self,
        points: FloatArray,
        start: tuple[float, float],
        goal: tuple[float, float],
        extra: NDArray[np.float32],
        smooth: bool,
    ) -> FloatArray:
        """Replace the end nodes of a search by the exact ends, resample and smooth.

        Args:
            points: (n, 2) [m] in map, centres of the nodes.
            start: (x, y) [m] in map.
            goal: (x, y) [m] in map.
            extra: (h, w) cost per metre that other robots add; smoothing enters no costlier cell.
            smooth: Whether to smooth the path.

        Returns:
            (m, 2) [m] in map, points `SPACING` apart.
        """
        # nodes beside the exact ends would make hooks
        ends = np.array((start, goal))
        course = path_kernels.with_ends(points, ends, self.lattice.step, self._plain_walls)
        slots = self.lattice.slots
        if slots is not None and slots.is_slot(course).any():
            return self._through_slots(slots, course, extra, smooth)
        return self._course(course, extra, smooth)

    def smooth(self, points: FloatArray) -> FloatArray:
        """Return a polyline smoothed and lifted off walls, its ends unchanged.

        Args:
            points: (n, 2) [m] in map.

        Returns:
            (m, 2) [m] in map, points `SPACING` apart.
        """
        return self._course(points, self.no_extra(), True)

    def _through_slots(
        self, slots: Slots, course: FloatArray, extra: NDArray[np.float32], smooth: bool
    ) -> FloatArray:
        """Return the points of a course that is straight in slots, and turns in front of them."""
        if slots.is_slot(course[:1])[0]:  # it may stand beside the slot's line
            beside = np.hypot(*(course[1:-1] - course[0]).T) < RUN_IN
            out = np.flatnonzero(~slots.is_slot(course[1:-1]))
            beside[out[0] if len(out) else len(beside) :] = False
            course = np.vstack((course[:1], course[1:-1][~beside], course[-1:]))
        pieces = [
            _resampled(piece) if is_slot else self._course(piece, extra, smooth)
            for piece, is_slot in slots.pieces(course)
        ]
        return np.vstack((pieces[0], *(piece[1:] for piece in pieces[1:])))

    def _course(self, course: FloatArray, extra: NDArray[np.float32], smooth: bool) -> FloatArray:
        if smooth:
            others = path_kernels.Blocked(extra, self.lattice.frame)
            path: FloatArray = path_kernels.drivable(
                course, SPACING, SMOOTHING, self._smooth_walls, others
            )
            return path
        path = _resampled(course)
        path_kernels.lift_off_walls(path, self._plain_walls, SMOOTHING.rounds)
        return path

    def _way_out(self, start: tuple[float, float], extra: NDArray[np.float32]) -> FloatArray | None:
        """Return the path (n, 2) out of the keepout zone in which a start lies; None in none."""
        terrain = self.terrain
        if terrain.grid.keepout is None or self.lattice.node_of(*start) is not None:
            return None
        if not terrain.is_in_keepout(*start, terrain.radius):
            return None
        is_open = (self.lattice.base < search_kernels.WALL).astype(np.uint8)
        walls = Planner(terrain.without_keepout, self._config)
        return walls.nearest(start, extra, is_open, math.inf, smooth=False)

    def _start_node(self, start: tuple[float, float]) -> int:
        if not self.terrain.grid.contains(*start):
            raise PlanError(
                ErrorCode.START_OUTSIDE_MAP,
                f"the start ({start[0]:.2f}, {start[1]:.2f}) lies outside the map",
            )
        node = self.lattice.node_of(*start)
        if node is None:
            raise PlanError(
                ErrorCode.START_OCCUPIED,
                f"the start ({start[0]:.2f}, {start[1]:.2f}) is"
                f" {self.terrain.clearance(*start):.2f} m from a wall; the robot does not fit",
            )
        return node

    def _leads_away(self, start: tuple[float, float], start_node: int) -> bool:
        """Report whether the robot is in no pocket, out of which a recovery might bring it."""
        to_go = self.terrain.cost_to_go(start_node)
        nodes = np.flatnonzero(np.isfinite(to_go))
        return bool((np.hypot(*(self.lattice.points_of(nodes) - start).T) > POCKET).any())

    def goal_node(self, goal: tuple[float, float]) -> tuple[int, tuple[float, float]]:
        """Return the goal's node, and the point to drive to if the robot has no room at the goal.

        Args:
            goal: (x, y) [m] in map.

        Raises:
            PlanError: If it is outside the map, or nothing within `planner.tolerance` has room.
        """
        if not self.terrain.grid.contains(*goal):
            raise PlanError(
                ErrorCode.GOAL_OUTSIDE_MAP,
                f"the goal ({goal[0]:.2f}, {goal[1]:.2f}) lies outside the map",
            )
        if self.terrain.is_keepout(*goal):
            raise PlanError(
                ErrorCode.GOAL_OCCUPIED,
                f"the goal ({goal[0]:.2f}, {goal[1]:.2f}) lies in a keepout zone {ON_THIS_MAP}",
            )
        clear = self.terrain.clearance(*goal)
        room = self.lattice.slots.room if self.lattice.slots is not None else None
        closed = None if room is None else np.where(room, self.lattice.base, search_kernels.WALL)
        node = self.lattice.node_of(*goal, closed)
        if node is not None and clear >= self.terrain.radius + NODE_MARGIN:
            return node, goal
        lattice = self.lattice
        is_open = lattice.base < search_kernels.WALL
        rows, columns = np.nonzero(is_open if room is None else is_open & room)
        nodes = rows * lattice.base.shape[1] + columns
        distances = np.hypot(*(lattice.points_of(nodes) - goal).T)
        if len(nodes) == 0 or distances.min() > self._config.tolerance:
            raise PlanError(
                ErrorCode.GOAL_OCCUPIED,
                f"the goal ({goal[0]:.2f}, {goal[1]:.2f}) is {clear:.2f} m from a wall and no"
                f" place within {self._config.tolerance} m has room for the robot {ON_THIS_MAP}",
            )
        best = int(nodes[int(distances.argmin())])
        return best, lattice.point_of(best)


def _end(path: FloatArray) -> tuple[float, float]:
    return float(path[-1, 0]), float(path[-1, 1])


def path_length(path: FloatArray) -> float:
    """Return the length [m] of a polyline.

    Args:
        path: (n, 2) [m]; n may be 0.
    """
    if len(path) < 2:
        return 0.0
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def straight_path(start: Pose, distance: float) -> FloatArray:
    """Return points from a pose straight ahead, `SPACING` apart.

    Args:
        distance: [m]; below 0: behind the pose.

    Returns:
        (n, 2) [m] in map.
    """
    end = (start.x + distance * math.cos(start.yaw), start.y + distance * math.sin(start.yaw))
    return _resampled(np.array(((start.x, start.y), end)))


def _resampled(points: FloatArray) -> FloatArray:
    path: FloatArray = path_kernels.resampled(np.ascontiguousarray(points), SPACING)
    return path
