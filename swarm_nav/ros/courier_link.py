"""The robot's end of its link to its courier: `tick_report` out, `tick_release` in."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from rclpy.node import Node

from swarm_common.middleware import courier_io, ros_io
from swarm_common.middleware.courier_io import EndedGoal, TickRelease, TickReport
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import SoleTopic
from swarm_nav.core.goals import Status


class CourierLink:
    """Reports each tick, and knows which one the courier has released.

    Attributes:
        topic: Topic on which releases arrive.
    """

    def __init__(self, node: Node, rejections: Rejections) -> None:
        """Create the topics."""
        self._reports = node.create_publisher(courier_io.KIND, courier_io.REPORT, ros_io.RELIABLE)
        self.topic = SoleTopic(
            node,
            courier_io.KIND,
            courier_io.RELEASE,
            ros_io.TICK_INPUT,
            lambda who: who.startswith(courier_io.COURIER),
            lambda who: rejections.reject(courier_io.RELEASE, who, "another node is heard here"),
        )
        self._report = b""
        self._tick = -1
        self._release: TickRelease | None = None
        self._awaited: list[bytes] = []  # goals of the latest release

    def report(
        self,
        tick: int,
        status: Status,
        goal: bytes,
        ended: list[EndedGoal],
        refusal_of: Callable[[bytes], str | None],
    ) -> None:
        """Report that the robot has decided on a tick.

        Args:
            status: Its pose, battery and reach once the tick is decided.
            goal: Id of the current or pending goal; empty without one.
            ended: Goals that ended in this tick.
            refusal_of: Returns why a goal was refused; None if it was not.
        """
        refused = [(each, refusal_of(each)) for each in self._awaited]
        self._awaited = []
        ended = [
            *(EndedGoal(each, False, reason) for each, reason in refused if reason is not None),
            *ended,
        ]
        pose = status.pose_map
        x, y = (pose.x, pose.y) if pose is not None else (math.nan, math.nan)
        self._tick = tick
        report = TickReport(tick, x, y, status.battery, status.reach, goal, ended)
        self._report = courier_io.packed(report)
        self.repeat()

    def repeat(self) -> None:
        """Send the last report, again if it was sent: it or its answer may be lost."""
        self._reports.publish(self._report)

    def receive(self, data: bytes) -> None:
        """Receive a release.

        Raises:
            RejectedError: If it is none.
        """
        self._release = courier_io.read_release(data)
        if self._release.tick == self._tick:
            self._awaited = self._release.goals

    def missing_goals(self, knows: Callable[[bytes], bool]) -> Sequence[bytes] | None:
        """Return the goals that have to come before the tick is released; None without a release.

        Args:
            knows: Whether a goal has come.
        """
        if self._release is None or self._release.tick != self._tick:
            return None
        return [goal for goal in self._release.goals if not knows(goal)]
