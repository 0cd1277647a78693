"""Where the numbers of a CDR message are that begins with a stamp and some strings.

Strings may have any length, so where the numbers behind them begin has to be looked for; but they
are the same in all messages of a topic, and then all numbers are unpacked at once.
"""

from __future__ import annotations

import struct
from typing import Any

HEAD = 4  # bytes of encapsulation; CDR aligns relative to the byte after it
STAMP = struct.Struct("<iI")


def aligned(offset: int, size: int) -> int:
    """Return the next offset at which a CDR member of `size` bytes may start."""
    return HEAD + -(-(offset - HEAD) // size) * size


def after_string(data: bytes, offset: int) -> int:
    """Return the offset behind the CDR string that starts at `offset` (4-aligned)."""
    offset = aligned(offset, 4)
    return offset + 4 + int.from_bytes(data[offset : offset + 4], "little")


def check_little_endian(data: bytes) -> None:
    """Raise ValueError unless the message is plain CDR of little endian order."""
    if len(data) < HEAD + STAMP.size or data[1] != 1:
        raise ValueError("message is not little-endian CDR")


class Layout:
    """Of the messages of a topic: a stamp, strings, numbers."""

    def __init__(self, strings: int, alignment: int, numbers: str) -> None:
        """Know no message yet.

        Args:
            strings: How many.
            alignment: [bytes] of the first number.
            numbers: Format of the numbers, as `struct` has it.
        """
        self._strings = strings
        self._alignment = alignment
        self._numbers = numbers
        self._texts = b""
        self._end = 0
        self._struct = STAMP

    def unpack(self, data: bytes) -> tuple[Any, ...]:
        """Return seconds and nanoseconds of the stamp, then the numbers.

        Raises:
            ValueError: If the message is not plain CDR of little endian order.
        """
        if data[HEAD + STAMP.size : self._end] != self._texts or not self._texts or data[1] != 1:
            self._learn(data)
        return self._struct.unpack_from(data, HEAD)

    def _learn(self, data: bytes) -> None:
        check_little_endian(data)
        start = end = HEAD + STAMP.size
        for _ in range(self._strings):
            end = after_string(data, end)
        gap = aligned(end, self._alignment) - start
        self._texts, self._end = data[start:end], end
        self._struct = struct.Struct(f"<iI{gap}x{self._numbers}")
