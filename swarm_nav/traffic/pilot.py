"""Somebody who steers a robot in place of its controller, inside space that the robot reserves."""

from __future__ import annotations

from typing import Protocol

from swarm_common.model.records import Twist
from swarm_nav.interfaces import Proposal
from swarm_nav.traffic.robot_state import RobotView


class TwistPilot(Protocol):
    """The last rule of a robot, and what drives it; stop filter and speed limits stay above it.

    A class needs these methods and no base class: it may be one that is not compiled.
    """

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return where the robot is to reserve space; None to go on along the path it has."""

    def steer(self, robot: RobotView, stands: bool) -> Twist:
        """Return the twist of this tick, in base_footprint.

        Args:
            robot: Its path is tracked up to now.
            stands: Whether the rule that won asks the robot to stand.
        """
