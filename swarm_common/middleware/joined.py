"""Several messages in one, between a world and a navigator that nobody else listens to.

A message costs as much as a small decision, whatever its size. So the messages of a tick travel
behind the bytes of one of them: CDR readers ignore what follows a message, so that one stays what
its topic says. A mark at the very end says that the sender understands such messages.
"""

from __future__ import annotations

import struct

from rclpy.publisher import Publisher

from swarm_common.middleware.rejections import RejectedError

MARK = b"swarm\x00\xff\x01"
_SIZE = struct.Struct("<I")
_END = _SIZE.size + len(MARK)  # bytes behind the sizes: how many there are, and the mark
MOST = 4  # messages behind the first


def join(first: bytes, *others: bytes) -> bytes:
    """Return a message with others behind it, and the mark."""
    sizes = struct.pack(f"<{len(others) + 1}I", *map(len, others), len(others))
    return b"".join((first, *others, sizes, MARK))


def split(data: bytes) -> list[bytes] | None:
    """Return the messages that were joined, None if a message has no mark.

    Raises:
        RejectedError: If the sizes behind them make no sense.
    """
    if not data.endswith(MARK):
        return None
    start = len(data) - _END
    count = _SIZE.unpack_from(data, start)[0] if start >= 0 else MOST + 1
    start -= _SIZE.size * min(count, MOST + 1)
    if count > MOST or start < 0:
        raise RejectedError(f"{len(data)} bytes cannot be {count + 1} messages")
    sizes = struct.unpack_from(f"<{count}I", data, start)
    at = start - sum(sizes)
    if at < 0:
        raise RejectedError(f"{len(data)} bytes cannot hold messages of {sizes} bytes")
    parts = [data[:at]]
    for size in sizes:
        parts.append(data[at : at + size])
        at += size
    return parts


def has_one_listener(*publishers: Publisher) -> bool:
    """Whether each topic has exactly one subscription."""
    return all(publisher.get_subscription_count() == 1 for publisher in publishers)
