"""The robot's end of its radio link to a centre: `report` out, `orders` in.

An order of tick t counts from tick t + 1: the robot does not decide on a tick before it has heard
what the centre said in the one before. A centre that is silent for too long is gone, and not waited
for until it is heard again.
"""

from __future__ import annotations

from rclpy.node import Node

from swarm_common.middleware import central_io, ros_io
from swarm_common.middleware.rejections import RejectedError, Rejections
from swarm_common.middleware.ros_poll import SoleTopic
from swarm_common.model.central import unpack_order
from swarm_nav.interfaces import Led

PATIENCE = 10.0  # [s] of wall time; the world waits longer for the robot


class CentreLink:
    """Carries what robot and centre tell each other.

    Attributes:
        topic: Topic on which orders arrive.
    """

    def __init__(self, node: Node, brain: Led, robot_id: int, rejections: Rejections) -> None:
        """Create the topics.

        Args:
            brain: Whose `traffic.coordination` wants a centre.
            robot_id: To which orders have to be.
        """
        self._brain, self._robot_id, self._rejections = brain, robot_id, rejections
        self._reports = node.create_publisher(central_io.KIND, central_io.REPORT, ros_io.RELIABLE)
        self.topic = SoleTopic(
            node,
            central_io.KIND,
            central_io.ORDERS,
            ros_io.TICK_INPUT,
            lambda who: who == central_io.CENTRE,
            lambda who: rejections.reject(central_io.ORDERS, who, "another node is heard here"),
        )

        self._report = b""
        self._reported = self._heard = -1  # ticks
        self._since: float | None = None  # wall time since when it is waited for
        self._is_gone = False

    def receive(self, data: bytes) -> None:
        """Receive the orders of a tick.

        Raises:
            RejectedError: If they are none.
        """
        tick, packed = central_io.read_orders(data)
        if tick <= self._heard:
            return
        self._heard = tick
        self._is_gone = False
        for each in packed:
            try:
                order = unpack_order(each)
            except ValueError as error:
                raise RejectedError(str(error)) from error
            if order.robot_id != self._robot_id:
                raise RejectedError(f"an order to robot {order.robot_id}")
            self._brain.take_order(order)

    def has_spoken(self, now: float) -> bool:
        """Whether the centre has answered the last report, or is gone.

        Args:
            now: [s] of wall time.
        """
        if self._heard >= self._reported or self._is_gone:
            self._since = None
            return True
        if self._since is None:
            self._since = now
        self._is_gone = now - self._since > PATIENCE
        return self._is_gone

    def send(self, tick: int) -> None:
        """Report to the centre, once a tick is decided."""
        report = self._brain.report()
        if report is not None:
            self._report, self._reported = central_io.wrapped(report.packed()), tick
            self.repeat()

    def repeat(self) -> None:
        """Send the last report, again if it was sent: it or the answer may be lost."""
        if self._report:
            self._reports.publish(self._report)
