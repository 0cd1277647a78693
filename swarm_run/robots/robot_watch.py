"""Whether a robot that a program has sent somewhere is still there to answer."""

from __future__ import annotations

import time
from functools import partial

from rclpy.node import Node

from swarm_common.model.errors import NoSwarmError, SwarmEndedError
from swarm_common.model.robot_names import natural
from swarm_run.robots.discovery import robots_in_graph
from swarm_run.robots.swarm_watch import SwarmWatch, has_swarm

PERIOD = 1.0  # [s] of wall time between two looks
GONE_TIME = 5.0  # [s] of wall time without a robot after which it is not waited for


class RobotWatch:
    """Notices that a robot is gone, with its swarm or alone, or was never there.

    A robot that is restarted is away for a moment, and one of a swarm that starts comes yet.
    """

    def __init__(self, node: Node, name: str) -> None:
        """Begin to watch a robot.

        Args:
            node: Node in the ROS domain of the robot; it is not spun.
            name: Namespace of the robot, like `Srobot3`.
        """
        self._node, self._name = node, name
        self._swarm = SwarmWatch(node)
        self._has_swarm = partial(has_swarm, node.context.get_domain_id())
        self._was_there = False
        self._absent_since: float | None = None
        self._due = 0.0
        self._reason = ""

    def look(self, now: float | None = None) -> str:
        """Look if it is time to; return why the robot cannot answer, or nothing.

        Args:
            now: Wall time [s]; by default that of the clock.
        """
        now = time.monotonic() if now is None else now
        if now >= self._due:
            self._due = now + PERIOD
            self._reason = self._find_reason(now)
        return self._reason

    def _find_reason(self, now: float) -> str:
        if self._swarm.look(now):
            return str(SwarmEndedError())
        if self._node.count_publishers(f"/{self._name}/status"):
            self._was_there, self._absent_since = True, None
            return ""
        if self._absent_since is None:
            self._absent_since = now
        if now - self._absent_since < GONE_TIME:
            return ""
        if self._was_there:
            return f"{self._name} is gone: it was removed, or its navigator has ended"
        if self._has_swarm() is False:
            return str(NoSwarmError(self._node.context.get_domain_id()))
        return others(self._node, self._name)


def others(node: Node, name: str) -> str:
    """Return a line on which robots there are instead of this one; empty if it or none is there.

    Args:
        node: Node whose view of the ROS graph counts; it is not spun.
    """
    robots = robots_in_graph(node)
    if not robots or name in robots:
        return ""
    return f"no robot '{name}' is running; there are {', '.join(sorted(robots, key=natural))}"
