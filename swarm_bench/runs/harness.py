"""One run without the ROS graph: the loop of world, brains and missions, tick by tick.

The order of things is that of lockstep over ROS: all robots observe a tick, all decide, goals
that end are followed by the next ones before the tick is over, and the world takes the step.
"""

from __future__ import annotations

import math
import time
from array import array
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from swarm_bench.runs.centre import Commanded, exchange
from swarm_bench.runs.episode import Episode, RunOptions, build
from swarm_bench.runs.ground_truth import GroundTruthWatch
from swarm_bench.runs.invariant import Invariant
from swarm_bench.runs.methods import Driver, StagedDriver
from swarm_bench.runs.orders import BenchOrders
from swarm_bench.runs.pose_error import PoseErrors
from swarm_bench.runs.result_builder import compose_result
from swarm_common.middleware.cdr import yaw_of
from swarm_common.model.beacon import (
    BEACON_DTYPE,
    BeaconArray,
    Reception,
    empty_beacons,
    word_of,
)
from swarm_common.model.breaches import Collision
from swarm_common.model.records import CONTROL_PERIOD, Odometry, Pose, Twist
from swarm_common.model.run_words import waits_for
from swarm_mission.itinerary import Itinerary, NextGoal
from swarm_mission.orders.courier import Courier
from swarm_mission.wait_graph import WaitGraph
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind, Outcome, Output
from swarm_run.record.figures import per_robot_second
from swarm_run.record.run_record import RunRecord
from swarm_sim.world.world import Observation, World

WAITS_EVERY = 10  # ticks between two checks of which robot waits for which
TIMED_EVERY = 17  # ticks between two in which each brain decides at once, and is timed
ID = word_of("id")
Span = tuple[int, int]  # first tick, and the first one after the last
Watcher = Callable[[World, Sequence[Driver], Sequence[Output | None]], None]


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


