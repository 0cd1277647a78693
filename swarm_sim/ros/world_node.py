"""The world as a node: what happens between two ticks, and in one."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, assert_never

import rclpy
from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from swarm_common.middleware import ros_io
from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import drain
from swarm_common.middleware.topic_table import robot_topic
from swarm_common.model.records import CONTROL_PERIOD, Pose
from swarm_common.process.messages import (
    WORLD,
    BeginTime,
    EndTime,
    MeetingPorts,
    Note,
    RobotDead,
    RobotHeard,
    RobotLate,
    RobotRemoved,
    RobotSilent,
    RobotSpawned,
    ServeHost,
    WorldCommand,
)
from swarm_common.process.pipes import EventWriter, MessageReader
from swarm_common.process.standard_streams import FaultLog
from swarm_recording.run_trace import TOPICS, RunTrace
from swarm_sim.ros.build import silent_notes
from swarm_sim.ros.pacing import Rate, Throttle
from swarm_sim.ros.report import Reporter
from swarm_sim.ros.robots.barrier import Barrier
from swarm_sim.ros.robots.foreign import Foreigners
from swarm_sim.ros.robots.moves import LIMIT, Moves
from swarm_sim.ros.robots.swarm import Links
from swarm_sim.ros.services.control import Control
from swarm_sim.ros.services.entities import Entities
from swarm_sim.ros.services.inquiries import Inquiries
from swarm_sim.ros.services.run_state import RunState
from swarm_sim.ros.settings import Settings
from swarm_sim.ros.trace import Trace, begin_trace
from swarm_sim.ros.viewing.scene_publisher import ScenePublisher
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.object_registry import ObjectRegistry
from swarm_sim.world.request_checks import PlacementArea
from swarm_sim.world.robot_registry import Arrival, RobotRegistry
from swarm_sim.world.setup import WorldSetup
from swarm_sim.world.world import Observation

REPEAT_PERIOD = 0.25  # [s] of wall time after which the first tick is published again,
START_PERIOD = 2.0  # [s] the same for robots that have long been there
CLOCK_PERIOD = 0.045  # [s] of wall time: at most ~20 Hz
HEARD_CLOCK_PERIOD = 0.018  # [s] the same while somebody listens: 50 Hz and more
CLOCK_LISTENERS = ("recorder",)  # nodes of ours that need no such clock
REQUEST_PERIOD = 0.05  # [s] of wall time between two looks for requests
REPORT_PERIOD = 0.5  # [s] of wall time between verdicts
CLOCK_SLICE = 0.005  # [s] of wall time after which it is looked whether that is due
LARGEST_SHARE = 0.9  # of a tick's time that the clock goes ahead of it
WAIT_SLICE = 0.05  # [s] of wall time after which signals and periods are looked at


class WorldNode:
    """Runs the world in step with the robots. Use `run`, then `finish`."""

    def __init__(
        self,
        setup: WorldSetup,
        world: ChangingWorld,
        settings: Settings,
        events: EventWriter,
        *,
        is_large: bool = False,
    ) -> None:
        """Create all topics; rclpy must be initialised."""
        self._world = world
        self._settings = settings
        self._events = events
        self._tick = 0
        self._told = set(setup.scene.notes)
        self._is_stopped = False
        self._is_speed_new = False
        self.is_over = False
        self._barrier = Barrier(len(setup.specs), settings.wall_limit, not settings.free_run)
        self._barrier.is_held = settings.held
        speed = settings.speed if settings.speed or not settings.free_run else 1.0
        for index, robot in enumerate(settings.robots):
            if robot.broken_at is not None:
                self._barrier.lose(index)  # nobody will answer for it
        self._throttle = Throttle(speed)
        self._clock_rate = Rate(CLOCK_PERIOD)
        self._is_clock_heard = False
        self._report_rate = Rate(REPORT_PERIOD)
        self._repeat_rate = Rate(REPEAT_PERIOD)
        self._start_rate = Rate(START_PERIOD)
        self._request_rate = Rate(REQUEST_PERIOD)
        self._observations: list[Observation] = []
        self._control: MessageReader[WorldCommand] | None = None
        self._trace: Trace | None = None
        self._replay: RunTrace | None = None
        if settings.trace_dir is not None:
            self._trace = begin_trace(Path(settings.trace_dir), world, setup.grid)
            self._replay = RunTrace(Path(settings.trace_dir), settings.world)
        self._node = _create_node()
        self._faults = FaultLog("message")
        self._rejections = Rejections(events, self._node.get_logger().warning)
        self._executor = SafeExecutor()
        self._executor.add_node(self._node)
        make = self._node.create_publisher
        self._clock = make(Clock, "/clock", ros_io.RELIABLE)
        self._map = make(OccupancyGrid, "/map", ros_io.LATCHED)
        grid = ros_io.grid_msg(setup.grid, 0)
        self._map.publish(grid)
        if self._replay is not None:
            self._replay.write(TOPICS["/map"], 0, serialize_message(grid))
        self._reporter = Reporter(self._node, world, self._barrier, events, self._replay)
        foreigners = Foreigners(self._rejections, events)
        self._links = Links(
            self._node, world, settings, self._barrier, foreigners, is_large=is_large
        )
        for index, (robot, spec) in enumerate(zip(settings.robots, setup.specs, strict=True)):
            urdf = setup.robots[spec.model].urdf
            self._links.add(index, robot.name, spec, urdf)
            self._keep_description(robot.name, urdf)
        self._scenery = ScenePublisher(self._node, setup.scene, world, self._replay)
        self._robots = RobotRegistry(
            world, setup.grid, setup.starts, settings.spawn, settings.names
        )
        objects = ObjectRegistry(world, settings.names)
        reach = PlacementArea.of(setup.grid)
        self._entities = Entities(self._node, self._robots, objects, reach, self, self._rejections)
        Inquiries(self._node, world, self._robots, objects, self._rejections)
        self._moves = Moves(self._node)
        self._state = RunState(is_paused=settings.paused)
        self._services = Control(self._node, self._state, speed, self._set_speed)
        if is_large:
            events.write(MeetingPorts("world", self._links.meeting_ports))

    def stop(self) -> None:
        """Make `run` return; the present tick is not executed."""
        self._is_stopped = True

    def listen(self, control_fd: int) -> None:
        """Receive commands from a pipe."""
        self._control = MessageReader(control_fd, WORLD)

    def run(self) -> None:
        """Run tick after tick until stopped or the duration is over."""
        last = self._settings.duration
        while not self._is_stopped:
            self._change()
            self._open_tick()
            if last is not None and self._world.sim_time >= last - 1e-9:
                self.is_over = True
                break
            self._wait_for_answers()
            self._wait(self._throttle.wait_after_tick(time.monotonic()))
            self._wait_while_held()
            if not self._is_stopped:
                self._advance()
                self._state.record_tick()

    # Robots that come, go and are put elsewhere

    def _change(self) -> None:
        """Make the changes that were asked for, and wait until those concerned know."""
        self._entities.apply()
        self._moves.settle(lambda: self._is_stopped)

    def on_arrival(self, arrival: Arrival) -> None:
        """Let a robot that has come take part."""
        robot = arrival.index
        spec = self._world.specs[robot]  # with the battery that it had, if it was here before
        if self._links.add(robot, arrival.name, spec, arrival.robot.urdf):
            self._barrier.add()
        else:
            self._barrier.welcome(robot)
        self._keep_description(arrival.name, arrival.robot.urdf)
        self._scenery.renew(self._robots.robots)
        for note in silent_notes(self._world, self._settings.body_margin):
            if note not in self._told:
                self._told.add(note)
                self._events.write(Note(note))
        pose = arrival.pose_map
        self._events.write(
            RobotSpawned(
                arrival.name,
                arrival.number,
                arrival.model,
                (pose.x, pose.y, pose.yaw),
                self._world.sim_time,
            )
        )

    def _keep_description(self, name: str, urdf: str) -> None:
        if self._replay is not None:
            topic = robot_topic(name, "robot_description")
            self._replay.write(topic, self._tick, serialize_message(String(data=urdf)))

    def on_removal(self, robot: int) -> None:
        """Let a robot that was taken out no longer take part."""
        self._moves.forget(robot)
        name = self._links.remove(robot)
        self._barrier.lose(robot)
        self._scenery.renew(self._robots.robots)
        self._events.write(RobotRemoved(name, self._world.sim_time))

    def on_move(self, robot: int, pose_map: Pose) -> None:
        """Send a robot the pose at which it was put; it stands until its beacon confirms it."""
        speaks = self._world.last_beacons[robot] is not None  # a foreign navigator does not
        patience = LIMIT if self._barrier.expects(robot) else 0.0
        self._moves.tell(
            robot, self._links.names[robot], pose_map, self._world.tick, patience, speaks
        )

    def on_things(self) -> None:
        """Show things that have come, gone or been put elsewhere, also while the world is held."""
        self._scenery.renew(self._robots.robots)

    # A tick

    def _open_tick(self) -> None:
        self._tick = self._world.tick
        self._observations = self._world.observe()
        now = time.monotonic()
        self._barrier.open(now)
        self._repeat_rate.is_due(now)
        if self._clock_rate.is_due(now) or self._is_clock_heard:
            self._publish_clock()
        self._links.open(self._tick, self._observations, now)
        self._links.publish_for_viewers(self._observations, self._world)
        self._scenery.publish(self._tick)
        self._look_around(now)

    def _wait_for_answers(self) -> None:
        was_started = self._barrier.has_started
        while not self._is_stopped:
            now = time.monotonic()
            self._links.receive_answers()
            if self._barrier.is_complete(now):
                break
            self._links.wait(WAIT_SLICE, now)
            self._repeat(now)
            self._look_around(now)
        if not was_started:
            now = time.monotonic()
            self._throttle.start(now)
            self._reporter.start(now)

    def _repeat(self, now: float) -> None:
        """Publish the tick once more for robots that were not there or lost a message."""
        if self._barrier.has_started:
            if self._links.repeat(self._observations, now) and self._clock_rate.is_due(now):
                self._publish_clock()
        elif self._repeat_rate.is_due(now):
            self._publish_clock()
            is_starting = not self._start_rate.is_due(now)
            self._links.repeat_at_start(self._observations, now, to_newcomers=is_starting)

    def _set_speed(self, speed: float | None) -> None:
        self._throttle.set_speed(speed)
        self._throttle.start(time.monotonic())
        self._is_speed_new = True

    def _wait(self, period: float) -> None:
        is_alone = self._barrier.has_started and self._barrier.answering == 0 and self._tick > 0
        if is_alone and not self._settings.free_run:
            period = max(period, CONTROL_PERIOD)  # nobody there: no faster than real time
        start = time.monotonic()
        end = start + period
        self._is_speed_new = False
        while not (self._is_stopped or self._is_speed_new):
            now = time.monotonic()
            if now >= end:
                break
            slice_ = CLOCK_SLICE if self._is_clock_heard else WAIT_SLICE
            time.sleep(min(slice_, end - now))
            now = time.monotonic()
            if self._is_clock_heard and now < end and self._clock_rate.is_due(now):
                self._publish_clock(LARGEST_SHARE * (now - start) / period)
            self._links.receive_answers()
            self._look_around(now)

    def _wait_while_held(self) -> None:
        if not self._state.is_held:
            return
        while self._state.is_held and not self._is_stopped:
            time.sleep(WAIT_SLICE)
            self._links.receive_answers()
            self._look_around(time.monotonic())
            self._change()
        self._throttle.start(time.monotonic())

    def _advance(self) -> None:
        self._barrier.close()
        for robot, is_alone in self._barrier.receive_late():
            name, limit = self._links.names[robot], self._settings.wall_limit
            self._events.write(RobotLate(name, limit, is_alone))
        commands, beacons = self._links.answers()
        for robot in self._moves.hold(commands, beacons):
            self._robots.settle(robot)
        collisions = self._world.step(commands, beacons)
        for collision in collisions:
            self._reporter.collision(collision)
        if self._trace is not None:
            self._trace.observe(
                self._world.tick, self._world.poses, self._world.clearances, self._world.absent
            )

    def _publish_clock(self, share: float = 0.0) -> None:
        clock = ros_io.time_msg(self._tick)
        later = clock.nanosec + round(1e9 * CONTROL_PERIOD * share)
        clock.sec, clock.nanosec = clock.sec + later // 10**9, later % 10**9
        self._clock.publish(Clock(clock=clock))

    def _poll_clock_listeners(self) -> None:
        """Let the clock tick faster while somebody needs it; our nodes have the ticks' stamps."""
        names = {info.node_name for info in self._node.get_subscriptions_info_by_topic("/clock")}
        is_heard = bool(names - set(CLOCK_LISTENERS))
        if is_heard != self._is_clock_heard:
            self._is_clock_heard = is_heard
            self._clock_rate = Rate(HEARD_CLOCK_PERIOD if is_heard else CLOCK_PERIOD)

    def _look_around(self, now: float) -> None:
        """Do the work that is due on the wall clock: requests, reports, control pipe, viewers."""
        if self._request_rate.is_due(now):
            drain(self._executor, on_fault=self._on_fault)
            self._services.poll_steps()
            for command in self._control.read() if self._control is not None else []:
                self._obey(command)
        if not self._report_rate.is_due(now):
            return
        self._rejections.tell(now)
        self._poll_clock_listeners()
        if self._links.poll_viewers() and self._observations:  # this tick may last
            self._links.publish_for_viewers(self._observations, self._world)
        self._links.check_foreign_publishers()
        self._scenery.poll_viewers(self._tick)
        for sentence in self._world.motionless():
            self._events.write(Note(sentence))
        self._report()

    def _report(self) -> None:
        count = len(self._robots.robots)
        self._reporter.report(self._tick, count, is_paused=self._state.is_paused)

    def _on_fault(self, error: Exception) -> None:
        """Continue although a callback failed: whatever was sent, it must not end the world."""
        self._rejections.reject("callback", "unknown", self._faults.note(error))

    def _obey(self, command: WorldCommand) -> None:
        names = self._links.names
        if isinstance(command, BeginTime):
            self._barrier.is_held = False
        elif isinstance(command, EndTime):
            self.stop()
        elif isinstance(command, ServeHost):
            self._links.move_out(command.host, command.robots, command.run, command.secret)
        elif command.robot in names:
            robot = names.index(command.robot)
            match command:
                case RobotDead():
                    self._barrier.lose(robot)
                case RobotSilent(seconds=seconds):  # its host is
                    self._barrier.record_silence(robot, time.monotonic() - seconds)
                case RobotHeard():
                    self._barrier.end_silence(robot)
                case _:
                    assert_never(command)

    def finish(self) -> dict[str, Any]:
        """Return the verdict of the run, and write it if the settings say where."""
        data = self._reporter.final(self._settings.verdict_path)
        self._report()
        if self._replay is not None:
            self._replay.close()
        self._rejections.flush()
        self._world.close()
        return data

    def destroy(self) -> None:
        """Leave the ROS graph."""
        self._executor.shutdown()
        self._services.destroy()
        self._entities.destroy()
        self._links.destroy()
        self._node.destroy_node()
        rclpy.try_shutdown()


def _create_node() -> Node:
    return Node(
        "world",
        namespace="sim",
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[Parameter("start_type_description_service", value=False)],
    )
