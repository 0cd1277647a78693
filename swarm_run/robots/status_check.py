"""The door of the operator's side: which statuses are their robots', and of now."""

from __future__ import annotations

import statistics
import time

from geometry_msgs.msg import Pose2D
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.cdr_layout import check_stamp
from swarm_common.middleware.rejections import RejectedError, Rejections
from swarm_common.model.records import tick_from_stamp

SLACK = 600  # ticks, a minute, that a robot may be ahead of the latest status,
FASTEST = 2000.0  # and ticks per second of wall time since: 200 times real time


class StatusCheck:
    """Follows the ticks of all robots: no status is of a time that the swarm cannot have reached.

    A navigator that was started again tells its initial pose until its first tick; its robot is
    where it was heard last.

    Time is that of the swarm, which only its statuses tell. Each robot's latest bounds what the
    time can be now; the median of the bounds counts, so that no single forger moves it.
    """

    def __init__(self, rejections: Rejections) -> None:
        """Begin without robots.

        Args:
            rejections: Counts the statuses that are not admitted.
        """
        self._rejections = rejections
        self._heard: dict[str, tuple[int, float]] = {}  # tick and wall time of the latest
        self._poses: dict[str, Pose2D] = {}  # in map, of statuses of a tick

    def admits(self, name: str, status: RobotStatus, now: float | None = None) -> bool:
        """Whether a status on the topic of a robot is to be believed; one that is not is counted.

        Args:
            now: Wall time [s]; by default that of the clock.
        """
        now = time.monotonic() if now is None else now
        try:
            self._heard[name] = self._tick(name, status, now), now
        except RejectedError as error:
            self._rejections.reject("status", name, error)
            return False
        if self._heard[name][0] == 0:
            status.pose = self._poses.get(name, status.pose)
        else:
            self._poses[name] = status.pose
        return True

    def _tick(self, name: str, status: RobotStatus, now: float) -> int:
        if status.robot != name:
            raise RejectedError(f"a status of '{status.robot[:50]}' on the topic of {name}")
        check_stamp(status.stamp.sec, status.stamp.nanosec)
        tick = tick_from_stamp(status.stamp.sec, status.stamp.nanosec)
        bounds = [
            heard + SLACK + FASTEST * (now - heard_at) for heard, heard_at in self._heard.values()
        ]
        if bounds and tick > statistics.median_low(bounds):
            raise RejectedError(
                f"its stamp is of tick {tick}; it is {statistics.median_low(bounds):.0f} at most"
            )
        return tick
