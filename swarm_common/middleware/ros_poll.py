"""Topics that are polled instead of called back: the cheap way to receive messages every tick.

An executor of rclpy spends a tenth of a millisecond on each message before a callback sees it. A
process that knows which message it needs can wait for that one topic and take the messages of the
others without waiting. Rare messages stay with an executor, which is emptied in between.

The subscriptions here are rclpy's own handles, see `rclpy_compat`.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo

from swarm_common.middleware import rclpy_compat
from swarm_common.middleware.rcl_take import NOBODY, Sender, Taker, sender_of

NANOSECONDS = 1_000_000_000
MOST_AT_ONCE = 100  # messages of others that are passed over before the rest has its turn
MOST_FOREIGN = 1000  # senders that are remembered
LOOK_AGAIN = NANOSECONDS  # [ns] after which a foreign sender is looked up again
SILENCE = NANOSECONDS  # [ns] after which an owner gives way to one with the same right
DRAIN_LIMIT = 0.1  # [s] of wall time for a portion of requests
UNKNOWN_NODE = "/_NODE_NAME_UNKNOWN_"
MOST_FAULTS = 1000  # of callbacks in one turn; more come from an executor that is broken


class PolledTopic:
    """A subscription of a node that no executor knows. Messages stay CDR bytes.

    rclpy does not say who sent a message; rcl does, so messages are taken from there.

    Attributes:
        sender: Id of the latest message's publisher in the graph.
        received: [ns] of wall time at which that message came.
    """

    def __init__(self, node: Node, kind: Any, name: str, quality: QoSProfile) -> None:
        """Subscribe.

        Args:
            quality: Its depth is the number of messages that can wait.
        """
        self.sender = NOBODY
        self.received = 0
        self._taker = Taker()
        self.handle = rclpy_compat.subscription(node, kind, name, quality)
        self._pointer: int = self.handle.pointer

    def take(self) -> bytes | None:
        """Return the oldest message that waits, None if there is none."""
        taker = self._taker
        data = taker.take(self._pointer)
        if data is not None:
            self.sender, self.received = taker.sender, taker.received
        return data

    @property
    def sequence(self) -> int:
        """Number of the message taken last among those of its sender on the topic."""
        return self._taker.sequence

    @property
    def senders(self) -> int:
        """Number of publishers whose messages it gets."""
        return int(self.handle.get_publisher_count())

    def destroy(self) -> None:
        """Unsubscribe; do it before the node is destroyed."""
        self._pointer = 0  # an index that rcl ignores
        self.handle.destroy_when_not_in_use()


class SoleTopic(PolledTopic):
    """A topic on which only one publisher's messages are accepted.

    That is the publisher of the rightful node, or the first publisher while there is no rightful
    one. Once the rightful one has appeared, no other is accepted. A new rightful one takes its
    place when the old one has left the graph or is silent, because DDS lists a killed process for
    10 s.
    """

    def __init__(
        self,
        node: Node,
        kind: Any,
        name: str,
        quality: QoSProfile,
        is_rightful: Callable[[str], bool],
        on_foreign: Callable[[str], None],
        *,
        is_shared: bool = False,
    ) -> None:
        """Subscribe.

        Args:
            is_rightful: Whether a node, by its full name, is to be heard before all others.
            on_foreign: Receives the node's name for each message that is ignored.
            is_shared: Whether all rightful nodes are heard, not one of them.
        """
        super().__init__(node, kind, name, quality)
        self._node, self._name = node, name
        self._is_rightful, self._on_foreign = is_rightful, on_foreign
        self._is_shared = is_shared
        self._owner = NOBODY
        self._has_rightful_owner = False
        self._heard = 0  # [ns] of wall time, the owner
        self._foreign: dict[Sender, tuple[int, str]] = {}  # since when, and its node

    def take(self) -> bytes | None:
        """Return the oldest waiting message of an accepted publisher; None if there is none."""
        for _ in range(MOST_AT_ONCE):
            data = super().take()
            if data is None:
                return None
            if self.sender == self._owner:
                self._heard = self.received
                return data
            if self._admit():
                return data
        return None

    def _admit(self) -> bool:
        """Whether to accept a message that is not the owner's; its sender may become the owner."""
        sender, now = self.sender, self.received
        since, name = self._foreign.get(sender, (0, ""))
        if now - since < LOOK_AGAIN and name:
            self._on_foreign(name)
            return False
        names = self._publishers()
        name = names.get(sender, UNKNOWN_NODE)
        is_rightful = self._is_rightful(name)
        if self._is_free(names, is_rightful):
            if name != UNKNOWN_NODE:  # DDS announces a publisher before its node
                self._owner, self._has_rightful_owner = sender, is_rightful
                self._heard = now
            return True
        if is_rightful and self._is_shared:
            return True
        is_early = name == UNKNOWN_NODE or is_rightful  # the owner may have just been killed
        if is_early and (not since or now - since < LOOK_AGAIN):
            self._remember(sender, since or now, "")
            return False
        self._remember(sender, now, name)
        self._on_foreign(name)
        return False

    def _is_free(self, names: dict[Sender, str], is_rightful: bool) -> bool:
        """Whether the present owner gives way to another."""
        if self._owner == NOBODY or (is_rightful and not self._has_rightful_owner):
            return True
        is_gone = self._owner not in names
        if is_rightful:
            return is_gone or self.received - self._heard > SILENCE
        return is_gone and not self._has_rightful_owner

    def _remember(self, sender: Sender, since: int, name: str) -> None:
        if len(self._foreign) >= MOST_FOREIGN:
            self._foreign.clear()
        self._foreign[sender] = since, name

    def _publishers(self) -> dict[Sender, str]:
        return {
            sender_of(info.endpoint_gid): full_name(info)
            for info in self._node.get_publishers_info_by_topic(self._name)
        }


