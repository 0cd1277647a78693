"""The topics of all robots on the side of the world, in the order of robots."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rclpy.node import Node
from std_msgs.msg import UInt8MultiArray

from swarm_common.middleware import ros_io
from swarm_common.middleware.beacon_batch import BatchWriter, topic_of
from swarm_common.middleware.participants import Hubs
from swarm_common.middleware.ros_poll import Waiter
from swarm_common.model.beacon import Reception
from swarm_common.model.records import RobotSpec, Twist, stamp_from_tick
from swarm_sim.ros.robots.barrier import Barrier
from swarm_sim.ros.robots.foreign import Foreigners
from swarm_sim.ros.robots.links import RobotLink
from swarm_sim.ros.settings import Settings
from swarm_sim.world.world import Observation, World

TOGETHER = 0.005  # [s] within which repeats that are due go into one batch
HURRY = 1.5  # times as long as the last answer took
SHORTEST = 0.001  # [s] of a wait
KEEPS_UP = 10  # ticks that a late robot may be behind to be waited for again


class Links:
    """Publishes observations and collects answers; tells the barrier which robots have answered."""

    def __init__(
        self,
        node: Node,
        world: World,
        settings: Settings,
        barrier: Barrier,
        foreigners: Foreigners,
        *,
        is_large: bool,
    ) -> None:
        """Create all topics.

        Args:
            is_large: Whether the topics are spread over hubs, see `participants`.
        """
        self._settings = settings
        self._external = {robot.name for robot in settings.robots if robot.external}
        self._number_of = settings.names.number_of
        self._barrier = barrier
        self._foreigners = foreigners
        self._hubs = Hubs(node, len(world.specs), is_large=is_large, with_gallery=True)
        self._waiter = Waiter(node.context)
        self._links: list[RobotLink] = []
        self._hosts = Hosts(node)
        self._opened_at = self._answer_at = 0.0  # wall time of the tick, and of its last answer
        self._world = world

    @property
    def names(self) -> list[str]:
        """Namespaces of the robots, also of those that are gone."""
        return [link.name for link in self._links]

    @property
    def meeting_ports(self) -> dict[str, list[int]]:
        """Ports on which the navigator of each robot meets the world."""
        ports = self._hubs.ports(self.names)
        return {name: [*self._hubs.own_ports, port] for name, port in ports.items()}

    def add(self, robot: int, name: str, spec: RobotSpec, urdf: str) -> bool:
        """Create the topics of a robot; return whether it is a new one, not one that comes back."""

        def record_answer() -> None:
            self._barrier.answer(robot)
            self._answer_at = time.monotonic()
            link.trip.answer(self._answer_at)

        node = self._hubs.node_of(robot)
        link = RobotLink(
            node,
            self._hubs.gallery,
            name,
            spec,
            urdf,
            self._settings,
            self._number_of(name),
            record_answer,
            self._foreigners,
            self._world.errors_of(spec),
            is_external=name in self._external,
        )
        if robot < len(self._links):
            self._links[robot] = link
            return False
        self._links.append(link)
        return True

    def remove(self, robot: int) -> str:
        """Withdraw the topics of a robot; return its name."""
        self._links[robot].destroy()
        return self._links[robot].name

    def move_out(self, host: str, names: Sequence[str], run: str, secret: str) -> None:
        """Record that the navigators of some robots are on another host.

        Args:
            names: Robots that are not here are ignored.
        """
        robots = {
            self.names.index(name): self._number_of(name) for name in names if name in self.names
        }
        self._hosts.assign(host, robots, run, secret)
        for robot in robots:
            self._links[robot].move_out()

    def open(self, tick: int, observations: Sequence[Observation], now: float) -> None:
        """Begin a tick: forget the last answers, publish what robots sense."""
        self._opened_at = self._answer_at = now
        for link in self._links:
            link.open(tick)
            link.trip.send(now)
        self._publish(range(len(self._links)), observations)

    def repeat(self, observations: Sequence[Observation], now: float) -> bool:
        """Publish once more for robots whose answer takes longer than usual.

        Returns:
            Whether there are any.
        """
        due = self._due_times()
        if all(time > now for time in due.values()):
            return False
        late = [robot for robot, time in due.items() if time <= now + TOGETHER]
        for robot in late:
            trip = self._links[robot].trip
            if trip.due_at <= now + TOGETHER:
                trip.repeat(now)
            else:
                trip.hurry(now)
        self._publish(late, observations)
        return True

    def _due_times(self) -> dict[int, float]:
        """Return when each missing answer is to be asked for again.

        How long answers take depends on how busy all hosts are, and so differs more from tick to
        tick than from robot to robot. Once half of the robots have answered, one on another host
        whose answer takes half as long again as the last one's has probably lost a message.
        """
        missing = self._barrier.missing()
        hurry_at = self._opened_at + HURRY * (self._answer_at - self._opened_at)
        has_most = 2 * len(missing) <= self._barrier.answering
        due = {}
        for robot in missing:
            trip = self._links[robot].trip
            may_hurry = has_most and self._hosts.has(robot) and not trip.is_hurried
            due[robot] = min(trip.due_at, hurry_at) if may_hurry else trip.due_at
        return due

    def repeat_at_start(
        self, observations: Sequence[Observation], now: float, *, to_newcomers: bool
    ) -> None:
        """Publish once more for robots that were not there; for all while only others are missing.

        Args:
            to_newcomers: Only for those that have been there for few repeats.
        """
        newcomers = []
        missing = self._barrier.missing()
        for robot in missing or range(len(self._links)):
            link = self._links[robot]
            if link.is_newcomer() or not (to_newcomers and missing):
                newcomers.append(robot)
                link.trip.repeat(now)
        self._publish(newcomers, observations)

    def _publish(self, robots: Sequence[int], observations: Sequence[Observation]) -> None:
        elsewhere = {}
        for robot in robots:
            self._links[robot].publish(observations[robot])
            if self._hosts.has(robot) and not self._links[robot].is_gone:
                elsewhere[robot] = observations[robot].reception
        if elsewhere:
            self._hosts.publish(observations[robots[0]].odom.tick, elsewhere)

    def wait(self, timeout: float, now: float) -> None:
        """Wait for the middle one of the robots whose answers are missing.

        When it has answered, so have about half of them: a tick takes few looks at all.

        Args:
            timeout: [s] at most; less if an answer is to be asked for again before.
        """
        due_times = self._due_times()
        if not due_times:  # time is held
            time.sleep(timeout)
            return
        due, missing = min(due_times.values()), list(due_times)
        middle = self._links[missing[len(missing) // 2]]
        self._waiter.wait([middle.awaited], min(timeout, max(due - now, SHORTEST)))

    def receive_answers(self) -> None:
        """Receive what has come from robots whose answer is not whole, also from the late."""
        for robot, link in enumerate(self._links):
            if link.has_answered:
                continue
            before = link.newest_tick
            link.receive_answers()
            if link.is_unstamped:
                self._barrier.excuse(robot)
            if link.newest_tick > before and 0 < link.lag <= KEEPS_UP:
                self._barrier.hear(robot)

    def answers(self) -> tuple[list[Twist | None], list[np.void | None]]:
        """Return command and beacon of each robot; a robot that did not answer in time stops."""
        commands = [link.fresh_command() for link in self._links]
        if not self._settings.free_run:
            commands = [  # an unstamped one holds until the next, as in free run
                command if command or link.is_unstamped else Twist()
                for command, link in zip(commands, self._links, strict=True)
            ]
        return commands, [link.beacon for link in self._links]

    def publish_for_viewers(self, observations: Sequence[Observation], world: World) -> None:
        """Publish what somebody looks at."""
        for robot, link in enumerate(self._links):
            if link.wants_tf or link.wants_joints:
                pose_odom = observations[robot].odom.pose_odom
                link.publish_for_viewers(pose_odom, world.joint_states(robot))
            if link.wants_imu:
                link.publish_imu(world.imu(robot))
        if any(link.wants_truth for link in self._links):
            for link, truth in zip(self._links, world.ground_truth(), strict=True):
                if link.wants_truth:
                    link.publish_truth(*truth)

    def poll_viewers(self) -> bool:
        """See which topics for viewers have a subscriber; return whether there is a new one."""
        return any([link.poll_viewers() for link in self._links])

    def check_foreign_publishers(self) -> None:
        """Check for foreign publishers on topics of robots; a few robots at each call."""
        seats = [
            (self._hubs.node_of(robot), link.name)
            for robot, link in enumerate(self._links)
            if not link.is_gone
        ]
        self._foreigners.look(seats, is_free_run=self._settings.free_run)

    def destroy(self) -> None:
        """Leave the graph, except with the world's own node."""
        self._hubs.destroy()


class Hosts:
    """Knows which robots are on which host, and sends each host its batch."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._batches: dict[str, tuple[Any, BatchWriter]] = {}  # publisher and writer, by host
        self._place_of: dict[int, tuple[str, int]] = {}  # host and robot's number, by index

    def assign(self, host: str, robots: Mapping[int, int], run: str, secret: str) -> None:
        """Send the beacons of some robots to a host from now on."""
        publisher = self._node.create_publisher(UInt8MultiArray, topic_of(host), ros_io.RELIABLE)
        self._batches[host] = publisher, BatchWriter(secret, run, host)
        self._place_of |= {robot: (host, number) for robot, number in robots.items()}

    def has(self, robot: int) -> bool:
        """Whether a robot is on another host."""
        return robot in self._place_of

    def publish(self, tick: int, receptions: Mapping[int, Reception]) -> None:
        """Send to other hosts what their robots hear."""
        by_host: dict[str, dict[int, Reception]] = {}
        for robot, reception in receptions.items():
            host, number = self._place_of[robot]
            by_host.setdefault(host, {})[number] = reception
        for host, heard in by_host.items():
            publisher, writer = self._batches[host]
            publisher.publish(writer.encode(*stamp_from_tick(tick), heard))
