"""Ground truth: collisions, clearances, distances, who never moves, hash of all trajectories."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from swarm_common.model.breaches import Collision
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_sim.physics.engine import NearPair, Touch
from swarm_sim.world.batteries import BatteryVerdict
from swarm_sim.world.close_calls import EPISODE_GAP, CloseCalls, NearMiss
from swarm_sim.world.zone_watch import ZoneVerdict


@dataclass(frozen=True, slots=True)
class RobotVerdict:
    """One robot's share; `min_clearance` is inf if nothing ever came near."""

    distance: float
    collisions: int
    min_clearance: float
    near_misses: int = 0
    battery: BatteryVerdict | None = None  # None without a battery


@dataclass(frozen=True, slots=True)
class Verdict:
    """Ground truth about a run so far."""

    sim_time: float  # [s]
    robot_robot: int  # number of contact episodes between two robots
    robot_world: int  # number of contact episodes of a robot and an obstacle
    min_clearance: float  # [m] smallest distance of any robot from anything; inf if all were far
    collisions: tuple[Collision, ...]  # the episodes in order of time
    near_misses: int = 0  # number of episodes closer than `engine.NEAR_MISS` without contact
    close_calls: tuple[NearMiss, ...] = ()  # these episodes in order of time
    robots: dict[str, RobotVerdict] = field(default_factory=dict)  # by name
    zones: ZoneVerdict | None = None  # None in a world without zones
    trajectory_sha256: str = ""  # of the true poses (float64) of all ticks, in order of robots

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump; a clearance of inf becomes None.

        Robots without a battery have no key `battery`.
        """
        data = asdict(self)
        for part in (data, *data["robots"].values()):
            if np.isinf(part["min_clearance"]):
                part["min_clearance"] = None
        for robot in data["robots"].values():
            if robot["battery"] is None:
                del robot["battery"]
        return data


class Judge:
    """Collects what a verdict needs, tick by tick."""

    def __init__(self, names: Sequence[str], poses: FloatArray, clearances: FloatArray) -> None:
        """Begin with the state at tick 0."""
        self._names = list(names)
        self._collisions: list[Collision] = []
        self._last_touch: dict[tuple[int, int, str], float] = {}
        self._close_calls = CloseCalls(names)
        self._distances = np.zeros(len(names))
        self._min_clearances = np.full(len(names), np.inf)
        self._counts = np.zeros(len(names), np.int64)
        self._positions = poses[:, :2].copy()
        self._hash = hashlib.sha256()
        self._note(poses, clearances)

    def add(self, name: str, pose: FloatArray) -> None:
        """Add a robot, which stands at a pose (3,)."""
        self._names.append(name)
        self._close_calls.add(name)
        self._distances = np.append(self._distances, 0.0)
        self._min_clearances = np.append(self._min_clearances, np.inf)
        self._counts = np.append(self._counts, 0)
        self._positions = np.vstack([self._positions, pose[:2]])

    def place(self, robot: int, pose: FloatArray) -> None:
        """Record that a robot has been put elsewhere; that is no way driven."""
        self._positions[robot] = pose[:2]

    @property
    def collisions(self) -> Sequence[Collision]:
        """The episodes so far, in order of time."""
        return self._collisions

    @property
    def distances(self) -> FloatArray:
        """Ways [m] that the robots have driven, in their order; not to be changed."""
        return self._distances

    def observe(
        self,
        start: float,
        physics_period: float,
        touches: Iterable[Touch],
        poses: FloatArray,
        clearances: FloatArray,
        approaches: Iterable[NearPair] = (),
    ) -> None:
        """Record one control period.

        Args:
            start: [s] simulated time at which it began.
            touches: Contacts in it, in order of steps; one pair may occur several times.
        """
        for touch in touches:
            self._touch(touch, start + (touch.step + 1) * physics_period)
        self._close_calls.observe(start + CONTROL_PERIOD, approaches, poses)
        self._note(poses, clearances)

    def _touch(self, touch: Touch, time: float) -> None:
        key = (touch.robot, touch.other, touch.obstacle)
        is_new = time - self._last_touch.get(key, -np.inf) > EPISODE_GAP + 1e-9
        self._last_touch[key] = time
        self._close_calls.touch(key, time)
        members = [touch.robot] if touch.other < 0 else [touch.robot, touch.other]
        self._min_clearances[members] = 0.0
        if not is_new:
            return
        self._counts[members] += 1
        names = tuple(self._names[member] for member in members)
        self._collisions.append(Collision(names, touch.obstacle, touch.x, touch.y, round(time, 6)))

    def _note(self, poses: FloatArray, clearances: FloatArray) -> None:
        steps = poses[:, :2] - self._positions
        self._distances += np.hypot(steps[:, 0], steps[:, 1])
        self._positions[:] = poses[:, :2]
        np.minimum(self._min_clearances, clearances.min(axis=1), out=self._min_clearances)
        self._hash.update(np.ascontiguousarray(poses, np.float64).tobytes())

    def verdict(
        self, sim_time: float, battery: Callable[[int], BatteryVerdict | None] = lambda _: None
    ) -> Verdict:
        """Return the verdict so far."""
        close_calls = self._close_calls.near_misses()
        shares = Counter(name for call in close_calls for name in call.robots)
        between_robots = sum(len(collision.robots) == 2 for collision in self._collisions)
        return Verdict(
            sim_time=sim_time,
            robot_robot=between_robots,
            robot_world=len(self._collisions) - between_robots,
            min_clearance=float(self._min_clearances.min(initial=np.inf)),
            collisions=tuple(self._collisions),
            near_misses=len(close_calls),
            close_calls=close_calls,
            robots={
                name: RobotVerdict(
                    float(self._distances[robot]),
                    int(self._counts[robot]),
                    float(self._min_clearances[robot]),
                    shares[name],
                    battery(robot),
                )
                for robot, name in enumerate(self._names)
            },
            trajectory_sha256=self._hash.hexdigest(),
        )


ENOUGH = 2.0  # [m] that a robot has to be told to drive, before it is looked at
SHARE = 0.05  # of that, up to which it counts as not moving


class Standstill:
    """Adds up how far robots are told to drive, and finds those that have not moved for it."""

    def __init__(self, count: int) -> None:
        self._told = np.zeros(count)
        self._is_known = np.zeros(count, np.bool_)

    def add(self) -> None:
        """Add a robot."""
        self._told = np.append(self._told, 0.0)
        self._is_known = np.append(self._is_known, False)

    def observe(self, speeds: FloatArray) -> None:
        """Record one control period."""
        self._told += np.hypot(speeds[:, 0], speeds[:, 2]) * CONTROL_PERIOD

    def new(self, ways: FloatArray) -> Iterator[tuple[int, float]]:
        """Yield each robot that does not move, once, and how far [m] it was told to drive.

        Args:
            ways: [m] that the robots have driven.
        """
        stands = (self._told >= ENOUGH) & (ways < SHARE * self._told)
        for robot in np.flatnonzero(stands & ~self._is_known):
            self._is_known[robot] = True
            yield int(robot), float(self._told[robot])
