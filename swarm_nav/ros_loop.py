"""What a navigator process waits for: the next tick; everything else is looked at in between."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rclpy.context import Context
from rclpy.executors import Executor

from swarm_common.ros_poll import Waiter, drain
from swarm_nav.node import NavigatorNode

TICK_SLICE = 0.05  # [s] of wall time without a tick after which other things are looked at
WAIT_SLICE = 0.25  # [s] the same while no tick can come; signals are looked at as well
REQUEST_PERIOD = 0.05  # [s] of wall time between two looks while ticks come
PACK_SLICE = 0.01  # [s] while some navigators of the process wait for a tick and some do not


class TickLoop:
    """The navigators of one process, turn after turn.

    Sensor data are waited for and taken directly (`ros_poll`): once per tick, where an executor
    would be woken for each message. Requests, goals and parameters come through the executor,
    which is emptied now and then. While no tick can come, that is, before the map or while an
    answer is withheld until the next goal, the executor is what is waited for.
    """

    def __init__(
        self, nodes: Sequence[NavigatorNode], executor: Executor, context: Context
    ) -> None:
        """Take the nodes of the process and the executor for all that is not sensor data."""
        self._nodes = nodes
        self._executor = executor
        self._waiter = Waiter(context, len(nodes))
        self._requests_due = 0.0
        for node in nodes:
            executor.add_node(node.node)

    def turn(self) -> None:
        """Wait for something to do, and do it."""
        awaited = [node.awaited for node in self._nodes]
        topics = [topic for topic in awaited if topic is not None]
        if len(topics) == len(self._nodes):
            self._waiter.wait(topics, TICK_SLICE)
        else:
            self._executor.spin_once(timeout_sec=PACK_SLICE if topics else WAIT_SLICE)
        for node in self._nodes:
            node.take_inputs()
        now = time.monotonic()
        if now >= self._requests_due:
            self._requests_due = now + REQUEST_PERIOD
            drain(self._executor)
            for node in self._nodes:
                node.look_around(now)
