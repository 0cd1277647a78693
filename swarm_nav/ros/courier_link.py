"""The robot's end of its link to its courier: `tick_report` out, `tick_release` in."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from rclpy.node import Node

from swarm_common.middleware import courier_io, ros_io
from swarm_common.middleware.courier_io import EndedGoal, TickRelease, TickReport
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import SoleTopic
from swarm_common.model.palette import BY_HAND
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
            lambda who: who.startswith(courier_io.SPEAKERS),
            lambda who: rejections.reject(courier_io.RELEASE, who, "another node is heard here"),
        )
        self._report = b""
        self._tick = -1
        self._release: TickRelease | None = None
        self._is_obeyed = True
        self._awaited: list[bytes] = []  # goals of the latest release

    def report(
        self,
        tick: int,
        status: Status,
        goal: bytes,
        ended: list[EndedGoal],
        refusal_of: Callable[[bytes], str | None],
        *,
        is_charging: bool,
    ) -> None:
        """Report that the robot has decided on a tick.

        Args:
            status: Its pose, battery and reach once the tick is decided.
            goal: Id of the current or pending goal; empty without one.
            ended: Goals that ended in this tick.
            refusal_of: Returns why a goal was refused; None if it was not.
            is_charging: Whether current flows into its battery.
        """
        refused = [(each, refusal_of(each)) for each in self._awaited]
        self._awaited = []
        ended = [
            *(EndedGoal(each, False, reason) for each, reason in refused if reason is not None),
            *ended,
        ]
        pose = status.pose_map
        x, y, yaw = (pose.x, pose.y, pose.yaw) if pose is not None else (math.nan,) * 3
        self._tick = tick
        report = TickReport(
            tick, x, y, status.battery, status.reach, goal, ended, yaw,
            is_by_hand=status.state == BY_HAND, is_charging=is_charging,
        )  # fmt: skip
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
        before, self._release = self._release, courier_io.read_release(data)
        if self._release.tick == self._tick:
            self._awaited = self._release.goals
        if before is None or before.tick != self._release.tick:
            self._is_obeyed = False

    def obey(self) -> TickRelease | None:
        """Return the latest release, None if it has been returned: its limits count once."""
        if self._is_obeyed:
            return None
        self._is_obeyed = True
        return self._release

    @property
    def release(self) -> TickRelease | None:
        """The release of the present tick; None before it has come."""
        known = self._release
        return known if known is not None and known.tick == self._tick else None

    def missing_goals(
        self, knows: Callable[[bytes], bool], is_cancelled: Callable[[bytes], bool]
    ) -> Sequence[bytes] | None:
        """Return the goals that have to come, or to be cancelled, before the tick is released.

        Args:
            knows: Whether a goal has come.
            is_cancelled: Whether a goal does not go on.

        Returns:
            Their ids; None without a release.
        """
        release = self.release
        if release is None:
            return None
        late = [goal for goal in release.cancelled if not is_cancelled(goal)]
        return [*late, *(goal for goal in release.goals if not knows(goal))]
