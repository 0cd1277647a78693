"""Positions of the numbers in a CDR message that begins with a stamp and some strings.

Strings may have any length, so where the numbers behind them begin has to be looked for; but they
are the same in all messages of a topic, and then all numbers are unpacked at once. Both byte
orders are read: CDR leaves the choice to the sender.
"""

from __future__ import annotations

import struct
from typing import Any

from swarm_common.middleware.rejections import RejectedError

HEAD = 4  # bytes of encapsulation; CDR aligns relative to the byte after it
STAMP = struct.Struct("<iI")
BIG_STAMP = struct.Struct(">iI")
LITTLE, BIG = "<", ">"
_ORDERS = {b"\x00\x01": LITTLE, b"\x00\x00": BIG}  # of plain CDR
MOST_SECONDS = 200_000_000  # [s] of simulated time, six years: ticks fit into 31 bits
SECOND = 1_000_000_000  # [ns]


def aligned(offset: int, size: int) -> int:
    """Return the next offset at which a CDR member of `size` bytes may start.

    Args:
        offset: [bytes] from the start of the message, encapsulation included.
        size: [bytes], a power of 2.
    """
    return HEAD + -(-(offset - HEAD) // size) * size


def after_string(data: bytes, offset: int, order: str = LITTLE) -> int:
    """Return the offset behind the CDR string that starts at `offset` (4-aligned)."""
    offset = aligned(offset, 4)
    size = int.from_bytes(data[offset : offset + 4], "little" if order == LITTLE else "big")
    end = offset + 4 + size
    if end > len(data):
        raise RejectedError(f"{len(data)} bytes end before a string of {size} at {offset} does")
    return end


def byte_order(data: bytes) -> str:
    """Return the byte order of a message as `struct` has it."""
    order = _ORDERS.get(data[:2])
    if order is None or len(data) < HEAD:
        raise RejectedError(f"{len(data)} bytes beginning with {data[:4].hex()} are not plain CDR")
    return order


def check_stamp(sec: int, nanosec: int) -> None:
    """Refuse a stamp that no simulated time has.

    Raises:
        RejectedError: Saying which it is.
    """
    if not (0 <= sec <= MOST_SECONDS and 0 <= nanosec < SECOND):
        raise RejectedError(f"the stamp is {sec} s and {nanosec} ns")


def read_stamp(data: bytes) -> tuple[int, int]:
    """Return (sec, nanosec) of a message that begins with a stamp."""
    order = byte_order(data)
    if len(data) < HEAD + STAMP.size:
        raise RejectedError(f"{len(data)} bytes have no stamp")
    sec, nanosec = (STAMP if order == LITTLE else BIG_STAMP).unpack_from(data, HEAD)
    check_stamp(sec, nanosec)
    return sec, nanosec


class Layout:
    """Layout of the messages of a topic: a stamp, strings, numbers."""

    def __init__(self, strings: int, alignment: int, numbers: str) -> None:
        """Start without a message.

        Args:
            alignment: [bytes] of the first number.
            numbers: Format of the numbers, as `struct` has it.
        """
        self._strings = strings
        self._alignment = alignment
        self._numbers = numbers
        self._head = b""
        self._texts = b""
        self._end = 0
        self._struct = STAMP

    def unpack(self, data: bytes) -> tuple[Any, ...]:
        """Return seconds and nanoseconds of the stamp, then the numbers."""
        if data[HEAD + STAMP.size : self._end] != self._texts or data[:2] != self._head:
            self._learn(data)
        try:
            values = self._struct.unpack_from(data, HEAD)
        except struct.error as error:
            raise RejectedError(f"{len(data)} bytes are too few: {error}") from None
        check_stamp(values[0], values[1])
        return values

    def _learn(self, data: bytes) -> None:
        order = byte_order(data)
        start = end = HEAD + STAMP.size
        for _ in range(self._strings):
            end = after_string(data, end, order)
        gap = aligned(end, self._alignment) - start
        self._struct = struct.Struct(f"{order}iI{gap}x{self._numbers}")
        self._head, self._texts, self._end = data[:2], data[start:end], end
