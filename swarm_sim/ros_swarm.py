"""The topics of all robots on the side of the world, in the order of robots."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rclpy.node import Node

from swarm_common.participants import Hubs
from swarm_common.records import RobotSpec, Twist
from swarm_common.ros_poll import Waiter
from swarm_sim.barrier import Barrier
from swarm_sim.build import Stage
from swarm_sim.crew import number_of
from swarm_sim.ros_foreign import Foreigners
from swarm_sim.ros_links import RobotLink
from swarm_sim.settings import Settings
from swarm_sim.world import Observation, World

KEEPS_UP = 10  # ticks that a late robot may be behind to be waited for again


class Links:
    """Publishes observations and collects answers; tells the barrier who has answered."""

    def __init__(
        self,
        node: Node,
        stage: Stage,
        settings: Settings,
        barrier: Barrier,
        foreigners: Foreigners,
        *,
        is_large: bool,
    ) -> None:
        """Create all topics.

        Args:
            node: Of the world.
            stage: Robots and world.
            settings: Of the world.
            barrier: Waits for the robots.
            foreigners: Told of what is not a robot's own.
            is_large: Whether the topics are spread over hubs, see `participants`.
        """
        self._settings = settings
        self._barrier = barrier
        self._foreigners = foreigners
        robots = len(stage.specs)
        self._hubs = Hubs(node, robots, is_large=is_large, with_gallery=True)
        self._waiter = Waiter(node.context)
        self._links: list[RobotLink] = []
        for index, entry in enumerate(settings.robots):
            self.add(index, entry.name, stage.specs[index], stage.urdfs[index])

    @property
    def names(self) -> list[str]:
        """Namespaces of the robots, also of those that are gone."""
        return [link.name for link in self._links]

    @property
    def meeting_ports(self) -> dict[str, list[int]]:
        """Where the navigator of each robot meets the world."""
        ports = self._hubs.ports(self.names)
        return {name: [*self._hubs.own_ports, port] for name, port in ports.items()}

    def add(self, robot: int, name: str, spec: RobotSpec, urdf: str) -> bool:
        """Create the topics of a robot, a new one or in place of one that is gone.

        Returns:
            Whether it is a new one.
        """

        def note_answer() -> None:
            self._barrier.answer(robot)

        node = self._hubs.node_of(robot)
        link = RobotLink(
            node,
            self._hubs.gallery,
            name,
            spec,
            urdf,
            self._settings,
            number_of(name),
            note_answer,
            self._foreigners,
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

    def open(self, tick: int, observations: Sequence[Observation]) -> None:
        """Begin a tick: forget the last answers, publish what the robots sense."""
        for link in self._links:
            link.open(tick)
        for link, observation in zip(self._links, observations, strict=True):
            link.publish(observation)

    def repeat(self, observations: Sequence[Observation], *, to_newcomers: bool) -> None:
        """Publish once more for robots that were not there or lost a message.

        Args:
            observations: Of the tick in hand.
            to_newcomers: Only for those that have been there for few repeats.
        """
        for robot in self._barrier.missing():
            link = self._links[robot]
            if link.is_newcomer() or not to_newcomers:
                link.publish(observations[robot])

    def wait(self, timeout: float) -> None:
        """Wait for the middle one of the robots whose answers are missing, at most `timeout` [s].

        When it has answered, so have about half of them: a tick takes few looks at all.
        """
        missing = self._barrier.missing()
        self._waiter.wait([self._links[missing[len(missing) // 2]].awaited], timeout)

    def take_answers(self) -> None:
        """Take what has come from robots whose answer is not whole, also from the late."""
        for robot, link in enumerate(self._links):
            if link.has_answered:
                continue
            before = link.newest_tick
            link.take_answers()
            if link.newest_tick > before and 0 < link.lag <= KEEPS_UP:
                self._barrier.hear(robot)

    def answers(self) -> tuple[list[Twist | None], list[np.void | None]]:
        """Return command and beacon of each robot; who did not answer in time stops."""
        commands = [link.fresh_command() for link in self._links]
        if not self._settings.free_run:
            commands = [command or Twist() for command in commands]
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

    def look_for_viewers(self) -> None:
        """See which of the topics that only viewers need have a subscriber."""
        for link in self._links:
            link.look_for_viewers()

    def look_for_foreigners(self) -> None:
        """See who else publishes on topics of the robots; each time of a few of them."""
        seats = [
            (self._hubs.node_of(robot), link.name)
            for robot, link in enumerate(self._links)
            if not link.is_gone
        ]
        self._foreigners.look(seats, is_free_run=self._settings.free_run)

    def destroy(self) -> None:
        """Leave the graph, except with the world's own node."""
        self._hubs.destroy()
