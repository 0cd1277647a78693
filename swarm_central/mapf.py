"""The centre: lifelong multi-agent path finding on a roadmap, executed in the plan's order.

Every few ticks all robots are planned anew from where they will stop, some steps ahead: by PIBT, by
LaCAM* with PIBT where that finds no plan, or by an external solver alone. A robot is given the way
to its next vertex when the dependency graph allows it, piece by piece, as far as it keeps off
everything that others were given. What was given is never taken back: lost or late messages cost
time, and a robot that hears nothing stops where its space ends.
"""

from __future__ import annotations

import copy
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from swarm_central.config import CentralConfig
from swarm_central.dependency_graph import DependencyGraph
from swarm_central.grant_kernels import free_length
from swarm_central.lacam import Lacam
from swarm_central.movingai import ExternalSolver, SolverError
from swarm_central.pibt_kernels import Wishes, roll_out
from swarm_central.plan_check import first_fault
from swarm_central.progress import Point, RobotProgress
from swarm_central.roadmap import RoadmapError, Timing, build_roadmap
from swarm_central.team import RobotReport, TeamOrder
from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, RobotSpec
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig
from swarm_nav.planning.terrain import terrain_for

PIECE = 0.05  # [m] between places that are checked, and least that is given at once
MOST_LATE = 2.0  # [s] of a message's way there and back that a robot is given more space for
OUT_OF_REACH = 1e6  # [m²] where no straight way leads to a vertex
BARRED = 1e4  # [m²] where somebody stands on it
NEVER = -10_000  # tick
PARK = 0  # row of the field of robots that wait


