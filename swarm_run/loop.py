"""The loop of a run in one process: all robots sense, decide, and act, tick by tick.

The order of things is that of lockstep over ROS. `Loop` is world and brains alone; who wants more
of a tick overrides its hooks `begin` and `on_contacts`, or does it between its three steps.
"""

from __future__ import annotations

import math
import time
from array import array
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, cast, runtime_checkable

from swarm_common.middleware.cdr import yaw_of
from swarm_common.model.beacon import Reception, word_of
from swarm_common.model.breaches import Collision
from swarm_common.model.records import Odometry, Pose, Twist
from swarm_nav.core.goals import Output
from swarm_nav.interfaces import Brain, Charged, Staged
from swarm_sim.world.world import Observation, World

TIMED_EVERY = 17  # ticks between two in which each brain decides at once, and is timed
ID = word_of("id")
Span = tuple[int, int]  # first tick, and the first one after the last


class Driver(Brain, Charged, Protocol):
    """A brain that also takes the readings of a battery."""


@runtime_checkable
class StagedDriver(Driver, Staged, Protocol):
    """A driver that can decide in stages, between which others decide."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InjectedFaults:
    """Faults of some robots, by index; for tests."""

    # tick from which a robot does and says nothing; its goals are not asked for
    dead: Mapping[int, int] = field(default_factory=dict)
    mute: Collection[int] = ()  # robots whose beacons nobody gets
    deaf: Collection[int] = ()  # robots that get no batch of neighbours
    off_duty: Mapping[int, Span] = field(default_factory=dict)  # when a robot takes no new order
    # when robots with odd and with even indices do not hear each other, and a centre hears and
    # reaches only those with even ones
    split: Span | None = None

    def splits(self, tick: int) -> bool:
        """Return whether the radio is split.

        Args:
            tick: Tick at which a beacon is sent, of 0.1 s.
        """
        return self.split is not None and self.split[0] <= tick < self.split[1]


class Loop:
    """World and brains; sequences have an entry per robot.

    Attributes:
        world: The world.
        drivers: What decides for each robot.
        faults: Faults of single robots.
        dead: Indices of the robots that do and say nothing.
        observed: Readings of all sensors at the present tick.
        outputs: Decisions at the present tick; None of dead robots.
        durations: [s] of wall time of the ticks of brains that are timed.
    """

    def __init__(
        self,
        world: World,
        drivers: Sequence[Driver],
        *,
        dead: Iterable[int] = (),
        faults: InjectedFaults | None = None,
        times_all: bool = False,
    ) -> None:
        """Begin with a world at tick 0.

        Args:
            dead: Indices of the robots that are dead from the start.
            times_all: Whether every tick of a brain is timed; else one in `TIMED_EVERY`, as a
                swarm decides faster when its brains take turns.
        """
        self.world, self.drivers = world, drivers
        self.faults = faults or InjectedFaults()
        self.dead = set(dead)
        self.observed: Sequence[Observation] = ()
        self.outputs: list[Output | None] = [None] * len(drivers)
        self.durations = array("f")
        are_staged = all(isinstance(driver, StagedDriver) for driver in drivers)
        self._takes_turns = are_staged and not times_all

    def begin(self, tick: int) -> None:
        """Let what is to happen at a tick happen; here robots die."""
        self.dead.update(index for index, death in self.faults.dead.items() if tick >= death)

    def on_contacts(self, collisions: Sequence[Collision]) -> None:
        """Hear of the contact episodes that began in a tick; the verdict counts them anyway."""

    def sense(self) -> None:
        """Read the sensors of all robots."""
        self.observed = self.world.observe()

    def decide(self) -> None:
        """Let each robot that lives take its readings in, and decide."""
        tick = self.world.tick
        deciding = [index for index in range(len(self.drivers)) if index not in self.dead]
        for index in self.dead:
            self.outputs[index] = None
        outputs: Sequence[Output]
        if not self._takes_turns or tick % TIMED_EVERY == 0:
            outputs = [self._timed(index, tick) for index in deciding]
        else:
            outputs = self._by_stages(deciding, tick)
        for index, output in zip(deciding, outputs, strict=True):
            self.outputs[index] = output

    def act(self) -> Sequence[Collision]:
        """Let the world take a step with what was decided; return contacts that began in it."""
        stand = Twist()  # as the world commands a robot that does not answer
        twists = [stand if output is None else output.twist for output in self.outputs]
        mute = self.faults.mute
        sent = [
            None if output is None or index in mute else output.beacon
            for index, output in enumerate(self.outputs)
        ]
        contacts = self.world.step(twists, sent)
        self.on_contacts(contacts)
        return contacts

    def _timed(self, index: int, tick: int) -> Output:
        odom = as_received(self.observed[index].odom)
        started = time.perf_counter()
        self._take_in(index, odom)
        output = self.drivers[index].tick(tick)
        self.durations.append(time.perf_counter() - started)
        return output

    def _by_stages(self, deciding: Sequence[int], tick: int) -> Sequence[Output]:
        """Let the drivers take turns after each stage: the same decisions, in less time."""
        for index in deciding:
            self._take_in(index, as_received(self.observed[index].odom))
        drivers = cast(Sequence[StagedDriver], self.drivers)
        stages = [drivers[index].stages(tick) for index in deciding]
        rounds = list(zip(*stages, strict=True))
        return [output for output in rounds[-1] if output is not None] if rounds else []

    def _take_in(self, index: int, odom: Odometry) -> None:
        driver, seen = self.drivers[index], self.observed[index]
        driver.on_odom(odom)
        if seen.scan is not None:
            driver.on_scan(seen.scan)
        if seen.battery is not None:
            driver.on_battery(seen.battery)
        if index not in self.faults.deaf:
            driver.on_reception(
                of_own_part(seen.reception, index)
                if self.faults.splits(seen.odom.tick)
                else seen.reception
            )


def of_own_part(reception: Reception, index: int) -> Reception:
    """Return what a robot hears where the radio is split by odd and even indices.

    Args:
        index: Index of the robot, from 0.
    """
    ids = reception.words[reception.rows, ID].astype(int)
    return Reception(reception.words, reception.rows[(ids - 1) % 2 == index % 2])


def as_received(odom: Odometry) -> Odometry:
    """Return an odometry as it comes out of a ROS message: the yaw has been a quaternion.

    Args:
        odom: Odometry as the world made it.
    """
    return Odometry(odom.tick, pose_as_received(odom.pose_odom), odom.twist)


def pose_as_received(pose: Pose) -> Pose:
    """Return a pose as it comes out of a ROS message.

    Args:
        pose: In any frame.
    """
    half = 0.5 * pose.yaw
    return Pose(pose.x, pose.y, yaw_of(0.0, 0.0, math.sin(half), math.cos(half)))
