"""Messages between a robot and its courier in each tick, in `std_msgs/UInt8MultiArray`.

The robot reports that it has decided on a tick, and answers the world when its courier releases
the tick. So whatever the courier decides takes effect one tick later, on any machine.
"""

from __future__ import annotations

from typing import TypeVar

import msgspec
from rclpy.node import Node

from swarm_common.middleware.central_io import KIND as KIND
from swarm_common.middleware.central_io import unwrapped, wrapped
from swarm_common.middleware.rejections import RejectedError, Rejections
from swarm_common.middleware.ros_io import RELIABLE, TICK_INPUT
from swarm_common.middleware.ros_poll import SoleTopic

REPORT, RELEASE = "tick_report", "tick_release"  # topics of a robot
SPEAKERS = "/courier_", "/vda5050"  # how the names of nodes begin that release ticks


class EndedGoal(msgspec.Struct, frozen=True, array_like=True):
    """An action's goal that ended in a tick, or was refused before it."""

    goal: bytes  # id
    is_reached: bool
    reason: str = ""  # why it was missed
    code: int = 0  # Nav2's error code


class TickReport(msgspec.Struct, frozen=True, array_like=True):
    """A robot has decided on a tick."""

    tick: int
    x: float  # [m] in map
    y: float  # [m] in map
    battery: float  # charge by capacity; NaN without one
    reach: float  # [m] that it can drive before it goes to charge
    goal: bytes  # id of the current or pending goal of an action; empty without one
    ended: list[EndedGoal]
    yaw: float = 0.0  # [rad] in map
    is_by_hand: bool = False  # whether somebody drives it
    is_charging: bool = False  # whether current flows into its battery


class TickRelease(msgspec.Struct, frozen=True, array_like=True):
    """All is said for a tick."""

    tick: int
    goals: list[bytes]  # ids of the goals that were sent in it and have to be there first
    cancelled: list[bytes] = []  # goals whose cancellation has to be there first
    speed_limit: float | None = None  # [m/s] from now on; 0 for none, None for the one before
    keepout: bytes = b""  # filter mask from now on, an OccupancyGrid; empty for the one before
    directed: bytes = b""  # zones from now on, see `directed_io`; empty for those before


Told = TypeVar("Told", TickReport, TickRelease)
_ENCODER = msgspec.msgpack.Encoder()
_REPORTS = msgspec.msgpack.Decoder(TickReport)
_RELEASES = msgspec.msgpack.Decoder(TickRelease)


def packed(message: TickReport | TickRelease) -> bytes:
    """Return a message in CDR."""
    return wrapped(_ENCODER.encode(message))


def read_report(data: bytes) -> TickReport:
    """Return a robot's report.

    Args:
        data: Whole message as it was taken, with its encapsulation.

    Raises:
        RejectedError: If it is none.
    """
    return _read(data, _REPORTS)


def read_release(data: bytes) -> TickRelease:
    """Return a courier's release.

    Args:
        data: Whole message as it was taken, with its encapsulation.

    Raises:
        RejectedError: If it is none.
    """
    return _read(data, _RELEASES)


def _read(data: bytes, decoder: msgspec.msgpack.Decoder[Told]) -> Told:
    try:
        return decoder.decode(unwrapped(data))
    except msgspec.DecodeError as error:
        raise RejectedError(str(error)) from error


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
        self._releases = node.create_publisher(KIND, f"/{name}/{RELEASE}", RELIABLE)
        self.topic = SoleTopic(
            node,
            KIND,
            f"/{name}/{REPORT}",
            TICK_INPUT,
            lambda who: who == f"/{name}/navigator",
            lambda who: rejections.reject(REPORT, who, "another node is heard here"),
        )
        self._latest: tuple[int, bytes] = -1, b""  # release, with its tick

    def take(self) -> TickReport | None:
        """Return a report that waits for a release; a repeated one gets its own again."""
        while (data := self.topic.take()) is not None:
            try:
                report = read_report(data)
            except RejectedError as error:
                self._rejections.reject(REPORT, self._name, error)
                continue
            if report.tick != self._latest[0]:
                return report
            self._releases.publish(self._latest[1])
        return None

    def release(self, release: TickRelease) -> None:
        """Let the robot answer a tick."""
        self._latest = release.tick, packed(release)
        self._releases.publish(self._latest[1])

    def forget(self) -> None:
        """Forget the latest release: the robot's navigator knows nothing of its goals."""
        self._latest = -1, b""
