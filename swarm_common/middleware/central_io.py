"""Messages between robots and a centre on the graph: bytes in `std_msgs/UInt8MultiArray`."""

from __future__ import annotations

import struct

from std_msgs.msg import UInt8MultiArray

from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.beacon import ENCAPSULATION

KIND = UInt8MultiArray
REPORT, ORDERS = "report", "orders"  # topics of a robot
CENTRE = "/central"  # node
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