class Harness:
    """A run in progress.

    Attributes:
        episode: World, drivers and missions.
        invariant: The safety invariant so far.
        beacons: (n,) what was sent in the last tick; zero held points where nothing was.
        waits: Who waits for whom, as the robots say once a second.
        truth: Who stands, and for whom, as the simulator sees it.
    """

    def __init__(
        self,
        options: RunOptions,
        *,
        on_tick: Watcher | None = None,
        faults: InjectedFaults | None = None,
        episode: Episode | None = None,
        times_all: bool = False,
    ) -> None:
        """Build the episode, or take one that was built elsewhere.

        Args:
            options: What to run.
            on_tick: Called in each tick, before the world's step.
            faults: Faults of single robots.
            episode: Episode to run instead of the one that `options` describe.
            times_all: Whether every tick of a brain is timed; else one in `TIMED_EVERY`, as a
                swarm decides faster when its brains take turns.
        """
        self.options = options
        self.episode = episode or build(options)
        self.invariant = Invariant()
        count = len(self.episode.drivers)
        self.beacons: BeaconArray = empty_beacons(count)
        self._on_tick = on_tick
        self._faults = faults or InjectedFaults()
        are_staged = all(isinstance(driver, StagedDriver) for driver in self.episode.drivers)
        self._takes_turns = are_staged and not times_all
        self._dead = set(self.episode.dead)
        self._outputs: list[Output | None] = [None] * count
        self._twists: list[Twist | None] = [Twist()] * count
        self._sent: list[np.void | None] = [None] * count
        self._goal_ids = [0] * count
        self._durations = array("f")  # [s] of wall time of the ticks that are timed
        self._pose_errors = PoseErrors() if options.realistic else None
        self._limit = round(options.scenario.limit_of(options.robots) / CONTROL_PERIOD)
        self._stall_limit = round(options.scenario.stall_limit / CONTROL_PERIOD)
        self._last_success = 0  # tick
        self.waits = WaitGraph()
        world = self.episode.world
        self.truth = GroundTruthWatch(
            world.names, [spec.circumscribed_radius for spec in world.specs], self.episode.grid,
            self.episode.sites.stations, options.scenario.warm_up,
        )  # fmt: skip

    @property
    def is_over(self) -> bool:
        """Whether every robot that is not dead is through with its mission."""
        if self.episode.orders is not None:
            return self.episode.orders.run.is_over
        return all(
            itinerary.is_over or index in self._dead
            for index, itinerary in enumerate(self.episode.itineraries)
        )

    def run(self) -> RunRecord:
        """Run until all missions are over, or one of the scenario's limits."""
        started, cpu_started = time.perf_counter(), time.process_time()
        try:
            while self.advance():
                pass
            wall_time = time.perf_counter() - started
            sim_time, count = self.episode.world.sim_time, len(self.episode.drivers)
            cpu = 1e3 * (time.process_time() - cpu_started)
            return compose_result(
                self.options, self.episode, self._dead, self.invariant, self._durations,
                wall_time=wall_time,
                waits=self.waits.as_json(sim_time),
                ground_truth=self.truth.figures(sim_time),
                cpu_ms_per_robot_second=per_robot_second(cpu, count, sim_time),
                pose_error=self._pose_errors.figures() if self._pose_errors else None,
            )  # fmt: skip
        finally:
            self.episode.world.close()

    def advance(self) -> bool:
        """Run one tick; return whether there is another one."""
        world = self.episode.world
        tick = world.tick
        self._die(tick)
        self._decide(tick, world.observe())
        self._note(tick)
        for index, output in enumerate(self._outputs):
            if output is not None and (output.events or tick == 0):
                self._follow_mission(index, tick, output)
        if self.episode.orders is not None:
            self._follow_orders(self.episode.orders, tick)
        self._exchange(tick)
        if tick % WAITS_EVERY == 0:
            self._record_waits(tick)
            self.truth.look(tick, world.poses)
        if self._pose_errors is not None:
            self._pose_errors.note(self.episode.drivers, world.poses, self._dead)
        if self._on_tick is not None:
            self._on_tick(world, self.episode.drivers, self._outputs)
        if self.is_over or tick >= min(self._limit, self._last_success + self._stall_limit):
            return False
        self._watch(world.step(self._twists, self._sent))
        return True

    def _exchange(self, tick: int) -> None:
        if self.episode.centre is not None:
            drivers = cast(Sequence[Commanded], self.episode.drivers)
            far = range(1, len(self._sent), 2) if self._faults.splits(tick) else ()
            exchange(self.episode.centre, tick, drivers, self._dead.union(far))

    def _record_waits(self, tick: int) -> None:
        for index, name in enumerate(self.episode.world.names):
            if index not in self._dead:
                status = self.episode.drivers[index].status()
                other = waits_for(status.state, status.detail)
                self.waits.note(name, other, tick * CONTROL_PERIOD)

    def _watch(self, collisions: Sequence[Collision]) -> None:
        """Hook for the contact episodes that began in a tick; the verdict counts them anyway."""

    def _die(self, tick: int) -> None:
        for index, death in self._faults.dead.items():
            if tick >= death:
                self._dead.add(index)

    def _decide(self, tick: int, observed: Sequence[Observation]) -> None:
        deciding = [index for index in range(len(observed)) if index not in self._dead]
        for index in self._dead:
            self._outputs[index] = self._sent[index] = None
            self._twists[index] = Twist()  # as the world commands a robot that does not answer
        outputs: Sequence[Output]
        if not self._takes_turns or tick % TIMED_EVERY == 0:
            outputs = [self._timed(index, tick, observed[index]) for index in deciding]
        else:
            outputs = self._by_stages(deciding, tick, observed)
        for index, output in zip(deciding, outputs, strict=True):
            self._outputs[index] = output
            self._twists[index] = output.twist
            self._sent[index] = None if index in self._faults.mute else output.beacon

    def _timed(self, index: int, tick: int, seen: Observation) -> Output:
        odom = as_received(seen.odom)
        started = time.perf_counter()
        self._observe(index, odom, seen)
        output = self.episode.drivers[index].tick(tick)
        self._durations.append(time.perf_counter() - started)
        return output

    def _by_stages(
        self, deciding: Sequence[int], tick: int, observed: Sequence[Observation]
    ) -> Sequence[Output]:
        """Let the drivers take turns after each stage: the same decisions, in less time."""
        for index in deciding:
            self._observe(index, as_received(observed[index].odom), observed[index])
        drivers = cast(Sequence[StagedDriver], self.episode.drivers)
        stages = [drivers[index].stages(tick) for index in deciding]
        rounds = list(zip(*stages, strict=True))
        return [output for output in rounds[-1] if output is not None] if rounds else []

    def _observe(self, index: int, odom: Odometry, seen: Observation) -> None:
        driver = self.episode.drivers[index]
        driver.on_odom(odom)
        if seen.scan is not None:
            driver.on_scan(seen.scan)
        if seen.battery is not None:
            driver.on_battery(seen.battery)
        if index not in self._faults.deaf:
            driver.on_reception(
                of_own_part(seen.reception, index)
                if self._faults.splits(seen.odom.tick)
                else seen.reception
            )

    def _note(self, tick: int) -> None:
        """Keep the beacons of a tick and look at the invariant."""
        blank = _BLANK
        joined = b"".join([blank if o is None else o.beacon.tobytes() for o in self._outputs])
        self.beacons = np.frombuffer(joined, BEACON_DTYPE)
        self.invariant.check(tick, self.beacons)

    def _follow_mission(self, index: int, tick: int, output: Output) -> None:
        itinerary = self.episode.itineraries[index]
        if tick == 0 and isinstance(itinerary, Itinerary):
            self._send(index, itinerary.start())
        for event in output.events:
            if isinstance(event, GoalEnded) and self._counts(index, itinerary, event):
                self.truth.end(index, tick * CONTROL_PERIOD)
                is_reached = event.outcome is Outcome.SUCCEEDED
                if is_reached:
                    self._last_success = tick
                reason = f"error {int(event.error_code)}: {event.message}"
                self._send(index, itinerary.on_end(is_reached, tick, reason))

    def _counts(self, index: int, itinerary: Itinerary | Courier, event: GoalEnded) -> bool:
        """Whether the end of a goal is news: goals of orders replace each other."""
        if isinstance(itinerary, Courier):
            return event.goal_id == self._goal_ids[index]
        return not itinerary.is_over

    def _follow_orders(self, orders: BenchOrders, tick: int) -> None:
        names = self.episode.world.names
        dead = {names[index] for index in self._dead}
        orders.watch(tick, names, self.episode.world.poses, dead)
        resting = [
            names[index]
            for index, (first, end) in self._faults.off_duty.items()
            if first <= tick < end
        ]
        for name, goal in orders.step(tick, dead, resting).items():
            self._send(names.index(name), goal)
        if not orders.run.has_open:
            self._last_success = tick

    def _send(self, index: int, order: NextGoal | None) -> None:
        if order is None:
            return
        self._goal_ids[index] += 1
        stop = order.stop
        self.truth.send(index, stop.pose_map, stop.name, order.start_tick)
        self.episode.drivers[index].set_goal(
            Goal(
                kind=GoalKind.NAVIGATE,
                goal_id=self._goal_ids[index],
                poses_map=(pose_as_received(stop.pose_map),),
                start_tick=order.start_tick,
            )
        )


_BLANK = empty_beacons(1).tobytes()


def run(options: RunOptions) -> RunRecord:
    """Run a scenario once.

    Args:
        options: What to run.

    Returns:
        Figures of the run, whether its goals were reached or not.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    return Harness(options).run()


def of_own_part(reception: Reception, index: int) -> Reception:
    """Return what a robot hears where the radio is split by odd and even indices.

    Args:
        reception: Beacons of all robots.
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
