"""A vehicle's part in lockstep: its robot reports each tick, and answers when it is released."""

from __future__ import annotations

from rclpy.node import Node

from swarm_common.middleware import courier_io
from swarm_common.middleware.courier_io import TickRelease, TickReport
from swarm_common.middleware.rejections import RejectedError, Rejections
from swarm_common.middleware.ros_io import RELIABLE, TICK_INPUT
from swarm_common.middleware.ros_poll import SoleTopic


class StepLink:
    """Receives the reports of one robot, and releases its ticks.

    Attributes:
        topic: Where reports arrive.
    """

    def __init__(self, node: Node, name: str, rejections: Rejections) -> None:
        """Create the topics.

        Args:
            name: Namespace of the robot, without a slash.
        """
        self._name, self._rejections = name, rejections
        self._releases = node.create_publisher(
            courier_io.KIND, f"/{name}/{courier_io.RELEASE}", RELIABLE
        )
        self.topic = SoleTopic(
            node,
            courier_io.KIND,
            f"/{name}/{courier_io.REPORT}",
            TICK_INPUT,
            lambda who: who == f"/{name}/navigator",
            lambda who: rejections.reject(courier_io.REPORT, who, "another node is heard here"),
        )
        self._latest: tuple[int, bytes] = -1, b""  # release, with its tick

    def take(self) -> TickReport | None:
        """Return a report that waits for a release; a repeated one gets its own again."""
        while (data := self.topic.take()) is not None:
            try:
                report = courier_io.read_report(data)
            except RejectedError as error:
                self._rejections.reject(courier_io.REPORT, self._name, error)
                continue
            if report.tick != self._latest[0]:
                return report
            self._releases.publish(self._latest[1])
        return None

    def release(self, release: TickRelease) -> None:
        """Let the robot answer a tick."""
        self._latest = release.tick, courier_io.packed(release)
        self._releases.publish(self._latest[1])

    def forget(self) -> None:
        """Forget the latest release: the robot's navigator knows nothing of its goals."""
        self._latest = -1, b""
