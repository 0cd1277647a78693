"""History of a run from statuses, verdicts and poses: marks, states, curves, places."""

from __future__ import annotations

import math
from bisect import bisect_right, insort
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.middleware.ros_io import tick_of
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_common.model.robot_names import natural
from swarm_view.state.decode import ReportedState

LONG_WAIT = 60.0  # [s] from which a wait is marked
WAITING = frozenset({"waiting", "yielding", "holding"})
MOST_POSES = 36_000  # moments whose poses are kept: an hour at full rate
MOST_POINTS = 2000  # of a way
SAMPLE = 5.0  # [s] between two counts of the robots in each state
CLEAREST = 1.0  # [m] of clearance that is drawn, at most
Moment = tuple[int, tuple[str, ...], NDArray[np.float32]]  # tick, names, poses (n, 3) in map


class Kind(Enum):
    """Kind of a mark on the time line; the value is the name shown there."""

    COLLISION = "collisions"
    NEAR_MISS = "near misses"
    WAIT = "waits over 60 s"
    FAULT = "faults"
    GOAL = "goals"


FIRST = 5.0  # [s] from the first message in which that of each robot arrives


@dataclass(slots=True)
class Mark:
    """Something that happened."""

    time: float  # [s] when it began
    kind: Kind  # of what it is
    text: str  # what happened, for people
    robot: str = ""  # whose it is; empty for none
    end: float = 0.0  # [s] of a wait; the same as `time` of all else


@dataclass(slots=True)
class StateChange:
    """A robot's state from a time on."""

    time: float
    state: ReportedState


@dataclass(slots=True)
class _Robot:
    changes: list[StateChange] = field(default_factory=list)
    is_known: bool = False  # whether what it says now follows what it said before
    waits_since: float | None = None
    wait: Mark | None = None


