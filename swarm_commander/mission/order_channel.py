"""The topic `/orders`, which is the radio of orders between processes, and the lockstep on it."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Collection, Sequence
from typing import Any

import msgspec
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from swarm_common.middleware import cdr, ros_io
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import PolledTopic
from swarm_mission.orders.messages import AnyMessage, Envelope
from swarm_mission.orders.order_barrier import REPEATED, OrderBarrier
from swarm_mission.orders.radio import OrderRadio

TOPIC = "/orders"
QUALITY = QoSProfile(depth=1000)
CLOCK_QUALITY = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
AHEAD = 600  # ticks that a sender may be ahead of the clock as it was heard last
REPEAT_PERIOD = 0.25  # [s] of wall time of waiting after which our last words are sent again,
MOST_PERIOD = 1.0  # [s] and at most, as it doubles


class Batch(msgspec.Struct, frozen=True):
    """Messages of one process in a tick, as the JSON text of a message; often none."""

    tick: int
    envelopes: list[Envelope]
    party: str = ""  # name of the process; empty for one that nobody waits for
    is_in_step: bool = False  # whether one of its robots has decided on the tick
    is_over: bool = False  # whether it is a station all of whose orders are done


BATCH: msgspec.json.Decoder[Batch] = msgspec.json.Decoder(Batch)


class OrderChannel:
    """Sends and receives batches; what arrives is lost or delayed as the radio says.

    Attributes:
        tick: Tick on which this process decides next.
        barrier: Who has spoken.
        topics: Topics that are worth waiting for.
    """

    def __init__(
        self,
        node: Node,
        radio: OrderRadio,
        rejections: Rejections,
        party: str,
        parties: Collection[str],
    ) -> None:
        """Create the topic.

        Args:
            party: Name of this process on the topic, for the others' barriers.
            parties: Names of all, with this one.
        """
        self.tick = 0
        self.barrier = OrderBarrier(set(parties) - {party})
        self._party = party
        self._radio = radio
        self._rejections = rejections
        self._publisher = node.create_publisher(String, TOPIC, QUALITY)
        self._orders = PolledTopic(node, String, TOPIC, QUALITY)
        self._clock = PolledTopic(node, Clock, "/clock", CLOCK_QUALITY)
        self.topics = (self._orders, self._clock)
        self._over: dict[int, set[str]] = defaultdict(set)  # stations, by tick
        self._said: list[str] = []  # our batches of the last two ticks
        self._repeat_at = self._period = 0.0

    def poll(self) -> None:
        """Receive what has arrived."""
        while (data := self._clock.take()) is not None:
            self.barrier.see(cdr.read_tick(data))
        while (data := self._orders.take()) is not None:
            try:
                self._take(BATCH.decode(ros_io.unpacked(data, String).data))
            except (ValueError, msgspec.DecodeError) as error:
                self._rejections.reject("orders", TOPIC, error)

    def _take(self, batch: Batch) -> None:
        if batch.party == self._party:
            return
        if not 0 <= batch.tick <= max(self.tick, self.barrier.begun) + AHEAD:
            raise ValueError(f"tick {batch.tick}; it is {self.tick}")
        if not self.barrier.accepts(batch.party, batch.tick):
            return
        if self.barrier.hear(batch.party, batch.tick, is_in_step=batch.is_in_step):
            self._repeat_at = 0.0  # it may have missed what we said
        if batch.is_over:
            self._over[batch.tick].add(batch.party)
        self._radio.send(batch.tick, batch.envelopes)

    def can_begin(self, now: float) -> bool:
        """Whether all is heard that was said before the present tick.

        Args:
            now: [s] of wall time.
        """
        is_heard = self.barrier.is_complete(self.tick - 1, now)
        if not is_heard:
            self._repeat(now)
        return is_heard and self.barrier.is_due(self.tick)

    def are_over(self, stations: Collection[str], now: float) -> bool | None:
        """Whether stations are over in the present tick; None as long as one has not said so.

        Args:
            now: [s] of wall time.
        """
        if not self.barrier.is_complete(self.tick, now, stations):
            self._repeat(now)
            return None
        over = self._over.pop(self.tick, set())
        self._over = defaultdict(set, {t: who for t, who in self._over.items() if t > self.tick})
        if are_over := over.issuperset(stations):
            self._over[self.tick] = over  # it is asked for again
        return are_over

    def receive(self, receivers: Sequence[str]) -> dict[str, list[AnyMessage]]:
        """Return what has arrived until the present tick, by receiver."""
        return self._radio.receive(self.tick, receivers)

    def send(self, envelopes: Sequence[Envelope], **flags: Any) -> None:
        """Say all of the present tick.

        Args:
            flags: Those of `Batch`.
        """
        batch = Batch(self.tick, list(envelopes), self._party, **flags)
        self._radio.send(self.tick, envelopes)  # robots of one process hear each other
        text = msgspec.json.encode(batch).decode()
        self._said = [*self._said, text][-REPEATED:]
        self._publisher.publish(String(data=text))
        self._period, self._repeat_at = REPEAT_PERIOD, time.monotonic() + REPEAT_PERIOD

    def _repeat(self, now: float) -> None:
        if now >= self._repeat_at and self._said:
            self._repeat_at = now + self._period
            self._period = min(2.0 * self._period, MOST_PERIOD)
            for text in self._said:
                self._publisher.publish(String(data=text))
