"""The answer to a tick on the node: beacon and command, sent at once or withheld."""

from __future__ import annotations

import time

from geometry_msgs.msg import TwistStamped
from rclpy.node import Node
from swarm_interfaces.msg import Beacon, Mission

from swarm_common.middleware import ros_io
from swarm_common.middleware.cdr import CommandWriter
from swarm_common.model.beacon import serialize_beacon
from swarm_nav.core.goals import Output
from swarm_nav.ros.answer_barrier import AnswerBarrier


class Answers:
    """Sends the answer to each tick, and again when it is asked for; see `answer_barrier`."""

    def __init__(self, node: Node, *, waits_for_mission: bool, has_courier: bool) -> None:
        """Keep the node; `announce` has to follow before the first tick.

        Args:
            waits_for_mission: Whether a mission counts as active from the start.
            has_courier: Whether a courier releases each tick.
        """
        self._node = node
        self._has_courier = has_courier
        self._answer_barrier = AnswerBarrier(waits_for_mission, has_courier=has_courier)
        self._writer = CommandWriter("base_footprint")
        self._last: tuple[bytes, bytes] | None = None  # beacon and command

    def announce(self) -> None:
        """Create the topics; called once the map is there, to keep the traffic low at the start."""
        make = self._node.create_publisher
        self._beacon = make(Beacon, "beacon", ros_io.RELIABLE)
        self._cmd_vel = make(TwistStamped, "cmd_vel", ros_io.RELIABLE)

    @property
    def is_first(self) -> bool:
        """Whether no tick has been answered yet."""
        return self._last is None

    @property
    def is_withheld(self) -> bool:
        """Whether the last answer waits for the operator's next goal."""
        return self._answer_barrier.is_holding

    def give(self, tick: int, output: Output, *, has_goal: bool, has_ended: bool) -> None:
        """Answer a tick, unless it must wait.

        Args:
            has_goal: Whether there is a current or pending goal.
            has_ended: Whether a goal ended in this tick.
        """
        is_first = self.is_first
        self._last = serialize_beacon(output.beacon), self._writer.encode(tick, output.twist)
        if self._answer_barrier.should_hold(has_goal, is_first, has_ended):
            self._answer_barrier.hold(time.monotonic(), is_first)
        else:
            self._answer_barrier.release()
            self._send()

    def repeat(self) -> None:
        """Send the last answer once more, if it was sent."""
        if not self.is_withheld:
            self._send()

    def on_goal(self) -> None:
        """Send what was withheld until a goal came; a courier may have more to say."""
        if not self._has_courier:
            self.send_withheld()

    def expect_release(self) -> None:
        """Wait for the courier in each tick from now on: it has spoken."""
        self._answer_barrier.on_release()

    def send_withheld(self) -> None:
        """Send what was withheld, if anything."""
        if self.is_withheld:
            self._answer_barrier.release()
            self._send()

    def receive_mission(self, message: Mission) -> None:
        """Record whether more goals will come, and send what was withheld if none will."""
        if self._answer_barrier.on_mission(message.active, time.monotonic()):
            self.send_withheld()

    def look(self, tick: int, now: float) -> None:
        """Send what was withheld for a mission that has been silent for too long.

        Args:
            now: [s] of wall time.
        """
        if self._answer_barrier.has_expired(now):
            self._node.get_logger().warning(
                f"tick {tick}: the {self._operator} is silent; going on without it"
            )
            self.send_withheld()

    @property
    def _operator(self) -> str:
        return "courier" if self._has_courier else "mission"

    def _send(self) -> None:
        if self._last is not None:
            beacon, command = self._last
            self._beacon.publish(beacon)
            self._cmd_vel.publish(command)