class MapfCentre:
    """Decides for all robots by planning on a roadmap.

    Attributes:
        arrived_share: Share of the goal tolerance within which a vertex is the place of a goal.
        stop_share: Share of that within which robots are to stop beside a vertex.
    """

    arrived_share = 0.8
    stop_share = 0.8

    def __init__(
        self,
        config: NavConfig,
        specs: Sequence[RobotSpec],
        grid: Grid,
        sites: Sites,
        central: Mapping[str, Any] | None = None,
    ) -> None:
        """Make the roadmap.

        Args:
            config: Speeds, tolerances and lanes count.
            grid: The map.
            sites: Whose stations the roadmap fits, where it can.
            central: Parameters of the centre by name; None for the defaults.

        Raises:
            RoadmapError: If robots of this size find no roadmap in the map.
        """
        self.config = CentralConfig(**(central or {}))
        body = max(spec.circumscribed_radius for spec in specs)
        self._radii = np.array([s.circumscribed_radius for s in specs]) + self.config.margin
        self._reach = self.arrived_share * config.goal_checker.xy_goal_tolerance
        slowest = config.controller
        turn = slowest.max_vel_theta / slowest.acc_lim_theta + self.config.stop_time
        timing = Timing(
            math.pi / 2 / slowest.max_vel_theta + turn,
            math.pi / slowest.max_vel_theta + turn,
            self.config.spacing(body) / slowest.max_vel_x,
        )
        self._places: dict[Point, int] = {}
        self._room = body + self.config.wall_margin
        self._terrain = terrain = terrain_for(grid, config.planner, config.costmap, body)
        stations = np.array([(p.x, p.y) for p in sites.stations.values()]).reshape(-1, 2)
        self.roadmap = build_roadmap(
            terrain,
            self.config.spacing(body),
            self._room,
            timing,
            slowest.max_vel_x,
            stations,
            self._reach,
        )
        self._speed = slowest.max_vel_x
        self.begin(len(specs))
        self._solver: ExternalSolver | None = None
        if self.config.solver:
            self._solver = ExternalSolver(
                Path(self.config.solver), self.roadmap, self.config.solver_time
            )

    def begin(self, robots: int) -> None:
        """Start without a report of any robot.

        Args:
            robots: Number of robots in the run.
        """
        self._tick = 0
        self._began = -1  # tick
        self._robots: dict[int, RobotProgress] = {}
        self._first: dict[int, RobotReport] = {}
        self._count = robots
        self._graph: DependencyGraph | None = None
        self._planned = NEVER
        self._is_stale = self._is_joint = False
        self._closed: NDArray[np.bool_] = np.zeros(len(self.roadmap.points), np.bool_)
        self._rows: dict[int, int] = {}
        self._fields: list[FloatArray] = []
        self._noise = np.random.default_rng(0)
        self._plans = self._failures = 0
        self._by_pibt = 0  # of the plans
        self._forget_fields()

    def observe(self, tick: int, states: Sequence[RobotReport]) -> None:
        """Receive the reports that arrived in a tick.

        Args:
            states: At most one per robot.
        """
        self._tick = tick
        for report in states:
            known = self._robots.get(report.robot_id)
            if known is None:
                self._first[report.robot_id] = report
            elif known.take(report):
                self._is_stale = True
        self._began = tick if self._began < 0 else self._began
        if self._first and (
            len(self._first) + len(self._robots) == self._count
            or tick - self._began > self.config.patience
        ):
            self._admit()

    def decide(self) -> Sequence[TeamOrder]:
        """Return the orders to send now.

        Raises:
            SolverError: If an external solver gives no plan that can be driven. Nothing else plans
                in its place.
        """
        if not self._robots:
            return ()
        self._close(list(self._robots.values()))
        if self._needs_plan():
            self._plan()
        self._grant()
        orders = (robot.order() for robot in self._robots.values())
        return [order for order in orders if order is not None]

    def rehearse(self) -> None:
        """Plan for two robots that exist nowhere, so that all is compiled before robots wait."""
        stage = copy.copy(self)
        stage.begin(robots=2)
        stage._solver = None
        ends = [self._point(vertex) for vertex in (0, len(self.roadmap.points) - 1)]
        for tick in range(2):
            reports = [
                RobotReport(
                    robot_id=number,
                    tick=tick,
                    pose_map=Pose(*ends[number - 1], 0.0),
                    passed=0,
                    heard=0,
                    goal_id=1,
                    goal_map=ends[2 - number],
                    has_arrived=False,
                )
                for number in (1, 2)
            ]
            MapfCentre.observe(stage, tick, reports)
            MapfCentre.decide(stage)

    def _needs_plan(self) -> bool:
        """Whether it is time: PIBT looks ahead a little and often, joint plans lead to the goals.

        A joint plan is executed to its end unless a goal changes: planned anew, equals may be
        chosen otherwise, and robots would go to and fro.
        """
        since = self._tick - self._planned
        if self._is_joint and self._graph is not None and not self._graph.is_done:
            return self._is_stale and since >= self.config.least_period
        return since >= self.config.period or (self._is_stale and since >= self.config.least_period)

    def figures(self) -> Mapping[str, float]:
        """Return counters for the result of a run."""
        return {
            "plans": self._plans,
            "failed_plans": self._failures,
            "plans_by_pibt": self._by_pibt,
            "vertices": len(self.roadmap.points),
        }

    def _admit(self) -> None:
        """Give each new robot a vertex of its own, all as near as they can be."""
        reports = sorted(self._first.values(), key=lambda report: report.robot_id)
        taken = {robot.vertex for robot in self._robots.values()}
        free = np.array([v for v in range(len(self.roadmap.points)) if v not in taken])
        places = np.array([(r.pose_map.x, r.pose_map.y) for r in reports])
        gaps = ((places[:, None, :] - self.roadmap.points[free][None, :, :]) ** 2).sum(axis=2)
        for row, place in enumerate(places.tolist()):
            gaps[row, ~np.isin(free, self._in_reach(*place))] += OUT_OF_REACH
            near = np.flatnonzero(gaps[row] < OUT_OF_REACH)
            gaps[row, near[self._barred(reports[row], free[near])]] += BARRED
        rows, columns = linear_sum_assignment(gaps)
        if gaps[rows, columns].max() >= OUT_OF_REACH:
            raise RoadmapError("robots stand where the roadmap has too few places for them")
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            report, vertex = reports[row], int(free[column])
            if self._barred(report, free[[column]]).any():
                continue
            del self._first[report.robot_id]
            heading = round(report.pose_map.yaw / (math.pi / 2)) % 4
            robot = RobotProgress(report, vertex, heading)
            self._enter(robot, self._point(vertex))
            self._robots[report.robot_id] = robot
        self._robots = dict(sorted(self._robots.items()))
        self._forget_plan()

    def _barred(self, report: RobotReport, vertices: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return (n,) to which vertices a robot may not be sent now; it is asked again later."""
        return np.zeros(len(vertices), np.bool_)

    def _enter(self, robot: RobotProgress, first: Point) -> None:
        robot.queue.append(first)

    def _forget_plan(self) -> None:
        """Discard the plan: the robots have other indices."""
        self._graph, self._planned = None, NEVER

    def _point(self, vertex: int) -> Point:
        x, y = self.roadmap.points[vertex].tolist()
        return x, y

    # Planning

    def _forget_fields(self) -> None:
        """Discard the costs to all goals; row `PARK` is the way to a place out of the lanes."""
        self._rows.clear()
        parking = np.flatnonzero(self.roadmap.parking & ~self._closed)
        self._fields = [self.roadmap.costs_to(parking, self._closed)]

    def _row(self, vertex: int) -> int:
        if vertex not in self._rows:
            self._rows[vertex] = len(self._fields)
            self._fields.append(self.roadmap.costs_to(np.array([vertex]), self._closed))
        return self._rows[vertex]

    def _plan(self) -> None:
        """Plan all robots from where they will stop."""
        robots = list(self._robots.values())
        places = np.array([self._place(robot) for robot in robots], np.int32)
        goals = np.array([PARK if p < 0 else self._row(int(p)) for p in places], np.int32)
        fields = np.stack(self._fields)
        start = np.array([robot.vertex for robot in robots], np.int32)
        headings = np.array([robot.heading for robot in robots], np.int32)
        locked = np.array([self._is_locked(r, int(p)) for r, p in zip(robots, places, strict=True)])
        rest = fields[goals, start, headings]
        ages = np.array([self._tick - robot.since for robot in robots]) * CONTROL_PERIOD
        late = ages > self.config.most_age
        rank = np.where(late, -1e4 - ages, rest)
        released = self._released(places, rank)
        goals = np.where(released, goals, PARK).astype(np.int32)
        rank = np.where(released, rank, 1e6 - ages)
        busy = self._busy(robots, places)
        order = np.lexsort((np.arange(len(robots)), rank, ~busy[start], ~locked))
        noise = self._noise.random((len(robots), 5), np.float32) * np.float32(0.01)
        wishes = Wishes(fields, goals, busy, noise)
        places = np.where(released, places, -1).astype(np.int32)
        plan = self._jointly(order, start, headings, locked, places)
        self._is_joint = plan is not None
        if plan is None:
            plan = roll_out(
                order,
                start,
                headings,
                locked,
                places,
                self.roadmap.costs,
                wishes,
                self.config.horizon,
            )
            self._by_pibt += 1
        self._graph = DependencyGraph(plan)
        self._planned, self._is_stale = self._tick, False
        self._plans += 1

    def _jointly(
        self,
        order: NDArray[np.int64],
        start: NDArray[np.int32],
        headings: NDArray[np.int32],
        locked: NDArray[np.bool_],
        places: NDArray[np.int32],
    ) -> NDArray[np.int32] | None:
        """Return the next steps of a plan up to all goals; None where PIBT has to do.

        Of several robots with the same goal the first goes there and the others have none. A plan
        that moves a locked robot, or a circle of robots at once, cannot be executed.
        """
        if self._solver is None and self.config.planner == "pibt":
            return None
        goals, taken = start.copy(), set(start[locked].tolist())
        for robot in order.tolist():
            place = int(places[robot])
            if place >= 0 and not locked[robot] and place not in taken:
                goals[robot] = place
                taken.add(place)
        neighbors = self.roadmap.costs.neighbors
        _move_aside(goals, start, locked, neighbors)
        if self._solver is not None:
            return self._solved(self._solver, start, goals, locked)
        if len(np.unique(goals)) < len(goals):
            return None
        found = Lacam(
            self.roadmap,
            start,
            goals,
            headings=headings,
            locked=locked,
            closed=self._closed,
            may_rotate=False,
        ).solve(self.config.expansions)
        steps = None if found is None else found.steps
        if steps is None or len(steps) < 2 or first_fault(steps, neighbors, may_rotate=False):
            self._failures += 1
            return None
        return steps

    def _solved(
        self,
        solver: ExternalSolver,
        start: NDArray[np.int32],
        goals: NDArray[np.int32],
        locked: NDArray[np.bool_],
    ) -> NDArray[np.int32]:
        """Return the plan of an external solver; a robot without a way to its goal waits."""
        closed = self._closed.copy()
        closed[start[~locked]] = False
        _wait_if_cut_off(goals, start, locked, closed, self.roadmap.costs.neighbors)
        names = [f"id {robot_id}" for robot_id in self._robots]
        try:
            return solver.solve(start, goals, names=names, stays=locked, closed=closed)
        except SolverError as error:
            now = self._tick * CONTROL_PERIOD
            raise SolverError(f"at {now:.1f} s of simulated time {error}") from error

    def _place(self, robot: RobotProgress) -> int:
        x, y = robot.report.goal_map
        return -1 if robot.report.goal_id == 0 else self._vertex_for(x, y)

    def _vertex_for(self, x: float, y: float) -> int:
        if (x, y) not in self._places:
            near = self._in_reach(x, y)
            self._places[x, y] = int(near[0]) if len(near) else -1
        return self._places[x, y]

    def _in_reach(self, x: float, y: float) -> NDArray[np.int64]:
        return self.roadmap.in_reach(x, y, self._terrain, self._room)

    def _is_locked(self, robot: RobotProgress, place: int) -> bool:
        """Report whether a robot stays: at its goal, or on its way to a place off the roadmap."""
        if self._is_silent(robot):
            return True
        return bool(robot.queue) or robot.report.has_arrived or robot.vertex == place

    def _released(self, places: NDArray[np.int32], rank: FloatArray) -> NDArray[np.bool_]:
        """Return (n,) which robots go for their goals; the others wait and make way.

        The first of each place's queue come before all second ones: no station runs dry.
        """
        released = np.zeros(len(places), np.bool_)
        queues: Counter[int] = Counter()
        turns = []
        for robot in np.argsort(rank, kind="stable").tolist():
            place = int(places[robot])
            if place >= 0 and queues[place] < self.config.most_queued:
                turns.append((queues[place], rank[robot], robot))
                queues[place] += 1
        most = max(1, round(self.config.released_share * len(self.roadmap.points)))
        for _, _, robot in sorted(turns)[:most]:
            released[robot] = True
        return released

    def _busy(
        self, robots: Sequence[RobotProgress], places: NDArray[np.int32]
    ) -> NDArray[np.bool_]:
        """Return the vertices to keep clear, since a robot stops beside the roadmap near them."""
        busy = self._closed.copy()
        for robot, place in zip(robots, places.tolist(), strict=True):
            if robot.vertex != place or place < 0:
                continue
            beside = self._beside(robot, place)
            if beside is not None:
                gaps = np.hypot(*(self.roadmap.points - np.array(beside)).T)
                near = gaps < 2 * self._radii.max()
                near[place] = False
                busy |= near
        return busy

    def _beside(self, robot: RobotProgress, place: int) -> Point | None:
        """Return where a robot stops for its goal if its vertex is too far away."""
        goal, point = robot.report.goal_map, self._point(place)
        gap = math.dist(goal, point)
        if gap <= self._reach:
            return None
        share = (gap - self.stop_share * self._reach) / gap
        return (point[0] + share * (goal[0] - point[0]), point[1] + share * (goal[1] - point[1]))

    def _is_silent(self, robot: RobotProgress) -> bool:
        return self._tick - robot.report.tick > self.config.patience

    def _obstacles(self) -> Iterator[Point]:
        """Yield where robots are, or may be, that do not take orders: they are not heard."""
        for robot in self._robots.values():
            if self._is_silent(robot):
                for line in robot.held():
                    yield from line

    def _seen(self) -> set[Point]:
        """Return the places of things that are not on the map, as robots last reported them."""
        return {place for robot in self._robots.values() for place in robot.report.seen_map}

    def _close(self, robots: Sequence[RobotProgress]) -> None:
        """Close the vertices near obstacles."""
        closed = np.zeros_like(self._closed)
        for room, places in (
            (2 * self._radii.max(), self._obstacles()),
            (self._room, self._seen()),
        ):
            for place in places:
                gaps = np.hypot(*(self.roadmap.points - np.array(place)).T)
                closed |= gaps < room
        if (closed != self._closed).any():
            self._closed, self._is_stale = closed, True
            self._forget_fields()
        taken = {robot.vertex for robot in robots}
        for robot in robots:
            is_cut_off = robot.aim is not None and not robot.is_beside and closed[robot.vertex]
            if is_cut_off and robot.left not in taken and not closed[robot.left]:
                taken.add(robot.left)
                robot.turn_back(self._point(robot.left))

    # Execution

    def _grant(self) -> None:
        """Give each robot as much way as its order among the others and their space allow."""
        robots = list(self._robots.values())
        radii = self._radii[[robot.report.robot_id - 1 for robot in robots]]
        lines = [list(robot.held()) for robot in robots]
        segments = owners = None  # of all lines, until one changes
        for index, robot in enumerate(robots):
            late = 2 * (self._tick - robot.report.tick - 1) * CONTROL_PERIOD
            lookahead = self.config.lookahead + min(late, MOST_LATE) * self._speed
            ahead = sum(math.dist(*line) for line in lines[index])  # [m] that it may still drive
            if ahead >= lookahead or self._is_silent(robot):
                continue
            if segments is None:
                segments = np.array([line for held in lines for line in held]).reshape(-1, 4)
                owners = np.repeat(np.arange(len(robots)), [len(held) for held in lines])
            for target in self._choices(index, robot):
                aim = target[0]
                want = lookahead + PIECE - ahead
                length = free_length(robot.stop, aim, want, PIECE, index, segments, owners, radii)
                if length < min(PIECE, math.dist(robot.stop, aim)) - 1e-6:
                    continue
                if robot.aim is None:
                    self._commit(index, robot, *target)
                robot.extend(length)
                lines[index] = list(robot.held())
                segments = None
                break

    def _choices(self, index: int, robot: RobotProgress) -> Iterator[tuple[Point, int]]:
        """Yield the points to give next, the best first, and their vertices.

        A point that is no vertex has -1. A robot beside its vertex goes back there first: ways
        between vertices keep off each other, other lines need not.
        """
        if robot.aim is not None:
            yield robot.aim, -1
            return
        if robot.queue:
            yield robot.queue[0], -1
            return
        place = self._place(robot)
        if robot.vertex == place:
            beside = self._beside(robot, place)
            if beside is not None and not robot.is_beside and not robot.report.has_arrived:
                yield beside, -1
            return
        if robot.is_beside:
            yield self._point(robot.vertex), -1
            return
        assert self._graph is not None
        vertex = self._graph.next_target(index)
        if vertex >= 0:
            yield self._point(vertex), vertex

    def _commit(self, index: int, robot: RobotProgress, aim: Point, vertex: int) -> None:
        robot.aim = aim
        robot.is_beside = vertex < 0 and not robot.queue and not robot.is_beside
        if vertex < 0:
            robot.queue.clear()
            return
        assert self._graph is not None
        self._graph.begin(index)
        neighbors = self.roadmap.costs.neighbors[robot.vertex]
        robot.heading = int(np.flatnonzero(neighbors == vertex)[0])
        robot.left, robot.vertex = robot.vertex, vertex


def _move_aside(
    goals: NDArray[np.int32],
    start: NDArray[np.int32],
    locked: NDArray[np.bool_],
    neighbors: NDArray[np.int32],
) -> None:
    """Give robots that stand on another's goal the nearest vertex that is nobody's goal."""
    wanted = {int(goals[robot]) for robot in np.flatnonzero(goals != start)}
    taken = wanted | {int(place) for place in start}
    for robot in np.flatnonzero((goals == start) & ~locked).tolist():
        if int(start[robot]) not in wanted:
            continue
        seen, edge = {int(start[robot])}, [int(start[robot])]
        while edge:
            edge = [int(v) for u in edge for v in neighbors[u] if v >= 0 and int(v) not in seen]
            seen.update(edge)
            free = [vertex for vertex in edge if vertex not in taken]
            if free:
                goals[robot] = free[0]
                taken.add(free[0])
                break


def _wait_if_cut_off(
    goals: NDArray[np.int32],
    start: NDArray[np.int32],
    locked: NDArray[np.bool_],
    closed: NDArray[np.bool_],
    neighbors: NDArray[np.int32],
) -> None:
    """Let robots stay that have no way to their goals, or whose goals others will not leave.

    Args:
        goals: (n,) vertices; written to, and all different afterwards.
        start: (n,) vertices, all different.
        locked: (n,) robots that stay.
        closed: (V,) vertices that nobody may enter.
        neighbors: (V, 4) of the roadmap.
    """
    is_free = ~closed
    is_free[start[locked]] = False
    sources, directions = np.nonzero((neighbors >= 0) & is_free[:, None] & is_free[neighbors])
    ends = neighbors[sources, directions]
    graph = coo_matrix((np.ones(len(ends)), (sources, ends)), shape=(len(closed),) * 2)
    _, part = connected_components(graph, directed=False)
    goals[part[goals] != part[start]] = start[part[goals] != part[start]]
    while len(np.unique(goals)) < len(goals):
        vertices, counts = np.unique(goals, return_counts=True)
        is_shared = np.isin(goals, vertices[counts > 1])
        goals[is_shared] = start[is_shared]