def full_name(info: TopicEndpointInfo) -> str:
    """Return a publisher's node with its namespace.

    Args:
        info: Entry of the graph, which may not know the node yet (`UNKNOWN_NODE`).
    """
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


class PolledService:
    """A service of a node that no executor knows; its answers may come later."""

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        """Offer it; requests wait until they are taken."""
        self._kind = kind
        self._handle = rclpy_compat.service(node, kind, name)

    def take(self) -> tuple[Any, Any] | None:
        """Return a request that waits, and what `answer` wants to know of it.

        A request that is malformed is dropped.
        """
        try:
            request, header = self._handle.service_take_request(self._kind.Request)
        except RuntimeError:  # RCLError: its bytes are not a request of this type
            return None
        return None if header is None else (request, header.request_id)

    def answer(self, response: Any, request_id: Any) -> None:
        """Answer a request."""
        with contextlib.suppress(RuntimeError):  # RCLError: the client is gone
            self._handle.service_send_response(response, request_id)

    def destroy(self) -> None:
        """Withdraw it; do it before the node is destroyed."""
        self._handle.destroy_when_not_in_use()


class Waiter:
    """Waits for a message on any of a few topics."""

    def __init__(self, context: Context, capacity: int = 1) -> None:
        """Prepare to wait."""
        self._set = rclpy_compat.wait_set(context, capacity)

    def wait(self, topics: Sequence[PolledTopic], timeout: float) -> None:
        """Return when a message waits on one of the topics, or after a while."""
        self._set.clear_entities()
        for topic in topics:
            self._set.add_subscription(topic.handle)
        self._set.wait(int(timeout * NANOSECONDS))


def drain(executor: Executor, on_fault: Callable[[Exception], object] | None = None) -> None:
    """Call back for what waits in an EventsExecutor, for at most `DRAIN_LIMIT`.

    `spin_once` returns after one callback, and takes longer when there is none; so a task is
    queued behind all that waits, and the executor is spun until it has run. A flood is served in
    portions: what is left has its turn with the next call.

    Args:
        on_fault: Receives what a callback raises; then the others go on. None: it is raised.
    """
    done: list[bool] = []
    faults = 0
    executor.create_task(done.append, True)
    end = time.monotonic() + DRAIN_LIMIT
    while not done and time.monotonic() < end:
        try:
            executor.spin_once(timeout_sec=0.0)
        except Exception as error:
            faults += 1
            if on_fault is None or faults > MOST_FAULTS:
                raise
            on_fault(error)
