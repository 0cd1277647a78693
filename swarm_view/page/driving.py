"""Driving a robot by hand from a page, as a client of its `assisted_teleop` like `swarm-teleop`."""

from __future__ import annotations

from collections.abc import Callable

from swarm_common.model.records import Twist
from swarm_run.robots.teleop_keys import HOLD, LEAST, MOST
from swarm_view.state.operator_link import OperatorLink, Tell

PERIOD = 0.05  # [s] of wall time between two wishes


class Driving:
    """One page's control of a robot by hand; `share` is the part of its full speed."""

    def __init__(self, link: OperatorLink) -> None:
        self.robot = ""
        self.share = 0.5
        self._link = link
        self._way = (0.0, 0.0)
        self._until = self._due = 0.0

    def begin(self, robot: str, tell: Tell, on_end: Callable[[], None]) -> None:
        """Begin to drive a robot."""
        self.end()
        self.robot = robot
        self._way, self._until = (0.0, 0.0), 0.0

        def ended() -> None:
            if self.robot == robot:
                self.robot = ""
                on_end()

        self._link.begin_drive(robot, tell, ended)

    def end(self) -> None:
        """Give the robot back."""
        if self.robot:
            robot, self.robot = self.robot, ""
            self._link.end_drive(robot)

    def steer(self, ahead: float, turn: float, now: float) -> None:
        """Set the command of the page's keys, each -1 to 1; it counts for a moment only."""
        self._way = min(1.0, max(-1.0, ahead)), min(1.0, max(-1.0, turn))
        self._until = now + HOLD

    def set_share(self, share: float) -> None:
        """Drive with a share of the full speed."""
        self.share = min(MOST, max(LEAST, share))

    def update(self, now: float) -> None:
        """Say what is wanted, from time to time; `now` is wall time."""
        if not self.robot or now < self._due:
            return
        self._due = now + PERIOD
        full = self._link.full_speed(self.robot)
        if full is None:
            return
        ahead, turn = self._way if now < self._until else (0.0, 0.0)
        self._link.wish(
            self.robot, Twist(self.share * full.vx * ahead, 0.0, self.share * full.wz * turn)
        )
