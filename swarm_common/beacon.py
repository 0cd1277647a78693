"""The radio message: `Beacon` as a numpy record whose bytes are its CDR body.

Every member of swarm_interfaces/Beacon is 4 bytes wide or a fixed array of such members, so that
the CDR encoding has no padding and a fixed size. Beacons can therefore be joined to a
NeighborArray, and taken apart again, by copying bytes; `tests/graph/test_beacon_codec.py` checks
the claim against the ROS serialiser.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

HELD_POINTS = 24  # capacity of the held tube's polyline
WANTED_POINTS = 8  # capacity of the requested continuation
INTENT_POINTS = 31  # capacity of the announced path
FOOTPRINT_POINTS = 8
HEARD_ENTRIES = 24  # robots whose beacons can be acknowledged at a time
NO_ROBOT = 0  # ids start at 1

MODE_DRIVE, MODE_HOLD, MODE_YIELD, MODE_PAUSE, MODE_DONE = range(5)
FLAG_STUCK = 1
FLAG_ACTIVE = 2  # the navigator is active (lifecycle)
FLAG_CIRCUIT = 4  # driving the holding circuit
FLAG_DEAF = 8  # stands because it hears nothing; listens anew before it claims again

BEACON_DTYPE = np.dtype(
    [
        ("sec", "<i4"),
        ("nanosec", "<u4"),
        ("id", "<u4"),
        ("tick", "<u4"),
        ("radius", "<f4"),
        ("pose", "<f4", (3,)),
        ("twist", "<f4", (2,)),
        ("priority", "<u4", (2,)),
        ("blocked_ticks", "<u4"),
        ("blocked_by", "<u4"),
        ("yields_for", "<u4"),
        ("flags", "<u4"),
        ("mode", "<u4"),
        ("target", "<f4", (2,)),
        ("station", "<f4", (2,)),
        ("station_tick", "<u4"),
        ("gate_tick", "<u4"),
        ("held_size", "<u4"),
        ("wanted_size", "<u4"),
        ("intent_size", "<u4"),
        ("footprint_size", "<u4"),
        ("held", "<f4", (HELD_POINTS, 2)),
        ("wanted", "<f4", (WANTED_POINTS, 2)),
        ("intent", "<f4", (INTENT_POINTS, 2)),
        ("footprint", "<f4", (FOOTPRINT_POINTS, 2)),
        ("heard", "<u4", (HEARD_ENTRIES,)),
    ]
)
BEACON_SIZE = BEACON_DTYPE.itemsize
BEACON_WORDS = BEACON_SIZE // 4
POINTS = ("held", "wanted", "intent", "footprint")  # members that have a size in front

ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little endian

BeaconArray = NDArray[np.void]  # shape (n,), dtype BEACON_DTYPE


def _head_struct() -> struct.Struct:
    """Return the layout of the members before the points."""
    names = BEACON_DTYPE.names or ()
    codes = []
    for name in names[: names.index(POINTS[0])]:
        member, length = BEACON_DTYPE[name].base, math.prod(BEACON_DTYPE[name].shape)
        codes.append(f"{length}{'f' if member.kind == 'f' else 'iI'[member.kind == 'u']}")
    return struct.Struct("<" + "".join(codes))


_HEAD = _head_struct()


def make_beacon(head: Sequence[float], points: Sequence[NDArray[np.floating]]) -> np.void:
    """Return a beacon on memory of its own.

    Args:
        head: The members before `held_size` in their order, vectors one number after the other.
        points: What goes into the members `POINTS` (k, 2); what exceeds a capacity is left out.
    """
    words = np.zeros(BEACON_WORDS, np.uint32)
    beacon: np.void = np.ndarray((1,), BEACON_DTYPE, words)[0]
    sizes = []
    for name, block in zip(POINTS, points, strict=True):
        room = beacon[name]
        size = min(len(block), len(room))
        room[:size] = block[:size]
        sizes.append(size)
    _HEAD.pack_into(words.data, 0, *head, *sizes)
    return beacon


def empty_beacons(count: int) -> BeaconArray:
    """Return `count` zeroed beacons."""
    return np.zeros(count, BEACON_DTYPE)


def word_of(member: str) -> int:
    """Return the index of a member's first 4-byte word, for kernels that read beacons as words."""
    assert BEACON_DTYPE.fields is not None
    return int(BEACON_DTYPE.fields[member][1]) // 4


def words_of(beacons: BeaconArray) -> NDArray[np.uint32]:
    """Return a copy of beacons as words (n, BEACON_WORDS).

    numpy copies records member by member; words it copies at once. The copy is writable and
    aligned whatever buffer the beacons came in.
    """
    words = np.ascontiguousarray(beacons).view(np.uint32)
    return np.array(words).reshape(len(beacons), BEACON_WORDS)


def serialize_beacon(beacon: np.void) -> bytes:
    """Return the CDR message of one beacon, ready for `publisher.publish`."""
    return ENCAPSULATION + beacon.tobytes()


def deserialize_beacon(data: bytes) -> np.void:
    """Return the beacon in a CDR message.

    Raises:
        ValueError: If the message does not have a beacon's size.
    """
    if len(data) < 4 + BEACON_SIZE:
        raise ValueError(f"beacon message of {len(data)} bytes; expected {4 + BEACON_SIZE}")
    beacon: np.void = np.frombuffer(data, BEACON_DTYPE, 1, 4)[0]
    return beacon


def serialize_neighbors(sec: int, nanosec: int, beacons: BeaconArray) -> bytes:
    """Return the CDR message of a NeighborArray."""
    head = np.array([sec, nanosec, len(beacons)], "<u4")
    return ENCAPSULATION + head.tobytes() + beacons.tobytes()


def deserialize_neighbors(data: bytes) -> tuple[int, int, BeaconArray]:
    """Return (sec, nanosec, beacons) of a NeighborArray message; the beacons are a view.

    Raises:
        ValueError: If the message is shorter than its own count says.
    """
    if len(data) < 16:
        raise ValueError(f"neighbour message of {len(data)} bytes; expected at least 16")
    sec, nanosec, count = np.frombuffer(data, "<u4", 3, 4)
    if len(data) < 16 + int(count) * BEACON_SIZE:
        raise ValueError(f"neighbour message of {len(data)} bytes is too short for {count} beacons")
    return int(sec), int(nanosec), np.frombuffer(data, BEACON_DTYPE, int(count), 16)
