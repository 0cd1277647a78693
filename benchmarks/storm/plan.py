"""Events of a storm, drawn from its seed: failing navigators, crates, people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from benchmarks.storm.reachable import Floor
from swarm_common.model.records import Pose
from swarm_describe.worlds.actors import WalkerSpec

FOR_EVER = 1 << 40  # [ticks]
FIRST, LAST = 100, 1200  # ticks between which things begin
SHORTEST, LONGEST = 15, 600  # [ticks] of a failure
FAILURES_PER_ROBOT = 0.8
DEATHS_FOR_GOOD = 0.25  # share of the robots that do not come back, at most
CRATES = 3
PEOPLE = 2
CRATE_SIDES = (0.25, 0.6)  # [m]
WALK_CLEARANCE = 0.4  # [m] of a person's way from walls
WALK_LENGTHS = (3.0, 9.0)  # [m]
START_ROOM = 1.0  # [m] from robots' centres, somewhere along it


class Failure(Enum):
    """Failure of a navigator."""

    KILLED = "killed"  # does and says nothing; a new one takes over, unless it is for good
    HUNG = "hung"  # likewise, then it goes on where it was
    MUTE = "mute"  # nobody gets its beacons
    DEAF = "deaf"  # gets no beacons, and knows it


@dataclass(frozen=True, slots=True)
class Fault:
    """One failure of one robot."""

    robot: int  # index
    failure: Failure  # which
    begin: int  # tick
    end: int  # tick at which the failure ends; `FOR_EVER` if it never does

    def is_on(self, tick: int) -> bool:
        """True while the failure lasts."""
        return self.begin <= tick < self.end


@dataclass(frozen=True, slots=True)
class Crate:
    """A box that nobody knew of."""

    tick: int  # from which it is to be put down, once there is room
    side: float  # [m]
    yaw: float  # [rad]


@dataclass(frozen=True, slots=True)
class StormPlan:
    """All that happens in one storm."""

    faults: tuple[Fault, ...]
    crates: tuple[Crate, ...]
    walkers: tuple[WalkerSpec, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of failures by kind; of kills, those for good apart."""
        counts = {failure.value: 0 for failure in Failure} | {"for_good": 0}
        for fault in self.faults:
            counts[fault.failure.value] += 1
            counts["for_good"] += fault.end >= FOR_EVER
        return counts


def draw_plan(seed: int, robots: int, floor: Floor, homes_map: Sequence[Pose]) -> StormPlan:
    """Return what happens in a storm; equal arguments give equal storms.

    People start away from `homes_map`, the robots' start poses. Raises ValueError if the map has
    no place with room for a person.
    """
    rng = np.random.default_rng((seed, 12))
    faults = draw_faults(rng, robots)
    crates = tuple(
        Crate(
            int(rng.integers(0, LAST)),
            float(rng.uniform(*CRATE_SIDES)),
            float(rng.uniform(0, math.pi)),
        )
        for _ in range(CRATES)
    )
    walkers = tuple(
        WalkerSpec(name=f"person_{number}", path=path)
        for number in range(1, PEOPLE + 1)
        if (path := _walk(rng, floor, homes_map)) is not None
    )
    return StormPlan(faults, crates, walkers)


def draw_faults(rng: np.random.Generator, robots: int) -> tuple[Fault, ...]:
    """Return the failures of a storm; a robot has one at a time."""
    faults: list[Fault] = []
    free_from = [0] * robots
    lost = 0
    for begin in sorted(rng.integers(FIRST, LAST, round(FAILURES_PER_ROBOT * robots)).tolist()):
        robot = int(rng.integers(robots))
        failure = list(Failure)[int(rng.integers(len(Failure)))]
        length = SHORTEST * (LONGEST / SHORTEST) ** rng.random()
        is_final = failure is Failure.KILLED and rng.random() < 0.5
        if begin < free_from[robot]:
            continue
        is_final = is_final and lost < int(DEATHS_FOR_GOOD * robots)
        lost += is_final
        end = FOR_EVER if is_final else begin + round(length)
        free_from[robot] = end + FIRST
        faults.append(Fault(robot, failure, begin, end))
    return tuple(faults)


def _walk(
    rng: np.random.Generator, floor: Floor, homes_map: Sequence[Pose]
) -> tuple[tuple[float, float], ...] | None:
    """Return the ends of a straight way on free ground with room to start; None: there is none."""
    homes = np.array([(home.x, home.y) for home in homes_map]).reshape(-1, 2)
    for _ in range(200):
        x, y = floor.draw(rng, WALK_CLEARANCE)
        length, angle = rng.uniform(*WALK_LENGTHS), rng.uniform(-math.pi, math.pi)
        steps = np.arange(0.0, length, 0.1)[:, None] * (math.cos(angle), math.sin(angle))
        way = np.array((x, y)) + steps
        gaps = np.hypot(*(way[:, None] - homes).transpose(2, 0, 1)).min(axis=1, initial=math.inf)
        if floor.clearance(way).min() > WALK_CLEARANCE and gaps.max() > START_ROOM:
            return (x, y), (float(way[-1, 0]), float(way[-1, 1]))
    return None
