"""Driving a robot by hand from a page, as a client of its `assisted_teleop` like `swarm-teleop`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from swarm_commander.cli.teleop_keys import HOLD, LEAST, MOST
from swarm_common.model.records import Twist

PERIOD = 0.05  # [s] of wall time between two wishes
Tell = Callable[[str], None]


class Steering(Protocol):
    """What a robot is driven with."""

    def begin_drive(self, robot: str, tell: Tell, on_end: Callable[[], None]) -> None:
        """Ask a robot to be driven; `on_end` is called when it is not any more."""

    def full_speed(self, robot: str) -> Twist | None:
        """Return a robot's full speed; None before it is known."""

    def wish(self, robot: str, twist: Twist) -> None:
        """Say how a robot is to drive."""

    def end_drive(self, robot: str) -> None:
        """Give a robot back to its mission."""


class Driving:
    """One page's hand on a robot.

    Attributes:
        robot: That is driven; empty for none.
        share: Of its full speed.
    """

    def __init__(self, wheel: Steering) -> None:
        self.robot = ""
        self.share = 0.5
        self._wheel = wheel
        self._way = (0.0, 0.0)
        self._until = self._due = 0.0

    def begin(self, robot: str, tell: Tell, on_end: Callable[[], None]) -> None:
        """Take a robot."""
        self.end()
        self.robot = robot
        self._way, self._until = (0.0, 0.0), 0.0

        def ended() -> None:
            if self.robot == robot:
                self.robot = ""
                on_end()

        self._wheel.begin_drive(robot, tell, ended)

    def end(self) -> None:
        """Give the robot back."""
        if self.robot:
            robot, self.robot = self.robot, ""
            self._wheel.end_drive(robot)

    def steer(self, ahead: float, turn: float, now: float) -> None:
        """Take what the page's keys say, each -1 to 1; it counts for a moment only."""
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
        full = self._wheel.full_speed(self.robot)
        if full is None:
            return
        ahead, turn = self._way if now < self._until else (0.0, 0.0)
        self._wheel.wish(
            self.robot, Twist(self.share * full.vx * ahead, 0.0, self.share * full.wz * turn)
        )
