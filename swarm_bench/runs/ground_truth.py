"""Standing, circles of waiting, deadlocks and use of stations, as the simulator sees them.

A method's own words do not count: all follows from true poses and from the goals that were sent.
A robot *stands* if it has a goal, is not there, and has neither moved nor turned for 3 s. It waits
for the nearest robot that is close to it and ahead, in the direction of the shortest way, or else
for the robot that is at its goal. Robots that wait for each other are a circle of waiting.
"""

from __future__ import annotations

import math
from array import array
from collections import deque
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, wrap_angle
from swarm_mission.wait_graph import WaitGraph
from swarm_mission.way_table import WayTable
from swarm_nav.interfaces import Reserving
from swarm_run.loop import Driver
from swarm_run.record.figures import percentiles
from swarm_run.record.run_record import GroundTruth, StationShare

EVERY = 10  # ticks between two looks
WINDOW = 3  # looks in which a robot that stands has not moved
STILL = 0.06  # [m] that it may have moved
TURNED = 0.2  # [rad] that it may have turned
CLOSE = 0.5  # [m] between the bodies of a robot and of one in its way
AHEAD = 0.5  # cosine of the largest angle between the way and the robot in it
ARRIVED = 0.35  # [m] from a goal at which a robot is there
APPROACHES = 1.5  # [m] from a station within which a robot on its way there approaches it
PROGRESS = 0.1  # [m] nearer to a goal than ever before
LASTING = 30.0  # [s] of a circle of waiting that is a deadlock
STANDSTILL = 60.0  # [s] without progress of anybody that is one


@dataclass(slots=True)
class _Errand:
    """A goal that was sent to a robot."""

    goal: Pose
    station: str  # name of the goal
    start_tick: int
    nearest: float = math.inf  # [m] of way that was left at the least


