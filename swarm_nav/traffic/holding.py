"""The holding pattern: where a robot waits until it is its turn at a station (`lease`)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_nav.core.goals import PlanError
from swarm_nav.interfaces import Proposal
from swarm_nav.planning.planner import path_length
from swarm_nav.planning.terrain import HALL_DISTANCE
from swarm_nav.traffic import traffic_costs
from swarm_nav.traffic.robot_state import RobotView
from swarm_nav.traffic.traffic_costs import PARKING_GAP
from swarm_nav.traffic.zone import PARKING_DISTANCE

ARRIVED = 0.3  # [m] from a parking place within which the robot is there
CIRCUIT_LOOKAHEAD = 4.0  # [m] of circuit driven per plan
CIRCUIT_RENEW = 1.5  # [m] before the end of a plan at which the next is made
CIRCUIT_JOIN = 3.0  # [m] from the circuit up to which `auto` joins it
CIRCUIT_CORRIDOR = 0.8  # [m] on either side of the circuit that counts as on it


class HoldingPattern:
    """Waiting place of a robot: on a circuit, or parked out of the lanes."""

    def __init__(
        self,
        circuits: dict[str, tuple[tuple[float, float], ...]],
        stations: list[tuple[float, float]],
    ) -> None:
        """Start outside of any pattern.

        Args:
            circuits: Closed polylines (x, y) [m] in map by name, in driving order, without the
                first point again at the end. Those of fewer than three points are left out.
            stations: (x, y) [m] in map, which parked robots keep free.
        """
        self._circuits = [_closed(points) for points in circuits.values() if len(points) >= 3]
        self._stations = stations
        self._next_search_tick = 0
        self.is_on_circuit = False
        self.target: tuple[float, float] | None = None

    def enter(self, robot: RobotView) -> None:
        """Choose the pattern: `circuit`, `park`, or by the room on the circuit (`auto`)."""
        mode = robot.config.holding.mode
        circuit = self._nearest_circuit(robot)
        if mode == "auto":
            self.is_on_circuit = circuit is not None and self._has_room(robot, circuit)
        else:
            self.is_on_circuit = mode == "circuit" and circuit is not None
        self._next_search_tick = robot.tick
        self.target = None

    def leave(self) -> None:
        """Give up the pattern."""
        self.is_on_circuit = False
        self.target = None

    def propose(
        self, robot: RobotView, kept_free: Callable[[], NDArray[np.bool_] | None]
    ) -> Proposal | None:
        """Propose the next piece of the circuit, or a parking place until one is reached.

        Args:
            kept_free: Returns the lattice cells (h, w) that are no parking places, None without
                any; called only when the robot looks for one.
        """
        if self.is_on_circuit:
            return self._drive_circuit(robot)
        if robot.tick < self._next_search_tick or not self._needs_place(robot):
            return None
        self._next_search_tick = robot.tick + robot.wait_ticks
        path = parking_path(robot, self._stations, kept_free())
        if path is None or len(path) < 2:
            return None
        self.target = (float(path[-1, 0]), float(path[-1, 1]))
        return Proposal(path=path)

    def _needs_place(self, robot: RobotView) -> bool:
        if self.target is None:
            return True
        if not robot.tube.is_complete:
            return robot.waited_ticks > robot.wait_ticks
        return robot.distance_to(*self.target) > ARRIVED

    def _nearest_circuit(self, robot: RobotView) -> FloatArray | None:
        near = [c for c in self._circuits if _circuit_gap(c, robot)[0] < CIRCUIT_JOIN]
        if near or robot.config.holding.mode == "auto":
            return near[0] if near else None
        if not self._circuits:
            return None
        return min(self._circuits, key=lambda c: _circuit_gap(c, robot)[0])

    def _has_room(self, robot: RobotView, circuit: FloatArray) -> bool:
        """Whether few enough robots are near the part of the circuit that the radio covers."""
        x, y = robot.pose.x, robot.pose.y
        reach = robot.config.traffic.radio_range
        heard = circuit[np.hypot(circuit[:, 0] - x, circuit[:, 1] - y) < reach]
        poses = robot.neighbors.heads["pose"]
        on_it = 0
        for pose in poses:
            gaps = np.hypot(circuit[:, 0] - pose[0], circuit[:, 1] - pose[1])
            on_it += bool(gaps.min() < CIRCUIT_CORRIDOR)
        room = len(heard) * _CIRCUIT_SPACING / robot.config.holding.circuit_spacing
        return on_it + 1 <= room

    def _drive_circuit(self, robot: RobotView) -> Proposal | None:
        circuit = self._nearest_circuit(robot)
        if circuit is None:
            self.is_on_circuit = False
            return None
        is_late = robot.tick < self._next_search_tick
        if is_late or robot.tube.length_ahead() > CIRCUIT_RENEW:
            return None
        self._next_search_tick = robot.tick + robot.ticks(1.0)
        _, nearest = _circuit_gap(circuit, robot)
        ahead = nearest + int(CIRCUIT_LOOKAHEAD / _CIRCUIT_SPACING)
        point = circuit[ahead % len(circuit)]
        path = self._way_to(robot, (float(point[0]), float(point[1])))
        if path is None:
            self.is_on_circuit = False  # park instead
            return None
        self.target = None
        return Proposal(path=path)

    def _way_to(self, robot: RobotView, point: tuple[float, float]) -> FloatArray | None:
        """Return the way to a point of the circuit, None if there is no short one."""
        extra = traffic_costs.congestion(robot)
        try:
            path = robot.planner.plan(robot.stop_point, point, extra)
        except PlanError:
            return None
        return path if path_length(path) <= 3.0 * CIRCUIT_LOOKAHEAD + CIRCUIT_JOIN else None


def parking_path(
    robot: RobotView,
    stations: list[tuple[float, float]],
    closed: NDArray[np.bool_] | None = None,
    reach: float | None = None,
    allowed: NDArray[np.bool_] | None = None,
) -> FloatArray | None:
    """Return the way (n, 2) to the nearest free parking place, None if there is none in reach.

    Args:
        stations: (x, y) [m] in map, to keep away from.
        closed: (h, w) lattice cells that are no places; None for none.
        reach: Cost [m] of the longest way; None for `holding.search_distance`.
        allowed: (h, w) lattice cells to park on; None for those out of the lanes, which a map of
            narrow aisles has not.
    """
    lattice = robot.planner.lattice
    taken = robot.planner.no_extra()
    if stations:
        traffic_costs.stamp(taken, robot, np.array(stations), 2.0 * PARKING_DISTANCE, 1.0)
        taken[lattice.clearance <= HALL_DISTANCE] = 0.0
        traffic_costs.stamp(taken, robot, np.array(stations), PARKING_DISTANCE, 1.0)
    neighbors = robot.neighbors
    traffic_costs.stamp_tubes(taken, robot, PARKING_GAP, 1.0)
    targets = neighbors.heads["target"]
    for row in np.flatnonzero(np.isfinite(targets[:, 0])):
        traffic_costs.stamp(taken, robot, targets[row], robot.reach(int(row)) + PARKING_GAP, 1.0)
    if closed is not None:
        taken[closed] = 1.0
    places = robot.planner.free_places(taken, lattice.parking if allowed is None else allowed)
    extra = traffic_costs.congestion(robot)
    limit = robot.config.holding.search_distance if reach is None else reach
    return robot.planner.nearest(robot.stop_point, extra, places, limit)


_CIRCUIT_SPACING = 0.25  # [m] between the points of a closed circuit


def _closed(points: tuple[tuple[float, float], ...]) -> FloatArray:
    """Return the closed polyline with a point every `_CIRCUIT_SPACING`."""
    corners = np.array((*points, points[0]))
    pieces = []
    for a, b in itertools.pairwise(corners):
        count = max(1, round(math.hypot(*(b - a)) / _CIRCUIT_SPACING))
        pieces.append(a + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (b - a))
    return np.vstack(pieces)


def _circuit_gap(circuit: FloatArray, robot: RobotView) -> tuple[float, int]:
    """Return (distance [m], index) of the nearest point of a circuit."""
    x, y = robot.stop_point
    gaps = np.hypot(circuit[:, 0] - x, circuit[:, 1] - y)
    nearest = int(gaps.argmin())
    return float(gaps[nearest]), nearest
