"""Messages between robots and a centre on the graph: bytes in `std_msgs/UInt8MultiArray`.

In each tick a robot reports, and the centre tells each robot its orders, mostly none. A robot
decides on the next tick when it has heard that.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable

import msgspec
from std_msgs.msg import UInt8MultiArray

from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.beacon import ENCAPSULATION

KIND = UInt8MultiArray
REPORT, ORDERS = "report", "orders"  # topics of a robot
CENTRE = "/central"  # node
_Said = tuple[int, list[bytes]]  # tick, and the orders of a robot
_ENCODER = msgspec.msgpack.Encoder()
_DECODER = msgspec.msgpack.Decoder(_Said)
_HEAD = struct.Struct("<III")  # dimensions, offset, and bytes that follow


def wrapped(content: bytes) -> bytes:
    """Return bytes as a serialised message."""
    return ENCAPSULATION + _HEAD.pack(0, 0, len(content)) + content


def unwrapped(message: bytes) -> bytes:
    """Return the bytes in a serialised message.

    Raises:
        RejectedError: If it is none of ours.
    """
    first = len(ENCAPSULATION) + _HEAD.size
    head = message[len(ENCAPSULATION) : first]
    if len(head) < _HEAD.size or _HEAD.unpack(head)[:2] != (0, 0):
        raise RejectedError("not a message between a robot and the centre")
    return message[first : first + _HEAD.unpack(head)[2]]


def orders_message(tick: int, orders: Iterable[bytes]) -> bytes:
    """Return the message of a centre to a robot in a tick, serialised.

    Args:
        orders: Packed; may be none.
    """
    return wrapped(_ENCODER.encode((tick, list(orders))))


def read_orders(message: bytes) -> tuple[int, list[bytes]]:
    """Return the tick and the packed orders in what a centre says.

    Raises:
        RejectedError: If it is none of ours.
    """
    try:
        return _DECODER.decode(unwrapped(message))
    except msgspec.DecodeError as error:
        raise RejectedError(str(error)) from error
