"""The centre that decides who goes first; robots hold space, track and filter as they do alone.

It plans as `mapf` does. But its robots are our navigators: what it gives a robot is a path, of
which the robot takes space by the reservation protocol. So whatever is lost or late, whoever dies,
safety does not depend on the centre, and robots may go on by their own rules and come back.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_central.grant_kernels import free_length
from swarm_central.mapf import PIECE, MapfCentre
from swarm_central.progress import Point, RobotProgress
from swarm_central.roadmap import RoadmapError
from swarm_central.team import RobotReport, TeamOrder
from swarm_common.model.central import SERIAL_BITS
from swarm_common.model.grid import Grid
from swarm_common.model.records import RobotSpec
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig

GAP = 0.16  # [m] in place of `central.gap`: held spaces keep the margins of both robots apart
LOOKAHEAD = 0.6  # [m] in place of `central.lookahead`: a request takes time to be acknowledged
SIGN_OF_LIFE = 5  # ticks between two messages to a robot that gets no new way
MOST_COMMANDS = 1 << (32 - SERIAL_BITS)


class ReservationCentre(MapfCentre):
    """Gives paths to navigators, which it first takes under its command, one by one."""

    arrived_share = 0.6  # navigators stop up to 5 cm before the end of their way
    stop_share = 0.5  # and a way of less than 6 cm is none to them

    def __init__(
        self,
        config: NavConfig,
        specs: Sequence[RobotSpec],
        grid: Grid,
        sites: Sites,
        central: Mapping[str, Any] | None = None,
        first_command: int = 1,
    ) -> None:
        """Make the roadmap.

        Args:
            grid: The map.
            central: Parameters of the centre by name; None for the defaults.
            first_command: From 1: another one than the centre before used.

        Raises:
            RoadmapError: If robots of this size find no roadmap in the map.
        """
        own = {"margin": config.traffic.safety_margin, "gap": GAP, "lookahead": LOOKAHEAD}
        super().__init__(config, specs, grid, sites, own | dict(central or {}))
        numbers = itertools.cycle(range(1, MOST_COMMANDS))
        self._numbers = itertools.islice(numbers, first_command - 1, None)
        self._commands: dict[int, int] = {}  # that each robot is under, or is to come under
        self._away: dict[int, RobotReport] = {}  # robots that are not under command
        self._refused = 0

    def observe(self, tick: int, states: Sequence[RobotReport]) -> None:
        """Receive the reports that arrived in a tick.

        Args:
            states: At most one per robot.
        """
        led: list[RobotReport] = []
        for report in states:
            robot_id = report.robot_id
            command = report.heard >> SERIAL_BITS
            if command and command == self._commands.get(robot_id):
                self._away.pop(robot_id, None)
                led.append(report)
                continue
            if robot_id not in self._away:
                self.forget(robot_id)
                self._commands[robot_id] = next(self._numbers)
            self._away[robot_id] = report
        try:
            super().observe(tick, led)
        except RoadmapError:  # they stand, or go on alone, and are asked again
            self._refused += len(self._first)
            self._first.clear()

    def _barred(self, report: RobotReport, vertices: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return (n,) where somebody stands on the way: robots may come from anywhere."""
        others = [r for r in (*self._first.values(), *self._away.values()) if r is not report]
        lines = [(*a, *b) for robot in self._robots.values() for a, b in robot.held()]
        lines += [(r.pose_map.x, r.pose_map.y) * 2 for r in others]
        segments, owners = np.array(lines).reshape(-1, 4), np.ones(len(lines), np.int64)
        radii = np.full(2, self._radii.max())
        start = report.pose_map.x, report.pose_map.y
        found = []
        for vertex in vertices.tolist():
            end = self._point(vertex)
            length = math.dist(start, end)
            free = free_length(start, end, length, PIECE, 0, segments, owners, radii)
            found.append(free <= length - 1e-6)
        return np.array(found, np.bool_)

    def _enter(self, robot: RobotProgress, first: Point) -> None:
        """Give all of the way at once, while it is free: else two may bar each other half way."""
        robot.aim = first
        robot.extend(math.dist(robot.stop, first))

    def forget(self, robot_id: int) -> None:
        """Forget a robot: it is no longer under command, or was taken out.

        Args:
            robot_id: From 1.
        """
        self._away.pop(robot_id, None)
        self._first.pop(robot_id, None)
        if self._robots.pop(robot_id, None) is not None:
            self._forget_plan()

    def decide(self) -> Sequence[TeamOrder]:
        """Return the orders to send now, and signs of life."""
        orders = list(super().decide())
        addressed = {order.robot_id for order in orders}
        orders += [
            _sign(robot_id, self._commands[robot_id] << SERIAL_BITS) for robot_id in self._away
        ]
        if self._tick % SIGN_OF_LIFE == 0:
            reports = [*(r.report for r in self._robots.values()), *self._first.values()]
            orders += [_sign(r.robot_id, r.heard) for r in reports if r.robot_id not in addressed]
        return orders

    def figures(self) -> Mapping[str, float]:
        """Return counters for the result of a run."""
        return {**super().figures(), "commands": len(self._commands), "refused": self._refused}

    def _obstacles(self) -> Iterator[Point]:
        yield from super()._obstacles()
        for report in (*self._away.values(), *self._first.values()):
            yield report.pose_map.x, report.pose_map.y


def _sign(robot_id: int, number: int) -> TeamOrder:
    return TeamOrder(robot_id=robot_id, number=number, first=0, points_map=())
