"""Messages of stations and robots over the radio; any of them may be lost or late.

Every kind may arrive twice, and each receiver tells by order and grant whether it still counts.
Grants of one order are numbered from 1: a later one makes all before it void.
"""

from __future__ import annotations

from enum import Enum

import msgspec

from swarm_mission.orders.order import TransportOrder


class HoldPhase(Enum):
    """Phase of an order that a robot holds, as the robot reports it."""

    COMING = "coming"  # on its way to the origin
    HERE = "here"  # at the origin, to be loaded
    LOADED = "loaded"  # with the goods
    RELEASED = "released"  # gives it back


class Message(msgspec.Struct, frozen=True, tag_field="kind"):
    """Ticks are control periods of 0.1 s."""


class OrderOffer(msgspec.Struct, frozen=True):
    """An order that nobody has."""

    order: str
    target: str
    created: int  # tick
    priority: int = 0
    due: int | None = None  # tick


class Announcement(Message, frozen=True, tag="announcement"):
    """A station's open orders, the most urgent first."""

    station: str
    offers: tuple[OrderOffer, ...]


class Bid(Message, frozen=True, tag="bid"):
    """An idle robot would take an order, at a cost [m]; it could be there in `eta` ticks."""

    station: str
    robot: str
    order: str
    cost: float
    eta: int
    idle_since: int = 0  # tick


class Assignment(Message, frozen=True, tag="assignment"):
    """A dispatcher wants a station to grant an order to a robot."""

    station: str
    robot: str
    order: str


class Grant(Message, frozen=True, tag="grant"):
    """A station gives one of its orders to a robot."""

    station: str
    robot: str
    order: TransportOrder
    number: int  # of the grant of this order


class HoldReport(Message, frozen=True, tag="report"):
    """A robot says what it does with an order, to the order's origin."""

    station: str
    robot: str
    order: str
    number: int  # of the grant
    phase: HoldPhase


class Load(Message, frozen=True, tag="load"):
    """The origin hands the goods of an order over."""

    station: str
    robot: str
    order: str
    number: int  # of the grant


class Void(Message, frozen=True, tag="void"):
    """A grant does not count any more."""

    station: str
    robot: str
    order: str
    number: int  # of the grant


class Unload(Message, frozen=True, tag="unload"):
    """A robot is at the target with the goods of an order."""

    station: str
    robot: str
    order: str
    origin: str
    ticks: int = 0  # of service


class Received(Message, frozen=True, tag="received"):
    """The target has the goods; not `is_new` if another robot had brought them."""

    station: str
    robot: str
    order: str
    is_new: bool


class Delivered(Message, frozen=True, tag="delivered"):
    """The target tells the origin that an order is done."""

    station: str  # origin
    target: str
    order: str
    until: int = 0  # tick at which the service there ends


class Noted(Message, frozen=True, tag="noted"):
    """The origin has heard that an order is done."""

    station: str
    target: str
    order: str


AnyMessage = (
    Announcement
    | Bid
    | Assignment
    | Grant
    | HoldReport
    | Load
    | Void
    | Unload
    | Received
    | Delivered
    | Noted
)


class Envelope(msgspec.Struct, frozen=True):
    """A message with its sender and its receiver; an empty receiver is everybody."""

    sender: str
    receiver: str
    message: AnyMessage


LETTERS: msgspec.json.Decoder[Envelope] = msgspec.json.Decoder(Envelope)
