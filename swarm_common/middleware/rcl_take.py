"""Receives serialized messages from rcl itself, which says who sent them; rclpy leaves that out.

https://docs.ros.org/en/jazzy/p/rcl: `rcl_take_serialized_message`, `rmw_message_info_t`. The
structures below are those of Jazzy, which no patch release may change.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Sequence
from typing import Any

Sender = tuple[int, int]  # the two halves of a publisher's id (GID)
NOBODY: Sender = (0, 0)
RET_OK, RET_NOTHING = 0, 401  # RCL_RET_SUBSCRIPTION_TAKE_FAILED
FIRST_CAPACITY = 4096  # bytes; it grows with the messages
GID_SIZE = 16


class _Allocator(ctypes.Structure):
    _fields_ = tuple(
        (name, ctypes.c_void_p)
        for name in ("allocate", "deallocate", "reallocate", "zero_allocate", "state")
    )


class _Bytes(ctypes.Structure):
    """rcutils_uint8_array_t."""

    _fields_ = (
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", _Allocator),
    )


class _Info(ctypes.Structure):
    """rmw_message_info_t."""

    _fields_ = (
        ("source_timestamp", ctypes.c_int64),
        ("received_timestamp", ctypes.c_int64),
        ("publication_sequence_number", ctypes.c_uint64),
        ("reception_sequence_number", ctypes.c_uint64),
        ("implementation", ctypes.c_char_p),
        ("low", ctypes.c_uint64),
        ("high", ctypes.c_uint64),
        ("is_from_intra_process", ctypes.c_bool),
    )


@functools.cache
def libraries() -> tuple[Any, Any]:
    """Return rcl and rcutils, with the types of what we call."""
    rcl, rcutils = ctypes.CDLL("librcl.so"), ctypes.CDLL("librcutils.so")
    rcl.rcl_take_serialized_message.argtypes = (ctypes.c_void_p,) * 4
    rcl.rcl_wait_set_add_guard_condition.argtypes = (ctypes.c_void_p,) * 3
    rcl.rcl_node_get_graph_guard_condition.argtypes = (ctypes.c_void_p,)
    rcl.rcl_node_get_graph_guard_condition.restype = ctypes.c_void_p
    rcutils.rcutils_get_default_allocator.restype = _Allocator
    rcutils.rcutils_get_zero_initialized_uint8_array.restype = _Bytes
    return rcl, rcutils


def sender_of(gid: Sequence[int]) -> Sender:
    """Return a publisher's id from the bytes that the graph lists."""
    raw = bytes(gid)[:GID_SIZE].ljust(GID_SIZE, b"\x00")
    return int.from_bytes(raw[:8], "little"), int.from_bytes(raw[8:], "little")


class Taker:
    """Receives messages into a buffer of its own.

    Attributes:
        sender: Sender of the latest message.
        received: [ns] of wall time at which that message came.
        sequence: Number of that message among those of its sender on the topic.
    """

    def __init__(self) -> None:
        rcl, rcutils = libraries()
        self.sender = NOBODY
        self.received = 0
        self.sequence = 0
        self._take = rcl.rcl_take_serialized_message
        self._rcutils = rcutils
        self._bytes = rcutils.rcutils_get_zero_initialized_uint8_array()
        self._info = _Info()
        allocator = rcutils.rcutils_get_default_allocator()
        size = ctypes.c_size_t(FIRST_CAPACITY)
        failure = rcutils.rcutils_uint8_array_init(
            ctypes.byref(self._bytes), size, ctypes.byref(allocator)
        )
        if failure:
            raise MemoryError(f"rcutils_uint8_array_init returned {failure}")
        self._places = ctypes.addressof(self._bytes), ctypes.addressof(self._info)

    def take(self, subscription: int) -> bytes | None:
        """Return the oldest message that waits, None if there is none that can be taken."""
        data, info = self._places
        result = self._take(subscription, data, info, None)
        if result != RET_OK:
            if result != RET_NOTHING:
                self._rcutils.rcutils_reset_error()
            return None
        values = self._info
        self.sender = values.low, values.high
        self.received = values.received_timestamp
        self.sequence = values.publication_sequence_number
        return ctypes.string_at(self._bytes.buffer, self._bytes.length)

    def __del__(self) -> None:
        self._rcutils.rcutils_uint8_array_fini(ctypes.byref(self._bytes))
