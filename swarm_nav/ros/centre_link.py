"""The robot's end of its radio link to a centre: `report` out, `orders` in."""

from __future__ import annotations

from rclpy.node import Node

from swarm_common.middleware import central_io, ros_io
from swarm_common.middleware.rejections import RejectedError, Rejections
from swarm_common.middleware.ros_poll import SoleTopic
from swarm_common.model.central import unpack_order
from swarm_nav.behaviour.navigator import Navigator


class CentreLink:
    """Carries what robot and centre tell each other."""

    def __init__(self, node: Node, brain: Navigator, robot_id: int, rejections: Rejections) -> None:
        """Create the topics.

        Args:
            brain: Whose `traffic.coordination` wants a centre.
            robot_id: To which orders have to be.
        """
        self._brain, self._robot_id, self._rejections = brain, robot_id, rejections
        self._reports = node.create_publisher(central_io.KIND, central_io.REPORT, ros_io.RELIABLE)
        self._orders = SoleTopic(
            node,
            central_io.KIND,
            central_io.ORDERS,
            ros_io.TICK_INPUT,
            lambda who: who == central_io.CENTRE,
            lambda who: rejections.reject(central_io.ORDERS, who, "another node is heard here"),
        )

    def receive(self) -> None:
        """Take the orders that have arrived."""
        while (data := self._orders.take()) is not None:
            try:
                order = unpack_order(central_io.unwrapped(data))
                if order.robot_id != self._robot_id:
                    raise RejectedError(f"an order to robot {order.robot_id}")
            except ValueError as error:
                self._rejections.reject(central_io.ORDERS, "the centre", error)
            else:
                self._brain.take_order(order)

    def send(self) -> None:
        """Report to the centre, once a tick is decided."""
        report = self._brain.report()
        if report is not None:
            self._reports.publish(central_io.wrapped(report.packed()))
