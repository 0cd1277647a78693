"""Topics that are looked at, not called back: the cheap way to take what comes every tick.

An executor of rclpy spends a tenth of a millisecond on each message before a callback sees it. A
process that knows what it waits for can wait for that one topic and take the others' messages
without waiting. Everything that comes rarely stays with an executor, which is emptied in between.

The subscriptions here are rclpy's own handles; there is no public class for them.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import Any

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.type_support import check_for_type_support

NANOSECONDS = 1_000_000_000


class PolledTopic:
    """A subscription of a node that no executor knows. Messages stay CDR bytes."""

    def __init__(self, node: Node, kind: Any, name: str, quality: QoSProfile) -> None:
        """Subscribe.

        Args:
            node: Appears as the subscriber in the graph.
            kind: Message type.
            name: Topic, relative to the node's namespace or absolute.
            quality: Its depth is how many messages wait.
        """
        check_for_type_support(kind)
        self._kind = kind
        with node.handle:
            self.handle = _rclpy.Subscription(node.handle, kind, name, quality.get_c_qos_profile())

    def take(self) -> bytes | None:
        """Return the oldest message that waits, None if there is none."""
        taken = self.handle.take_message(self._kind, True)
        return None if taken is None else taken[0]

    def destroy(self) -> None:
        """Unsubscribe; do it before the node is destroyed."""
        self.handle.destroy_when_not_in_use()


class PolledService:
    """A service of a node that no executor knows; its answers may come later."""

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        """Offer it; requests wait until they are taken."""
        check_for_type_support(kind)
        self._kind = kind
        with node.handle:
            self._handle = _rclpy.Service(
                node.handle, kind, name, qos_profile_services_default.get_c_qos_profile()
            )

    def take(self) -> tuple[Any, Any] | None:
        """Return a request that waits, and what `answer` wants to know of it.

        A request that is malformed is dropped.
        """
        try:
            request, header = self._handle.service_take_request(self._kind.Request)
        except RuntimeError:  # RCLError: its bytes are no such request
            return None
        return None if header is None else (request, header.request_id)

    def answer(self, response: Any, request_id: Any) -> None:
        """Answer a request."""
        with contextlib.suppress(RuntimeError):  # RCLError: who asked is gone
            self._handle.service_send_response(response, request_id)

    def destroy(self) -> None:
        """Withdraw it; do it before the node is destroyed."""
        self._handle.destroy_when_not_in_use()


class Waiter:
    """Waits for a message on any of a few topics."""

    def __init__(self, context: Context, capacity: int = 1) -> None:
        """Prepare to wait for up to `capacity` topics at a time."""
        with context.handle:
            self._set = _rclpy.WaitSet(capacity, 0, 0, 0, 0, 0, context.handle)

    def wait(self, topics: Sequence[PolledTopic], timeout: float) -> None:
        """Return when a message waits on one of the topics, or after `timeout` [s]."""
        self._set.clear_entities()
        for topic in topics:
            self._set.add_subscription(topic.handle)
        self._set.wait(int(timeout * NANOSECONDS))


def drain(executor: Executor) -> None:
    """Call back for everything that waits in an EventsExecutor, without waiting for more.

    `spin_once` returns after one callback, and takes longer when there is none; so a task is
    queued behind all that waits, and the executor is spun until it has run.
    """
    done: list[bool] = []
    executor.create_task(done.append, True)
    while not done:
        executor.spin_once(timeout_sec=0.0)