class History:
    """History of a run between the first and the last message.

    Attributes:
        start: [s] of the first message; None before it.
        marks: In the order of their times.
        gaps: (from, to) [s] of which nothing is known: nobody listened.
        revision: Grows with every mark and gap.
    """

    def __init__(self, period: float = 0.0) -> None:
        """Know nothing; keep poses that are at least `period` [s] apart."""
        self.start: float | None = None
        self.end = 0.0
        self.marks: list[Mark] = []
        self.gaps: list[tuple[float, float]] = []
        self.revision = 0
        self._period = period
        self._is_interrupted = False
        self._robots: dict[str, _Robot] = defaultdict(_Robot)
        self._counts: tuple[int, int, int] | None = (0, 0, 0)  # of the last verdict, if it is known
        self._latest: dict[str, str] = {}  # states
        self._samples: list[tuple[float, Counter[str]]] = []
        self._sample_due = 0.0
        self._clearance: list[tuple[float, float]] = []
        self._factors: list[tuple[float, float]] = []
        self._poses: list[Moment] = []
        self._reached: list[float] = []  # times of goals

    def interrupt(self) -> None:
        """Forget the counts: what happens until the next messages has no time of its own."""
        self._counts = None
        self._is_interrupted = self.start is not None
        for robot in self._robots.values():
            robot.is_known, robot.waits_since, robot.wait = False, None, None

    # Messages

    def add_poses(self, tick: int, names: Sequence[str], poses: FloatArray) -> None:
        """Add poses (n, 3) of robots: x, y [m], yaw [rad] in map."""
        time = self._see(tick)
        if self._poses and time < self._poses[-1][0] * CONTROL_PERIOD + self._period:
            return
        if self._poses and self._poses[-1][1] == tuple(names):
            names = self._poses[-1][1]  # one tuple for all
        elif self._poses:
            for gone in self._latest.keys() - set(names):
                del self._latest[gone]
        self._poses.append((tick, tuple(names), poses.astype(np.float32)))
        if len(self._poses) > MOST_POSES:
            del self._poses[: MOST_POSES // 10]

    def add_status(self, robot: str, state: ReportedState) -> None:
        """Add a robot's report of its state."""
        time, known = self._see(state.tick), self._robots[robot]
        self._latest[robot] = state.state
        if time >= self._sample_due:
            self._sample_due = time + SAMPLE
            self._samples.append((time, Counter(self._latest.values())))
        before = known.changes[-1].state if known.changes else None
        if before is not None:
            if state.tick < before.tick:
                return
            if known.is_known:
                self._compare(robot, before, state, time)
            elif self.gaps:
                self._fill_gap(robot, state.goals_reached - before.goals_reached, time)
        known.is_known = True
        self._follow_wait(robot, known, state, time)
        if before is None or _said(before) != _said(state):
            known.changes.append(StateChange(time, state))

    def add_verdict(self, verdict: Any) -> None:
        """Add a verdict of the world on the run."""
        time = self._see(tick_of(verdict.stamp))
        counts = (
            int(verdict.collisions_robot_robot),
            int(verdict.collisions_robot_world),
            int(verdict.near_misses),
        )
        before, self._counts = self._counts or counts, counts
        pair = "" if counts == before else " and ".join(self._nearest_pair())
        between = f"; nearest to each other: {pair}" if pair else ""
        kinds = (
            (Kind.COLLISION, f"robot touches robot{between}"),
            (Kind.COLLISION, "robot touches the world"),
            (Kind.NEAR_MISS, f"near miss{between}"),
        )
        for (kind, text), now, old in zip(kinds, counts, before, strict=True):
            if now > old:
                self._mark(Mark(time, kind, text if now == old + 1 else f"{now - old} x {text}"))
        self._factors.append((time, float(verdict.real_time_factor)))
        if math.isfinite(verdict.min_clearance):
            self._clearance.append((time, min(CLEAREST, float(verdict.min_clearance))))

    def _see(self, tick: int) -> float:
        time = tick * CONTROL_PERIOD
        self.start = time if self.start is None else min(self.start, time)
        if self._is_interrupted and time > self.end:
            self._is_interrupted = False
            self.gaps.append((self.end, time))
            self.revision += 1
        self.end = max(self.end, time)
        return time

    def _compare(
        self, robot: str, before: ReportedState, state: ReportedState, time: float
    ) -> None:
        for _ in range(state.goals_reached - before.goals_reached):
            self._reached.append(time)
            where = f" at {before.station}" if before.station else ""
            self._mark(Mark(time, Kind.GOAL, f"{robot} reaches its goal{where}", robot))
        if state.goals_failed > before.goals_failed:
            self._mark(Mark(time, Kind.FAULT, f"{robot} misses a goal", robot))
        if state.state != before.state and state.state == "recovering":
            self._mark(Mark(time, Kind.FAULT, f"{robot} recovers: {state.detail}", robot))
        if state.state == "inactive" and before.state != "inactive":
            self._mark(Mark(time, Kind.FAULT, f"{robot} is inactive: {state.detail}", robot))

    def _fill_gap(self, robot: str, goals: int, time: float) -> None:
        """Place goals that a robot reached in the last gap evenly in it: nobody saw when."""
        since = self.gaps[-1][0]
        for number in range(goals):
            at = since + (number + 1) / (goals + 1) * (time - since)
            insort(self._reached, at)
            self._mark(Mark(at, Kind.GOAL, f"{robot} reaches a goal while no page is open", robot))

    def _follow_wait(self, robot: str, known: _Robot, state: ReportedState, time: float) -> None:
        if state.state not in WAITING:
            known.waits_since = known.wait = None
            return
        if known.waits_since is None:
            known.waits_since = time
        since = known.waits_since
        if known.wait is None and time - since > LONG_WAIT:
            text = f"{robot} waits: {state.detail or state.state}"
            known.wait = Mark(since, Kind.WAIT, text, robot, time)
            self._mark(known.wait)
        if known.wait is not None:
            known.wait.end = time

    def _mark(self, mark: Mark) -> None:
        mark.end = max(mark.end, mark.time)
        insort(self.marks, mark, key=lambda known: known.time)
        self.revision += 1

    def _nearest_pair(self) -> tuple[str, ...]:
        if not self._poses or len(self._poses[-1][1]) < 2:
            return ()
        _, names, poses = self._poses[-1]
        pairs = list(combinations(range(len(names)), 2))
        one, other = np.array(pairs).T
        gaps = np.hypot(*(poses[one, :2] - poses[other, :2]).T)
        i, j = pairs[int(gaps.argmin())]
        return names[i], names[j]

    # Questions

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s]."""
        return self.start or 0.0, self.end

    def gap_at(self, time: float) -> tuple[float, float] | None:
        """Return the gap that a time [s] lies in; None if something is known of it."""
        return next((gap for gap in self.gaps if gap[0] < time < gap[1]), None)

    def moment(self, time: float) -> Moment | None:
        """Return the last poses up to a time [s]; None if there are none."""
        tick = round(time / CONTROL_PERIOD)
        place = bisect_right(self._poses, tick, key=lambda moment: moment[0])
        return self._poses[place - 1] if place else None

    def state_at(self, robot: str, time: float) -> ReportedState | None:
        """Return what a robot said of itself last, up to a time [s]."""
        changes, place = self._until(robot, time)
        return changes[place - 1].state if place else None

    def state_since(self, robot: str, time: float) -> float | None:
        """Return since when [s] a robot was in the state that it was in at a time [s]."""
        changes, place = self._until(robot, time)
        while place > 1 and changes[place - 2].state.state == changes[place - 1].state.state:
            place -= 1
        return changes[place - 1].time if place else None

    def saw_begin(self, robot: str, since: float) -> bool:
        """Whether a robot came into a state at a time [s], or was in it when we began to listen."""
        changes, _ = self._until(robot, since)
        start = self.start or 0.0
        is_first = bool(changes) and changes[0].time >= since
        return not is_first or start < FIRST or since > start + FIRST

    def _until(self, robot: str, time: float) -> tuple[list[StateChange], int]:
        """Return the changes of a robot, and how many of them happened up to a time [s]."""
        changes = self._robots[robot].changes if robot in self._robots else []
        return changes, bisect_right(changes, time, key=lambda change: change.time)

    def changes(self, robot: str, until: float, count: int) -> list[StateChange]:
        """Return the last changes of a robot's state up to a time [s], the newest first."""
        found: list[StateChange] = []
        known, place = self._until(robot, until)
        shown: tuple[str, str] | None = None
        for change in reversed(known[:place]):
            before, shown = shown, (change.state.state, change.state.station)
            if before == shown:
                found[-1] = change  # it began earlier
            elif len(found) == count:
                break
            else:
                found.append(change)
        return found

    def way(self, robot: str, until: float, spacing: float = 0.1) -> FloatArray:
        """Return where a robot has been (n, 2) up to a time [s], in map."""
        points: list[tuple[float, float]] = []
        for tick, names, poses in self._poses[:: 1 + len(self._poses) // MOST_POINTS]:
            if tick * CONTROL_PERIOD > until:
                break
            if robot not in names:
                continue
            x, y, _ = poses[names.index(robot)].tolist()
            if not points or math.dist((x, y), points[-1]) >= spacing:
                points.append((x, y))
        return np.array(points, np.float64).reshape(-1, 2)

    def throughput(self, window: float = 60.0, step: float = 5.0) -> tuple[FloatArray, FloatArray]:
        """Return times [s] and the goals per minute in the window before each."""
        start, end = self.span
        spacing = max(step, (end - start) / 1000.0)
        times = np.arange(start, end + spacing, spacing)
        reached, since = np.array(self._reached), np.maximum(times - window, start)
        counts = np.searchsorted(reached, times, "right") - np.searchsorted(reached, since, "right")
        return times, 60.0 * counts / np.maximum(times - since, step)

    def states(self, states: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Return times [s] (n,) and how many robots are in each of the states then (states, n)."""
        times = np.array([time for time, _ in self._samples])
        rows = [[counts[state] for _, counts in self._samples] for state in states]
        return times, np.array(rows, np.float64).reshape(len(states), -1)

    def lanes(self, shortest: float) -> dict[str, list[tuple[float, float, str]]]:
        """Return by robot what it did: (from [s], until [s], state), joined where it is equal.

        Args:
            shortest: [s] below which a part is left to the one before.
        """
        found: dict[str, list[tuple[float, float, str]]] = {}
        for robot in sorted(self._robots, key=natural):
            parts: list[tuple[float, float, str]] = []
            changes = self._robots[robot].changes
            ends = [*(change.time for change in changes[1:]), self.end]
            for change, end in zip(changes, ends, strict=True):
                state = change.state.state
                if parts and (parts[-1][2] == state or end - change.time < shortest):
                    since, _, state = parts.pop()
                    parts.append((since, end, state))
                else:
                    parts.append((change.time, end, state))
            found[robot] = parts
        return found

    def factors(self) -> tuple[FloatArray, FloatArray]:
        """Return times [s] and the real-time factor at each."""
        array = np.array(self._factors, np.float64).reshape(-1, 2)
        return array[:, 0], array[:, 1]

    def clearance(self) -> tuple[FloatArray, FloatArray]:
        """Return times [s] and the smallest clearance [m] of the run up to each."""
        array = np.array(self._clearance, np.float64).reshape(-1, 2)
        return array[:, 0], array[:, 1]


def _said(state: ReportedState) -> tuple[Any, ...]:
    goal = None if state.goal_map is None else (state.goal_map.x, state.goal_map.y)
    return (
        state.state, state.detail, state.station, state.queue_place, goal,
        state.goals_reached, state.goals_failed,
    )  # fmt: skip
