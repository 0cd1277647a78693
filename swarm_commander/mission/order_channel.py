"""The topic `/orders`, which is the radio of orders between processes, and simulated time."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from swarm_common.middleware.rejections import Rejections
from swarm_common.model.records import tick_from_stamp
from swarm_mission.orders.messages import Announcement, AnyMessage, Envelope
from swarm_mission.orders.radio import OrderRadio

TOPIC = "/orders"
QUALITY = QoSProfile(depth=1000)
CLOCK_QUALITY = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
AHEAD = 600  # ticks that a sender's clock may be ahead of this process's


class Batch(msgspec.Struct, frozen=True):
    """What one process sends at a tick, as the JSON text of a message."""

    tick: int
    envelopes: list[Envelope]


BATCH: msgspec.json.Decoder[Batch] = msgspec.json.Decoder(Batch)


class OrderChannel:
    """Sends and receives envelopes; what arrives is lost or delayed as the radio says.

    Attributes:
        tick: Now, by `/clock`; 0 before the world runs.
        has_news: Whether time has passed, or something has come, since `receive`.
        stations: Whose announcements have reached this process, lost by the radio or not.
    """

    def __init__(self, node: Node, radio: OrderRadio, rejections: Rejections) -> None:
        self.tick = 0
        self.has_news = False
        self.stations: set[str] = set()
        self._radio = radio
        self._rejections = rejections
        self._publisher = node.create_publisher(String, TOPIC, QUALITY)
        self._subscriptions = (
            node.create_subscription(String, TOPIC, self._receive, QUALITY),
            node.create_subscription(Clock, "/clock", self._receive_clock, CLOCK_QUALITY),
        )

    def send(self, envelopes: Sequence[Envelope]) -> None:
        """Send what is to leave this process now."""
        if envelopes:
            batch = Batch(self.tick, list(envelopes))
            self._publisher.publish(String(data=msgspec.json.encode(batch).decode()))

    def receive(self, receivers: Sequence[str]) -> dict[str, list[AnyMessage]]:
        """Return what has arrived, by receiver."""
        self.has_news = False
        return self._radio.receive(self.tick, receivers)

    def _receive_clock(self, message: Clock) -> None:
        tick = tick_from_stamp(message.clock.sec, message.clock.nanosec)
        self.has_news |= tick > self.tick
        self.tick = max(self.tick, tick)

    def _receive(self, message: String) -> None:
        try:
            batch = BATCH.decode(message.data)
        except msgspec.DecodeError as error:
            self._rejections.reject("orders", TOPIC, error)
            return
        if not 0 <= batch.tick <= self.tick + AHEAD:
            self._rejections.reject("orders", TOPIC, f"tick {batch.tick}; it is {self.tick}")
            return
        self.has_news = True
        said = [each.message for each in batch.envelopes]
        self.stations |= {m.station for m in said if isinstance(m, Announcement)}
        # here the way takes its time by itself
        self._radio.send(batch.tick - 1, batch.envelopes)