class GroundTruthWatch:
    """Watch over what all robots of a run do, once a second."""

    def __init__(
        self,
        names: Sequence[str],
        radii: Sequence[float],
        grid: Grid,
        stations: Iterable[str],
        warm_up: float,
    ) -> None:
        """Begin.

        Args:
            radii: [m] of their bodies.
            grid: The map.
            stations: Names of the places whose use is measured.
            warm_up: [s] that do not count for shares of time.
        """
        self._names = names
        self._radii = np.asarray(radii)
        self._ways = WayTable(grid, float(self._radii.min()))
        self._warm_up = warm_up
        self._errands: list[_Errand | None] = [None] * len(names)
        self._trail: deque[FloatArray] = deque(maxlen=WINDOW + 1)
        self._waits = WaitGraph()
        self._standing = np.zeros(len(names))  # [s] of each robot at present
        self._stood_time = self._stood_worst = self._stood_late = self._late = 0.0
        self._occupied = dict.fromkeys(stations, 0.0)
        self._approached = dict.fromkeys(stations, 0.0)
        self._goals: dict[str, Pose] = {}  # of stations that anybody was sent to
        self._last_progress = 0.0  # [s]
        self._standstills: list[tuple[float, float]] = []  # from, to [s]

    def send(self, index: int, goal: Pose, station: str, start_tick: int) -> None:
        """Note that a robot was sent to a goal.

        Args:
            start_tick: From which it may set off.
        """
        self._errands[index] = _Errand(goal, station, start_tick)
        if station in self._occupied:
            self._goals[station] = goal

    def end(self, index: int, sim_time: float) -> None:
        """Note that a goal has ended.

        Args:
            sim_time: [s] now.
        """
        self._errands[index] = None
        self._progress(sim_time)

    def look(self, tick: int, poses: FloatArray) -> None:
        """Look at all robots; once in `EVERY` ticks.

        Args:
            poses: (n, 3) true poses in map.
        """
        now, period = tick * CONTROL_PERIOD, EVERY * CONTROL_PERIOD
        self._trail.append(np.array(poses))
        places = self._trail[-1][:, :2]
        is_late = now > self._warm_up
        self._late += period * len(poses) if is_late else 0.0
        for index, errand in enumerate(self._errands):
            other = -1
            if errand is not None and tick >= errand.start_tick:
                left = self._ways.left(errand.goal, *places[index])
                if left < errand.nearest - PROGRESS:
                    errand.nearest = left
                    self._progress(now)
                if self._is_still(index) and left > ARRIVED:
                    other = self._in_the_way(index, errand.goal, places)
                    self._stand(index, period, is_late=is_late)
                else:
                    self._standing[index] = 0.0
            else:
                self._standing[index] = 0.0
            name = self._names[other] if other >= 0 else ""
            self._waits.note(self._names[index], name, now)
        if not any(self._errands):
            self._progress(now)
        if is_late:
            self._use_stations(places, period)

    def figures(self, sim_time: float) -> GroundTruth:
        """Return the figures of a run that is over.

        Args:
            sim_time: [s] of its end.
        """
        self._progress(sim_time)
        circles = self._waits.as_json(sim_time)
        lasting = [
            (since, since + span) for _, since, span in self._waits.lasting if span >= LASTING
        ]
        alone = [
            one for one in self._standstills
            if not any(start < one[1] and one[0] < end for start, end in lasting)
        ]  # fmt: skip
        measured = max(self._late / len(self._names), EVERY * CONTROL_PERIOD)
        return GroundTruth(
            stood_time=self._stood_time,
            stood_worst=self._stood_worst,
            stood_share=self._stood_late / self._late if self._late else 0.0,
            circles=circles["lasting_circles"],
            longest_circle=circles["longest_circle"],
            deadlocks=len(lasting) + len(alone),
            stations={
                name: StationShare(
                    occupied=seconds / measured, approached=self._approached[name] / measured
                )
                for name, seconds in self._occupied.items()
                if name in self._goals
            },
        )

    def _stand(self, index: int, period: float, *, is_late: bool) -> None:
        self._standing[index] += period
        self._stood_time += period
        self._stood_late += period if is_late else 0.0
        self._stood_worst = max(self._stood_worst, float(self._standing[index]))

    def _progress(self, now: float) -> None:
        if now - self._last_progress >= STANDSTILL:
            self._standstills.append((self._last_progress, now))
        self._last_progress = now

    def _is_still(self, index: int) -> bool:
        if len(self._trail) <= WINDOW:
            return False
        before, now = self._trail[0][index], self._trail[-1][index]
        moved = math.hypot(now[0] - before[0], now[1] - before[1])
        return moved < STILL and abs(wrap_angle(now[2] - before[2])) < TURNED

    def _in_the_way(self, index: int, goal: Pose, places: FloatArray) -> int:
        """Return the robot that one waits for; -1 for none."""
        apart = places - places[index]
        distances = np.hypot(*apart.T)
        distances[index] = np.inf
        gaps = distances - self._radii - self._radii[index]
        way = self._ways.direction(goal, *places[index])
        ahead = apart @ way >= AHEAD * distances
        candidates = np.where(ahead & (gaps <= CLOSE), gaps, np.inf)
        nearest = int(candidates.argmin())
        if np.isfinite(candidates[nearest]):
            return nearest
        from_goal = np.hypot(*(places - (goal.x, goal.y)).T)
        from_goal[index] = np.inf
        nearest = int(from_goal.argmin())
        return nearest if from_goal[nearest] <= ARRIVED else -1

    def _use_stations(self, places: FloatArray, period: float) -> None:
        occupied, approached = set[str](), set[str]()
        for name, goal in self._goals.items():
            if (np.hypot(*(places - (goal.x, goal.y)).T) <= ARRIVED).any():
                occupied.add(name)
        for errand, place in zip(self._errands, places, strict=True):
            if errand is not None and errand.station in self._goals:
                goal = errand.goal
                if math.hypot(place[0] - goal.x, place[1] - goal.y) <= APPROACHES:
                    approached.add(errand.station)
        for name in occupied:
            self._occupied[name] += period
        for name in occupied | approached:
            self._approached[name] += period


class PoseErrors:
    """Distances [m] of estimated poses from the true ones, of all robots in all ticks so far."""

    def __init__(self) -> None:
        self._values = array("f")

    def note(self, drivers: Sequence[Driver], truth_map: FloatArray, dead: Collection[int]) -> None:
        """Record the pose errors of a tick.

        Args:
            drivers: What decides for each robot; only those that reserve space are asked.
            truth_map: True poses (n, 3) in map.
            dead: Indices of the robots that do nothing.
        """
        for index, driver in enumerate(drivers):
            if index not in dead and isinstance(driver, Reserving):
                pose = driver.services.pose_map
                self._values.append(
                    float(np.hypot(pose.x - truth_map[index, 0], pose.y - truth_map[index, 1]))
                )

    def figures(self) -> dict[str, float] | None:
        """Return `median`, `p95` and `max` [m]; None if nobody was asked."""
        return percentiles(self._values, median=50, p95=95, max=100) if self._values else None
