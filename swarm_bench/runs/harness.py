"""One run without the ROS graph: world, brains and missions, tick by tick.

The order of things is that of lockstep over ROS: all robots observe a tick, all decide, goals
that end are followed by the next ones before the tick is over, and the world takes the step.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol, cast

import numpy as np

from swarm_bench.runs.episode import Episode, RunOptions, build
from swarm_bench.runs.ground_truth import GroundTruthWatch, PoseErrors
from swarm_bench.runs.invariant import Invariant
from swarm_bench.runs.orders import BenchOrders
from swarm_bench.runs.result_builder import compose_result
from swarm_central.link import Centre
from swarm_common.model.beacon import BEACON_DTYPE, BeaconArray, empty_beacons
from swarm_common.model.records import CONTROL_PERIOD
from swarm_common.model.run_words import waits_for
from swarm_mission.itinerary import Itinerary, NextGoal
from swarm_mission.orders.courier import Courier
from swarm_mission.wait_graph import WaitGraph
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind, Outcome, Output
from swarm_nav.interfaces import Led
from swarm_run.loop import Driver, InjectedFaults, Loop, pose_as_received
from swarm_run.record.figures import per_robot_second
from swarm_run.record.run_record import RunRecord
from swarm_sim.world.world import World

WAITS_EVERY = 10  # ticks between two checks of which robot waits for which
BLANK = empty_beacons(1).tobytes()
Watcher = Callable[[World, Sequence[Driver], Sequence[Output | None]], None]


class Commanded(Driver, Led, Protocol):
    """A driver that reports to a centre and takes its orders."""


class Harness(Loop):
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
            times_all: Whether every tick of a brain is timed.
        """
        self.options = options
        self.episode = episode = episode or build(options)
        setup = episode.setup
        super().__init__(
            episode.world, episode.drivers, dead=setup.silent, faults=faults, times_all=times_all
        )
        self.invariant = Invariant()
        self.beacons: BeaconArray = empty_beacons(len(self.drivers))
        self._on_tick = on_tick
        self._goal_ids = [0] * len(self.drivers)
        self._pose_errors = PoseErrors() if options.realistic else None
        self._limit = round(options.scenario.limit_of(options.robots) / CONTROL_PERIOD)
        self._stall_limit = round(options.scenario.stall_limit / CONTROL_PERIOD)
        self._last_success = 0  # tick
        self.waits = WaitGraph()
        self.truth = GroundTruthWatch(
            setup.names, [spec.circumscribed_radius for spec in setup.specs], setup.grid,
            setup.scene.sites.stations, options.scenario.warm_up,
        )  # fmt: skip

    @property
    def is_over(self) -> bool:
        """Whether every robot that is not dead is through with its mission."""
        if self.episode.orders is not None:
            return self.episode.orders.run.is_over
        return all(
            itinerary.is_over or index in self.dead
            for index, itinerary in enumerate(self.episode.itineraries)
        )

    def run(self) -> RunRecord:
        """Run until all missions are over, or one of the scenario's limits."""
        started, cpu_started = time.perf_counter(), time.process_time()
        try:
            while self.advance():
                pass
            wall_time = time.perf_counter() - started
            sim_time, count = self.world.sim_time, len(self.drivers)
            cpu = 1e3 * (time.process_time() - cpu_started)
            return compose_result(
                self.options, self.episode, self.dead, self.invariant, self.durations,
                wall_time=wall_time,
                waits=self.waits.as_json(sim_time),
                ground_truth=self.truth.figures(sim_time),
                cpu_ms_per_robot_second=per_robot_second(cpu, count, sim_time),
                pose_error=self._pose_errors.figures() if self._pose_errors else None,
            )  # fmt: skip
        finally:
            self.world.close()

    def advance(self) -> bool:
        """Run one tick; return whether there is another one."""
        self.think()
        limit = min(self._limit, self._last_success + self._stall_limit)
        if self.is_over or self.world.tick >= limit:
            return False
        self.act()
        return True

    def think(self) -> None:
        """Do all of a tick but the world's step."""
        world = self.world
        tick = world.tick
        self.begin(tick)
        self.sense()
        self.decide()
        joined = b"".join([BLANK if o is None else o.beacon.tobytes() for o in self.outputs])
        self.beacons = np.frombuffer(joined, BEACON_DTYPE)
        self.invariant.check(tick, self.beacons)
        for index, output in enumerate(self.outputs):
            if output is not None and (output.events or tick == 0):
                self._follow_mission(index, tick, output)
        if self.episode.orders is not None:
            self._follow_orders(self.episode.orders, tick)
        if self.episode.centre is not None:
            self._exchange(self.episode.centre, tick)
        if tick % WAITS_EVERY == 0:
            self._record_waits(tick)
            self.truth.look(tick, world.poses)
        if self._pose_errors is not None:
            self._pose_errors.note(self.drivers, world.poses, self.dead)
        if self._on_tick is not None:
            self._on_tick(world, self.drivers, self.outputs)

    def _exchange(self, centre: Centre, tick: int) -> None:
        """Let robots and centre speak in a tick in which the robots have decided."""
        drivers = cast(Sequence[Commanded], self.drivers)
        far = range(1, len(drivers), 2) if self.faults.splits(tick) else ()
        silent = self.dead.union(far)
        reports = [driver.report() for index, driver in enumerate(drivers) if index not in silent]
        for order in centre.step(tick, [each for each in reports if each is not None]):
            if order.robot_id - 1 not in silent:
                drivers[order.robot_id - 1].take_order(order)

    def _record_waits(self, tick: int) -> None:
        for index, name in enumerate(self.world.names):
            if index not in self.dead:
                status = self.drivers[index].status()
                other = waits_for(status.state, status.detail)
                self.waits.note(name, other, tick * CONTROL_PERIOD)

    def _follow_mission(self, index: int, tick: int, output: Output) -> None:
        """Send a robot whose goal has ended to the next one."""
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
        names = self.world.names
        dead = {names[index] for index in self.dead}
        orders.watch(tick, names, self.world.poses, dead)
        resting = [
            names[index]
            for index, (first, end) in self.faults.off_duty.items()
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
        self.drivers[index].set_goal(
            Goal(
                kind=GoalKind.NAVIGATE,
                goal_id=self._goal_ids[index],
                poses_map=(pose_as_received(stop.pose_map),),
                start_tick=order.start_tick,
            )
        )


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
