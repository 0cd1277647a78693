"""The radio message: `Beacon` as a numpy record whose bytes are its CDR body.

Every member of swarm_interfaces/Beacon is 4 bytes wide or a fixed array of such members, so that
the CDR encoding has no padding and a fixed size. Beacons can therefore be joined to a
NeighborArray, and taken apart again, by copying bytes;
`tests/graph/middleware/test_beacon_codec.py` checks the claim against the ROS serialiser.
"""

from __future__ import annotations

import functools
import math
import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import value_type

HELD_POINTS = 24  # capacity of the held tube's polyline
WANTED_POINTS = 8  # capacity of the requested continuation
INTENT_POINTS = 31  # capacity of the announced path
FOOTPRINT_POINTS = 16
HEARD_ENTRIES = 48  # robots whose beacons can be acknowledged at a time
SIGHTINGS = 2  # robots of which a beacon tells where they were last
SIGHTED_ASKS = 1 << 16  # in `sighted_id`: the robot had asked for a station
NO_ROBOT = 0  # ids start at 1
MOST_ID = 0xFFFF  # an acknowledgement has 16 bits for it

# PAUSE: served at a station, makes way for nobody
MODE_DRIVE, MODE_HOLD, MODE_YIELD, MODE_PAUSE, MODE_DONE = range(5)
FLAG_STUCK = 1
FLAG_ACTIVE = 2  # the navigator is active (lifecycle)
FLAG_CIRCUIT = 4  # driving the holding circuit
FLAG_DEAF = 8  # stands because it hears nothing; it listens again before it claims space
FLAG_LEFT = 16  # was taken out of the world, says the radio: it holds nothing, forget it
FLAG_SPLIT = 32  # stands because several robots near it fell silent at once

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
        ("sighted_id", "<u4", (SIGHTINGS,)),
        ("sighted_tick", "<u4", (SIGHTINGS,)),
        ("sighted_at", "<f4", (SIGHTINGS, 2)),
    ]
)
BEACON_SIZE = BEACON_DTYPE.itemsize
BEACON_WORDS = BEACON_SIZE // 4
ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little endian

BeaconArray = NDArray[np.void]  # shape (n,), dtype BEACON_DTYPE


def _head_struct() -> struct.Struct:
    """Return the layout of the members before the points."""
    names = BEACON_DTYPE.names or ()
    codes = []
    for name in names[: names.index("held")]:
        member, length = BEACON_DTYPE[name].base, math.prod(BEACON_DTYPE[name].shape)
        codes.append(f"{length}{'f' if member.kind == 'f' else 'iI'[member.kind == 'u']}")
    return struct.Struct("<" + "".join(codes))


_HEAD = _head_struct()


def pack_head(words: NDArray[np.uint32], head: Sequence[float]) -> None:
    """Fill in the members before `held`, in their order, vectors one number after the other.

    Args:
        words: (BEACON_WORDS,) of one beacon, written.
        head: The numbers, of the kind that each member has: whole ones for integers.
    """
    _HEAD.pack_into(words.data, 0, *head)


@functools.lru_cache(maxsize=16)
def blank_beacon(footprint: tuple[tuple[float, float], ...]) -> NDArray[np.uint32]:
    """Return the words of a beacon with nothing but a footprint, to be copied.

    Args:
        footprint: Corners (x, y) [m] in base_footprint; those beyond `FOOTPRINT_POINTS` are left
            out.

    Returns:
        (BEACON_WORDS,), the same array at each call with that footprint.
    """
    words = np.zeros(BEACON_WORDS, np.uint32)
    count = min(len(footprint), FOOTPRINT_POINTS)
    record_of(words)["footprint"][:count] = footprint[:count]
    return words


def record_of(words: NDArray[np.uint32]) -> np.void:
    """Return the beacon that lies in some words, without a copy.

    Args:
        words: (BEACON_WORDS,), contiguous; what is written to the record is written there.
    """
    record: np.void = np.frombuffer(words, BEACON_DTYPE)[0]
    return record


def empty_beacons(count: int) -> BeaconArray:
    """Return zeroed beacons."""
    return np.zeros(count, BEACON_DTYPE)


def word_of(member: str) -> int:
    """Return the index of a member's first 4-byte word, for kernels that read beacons as words."""
    assert BEACON_DTYPE.fields is not None
    return int(BEACON_DTYPE.fields[member][1]) // 4


def words_of(beacons: BeaconArray) -> NDArray[np.uint32]:
    """Return beacons as words (n, BEACON_WORDS), writable and aligned; a view if the beacons are.

    numpy copies records member by member; words it copies at once.

    Args:
        beacons: (n,).
    """
    words = np.ndarray((len(beacons), BEACON_WORDS), np.uint32, np.ascontiguousarray(beacons))
    is_fit = words.flags.writeable and words.flags.aligned
    return words if is_fit else words.copy()


@value_type
class Reception:
    """The beacons that one robot hears at a tick: rows of an array that all robots share."""

    words: NDArray[np.uint32]  # (s, BEACON_WORDS) beacons as words
    rows: NDArray[np.int64]  # (k,) those heard, ascending by id

    @property
    def beacons(self) -> BeaconArray:
        """The beacons heard (k,), copied."""
        return self.words[self.rows].view(BEACON_DTYPE)[:, 0]


def reception_of(beacons: BeaconArray) -> Reception:
    """Return the reception of all of some beacons, of which it may be a view."""
    return Reception(words_of(beacons), np.arange(len(beacons)))


def serialize_beacon(beacon: np.void) -> bytes:
    """Return the CDR message of one beacon, ready for `publisher.publish`."""
    return ENCAPSULATION + beacon.tobytes()


def deserialize_beacon(data: bytes) -> np.void:
    """Return the beacon in a CDR message, without sightings if it was recorded before these were.

    Args:
        data: Message, little endian; bytes behind the beacon are ignored.

    Raises:
        ValueError: If the message is too short.
    """
    least = 4 + 4 * word_of("sighted_id")
    if len(data) < least:
        raise ValueError(f"beacon message of {len(data)} bytes; expected {4 + BEACON_SIZE}")
    body = data[4 : 4 + BEACON_SIZE].ljust(BEACON_SIZE, b"\0")
    beacon: np.void = np.frombuffer(body, BEACON_DTYPE, 1)[0]
    return beacon


def serialize_neighbors(sec: int, nanosec: int, beacons: BeaconArray) -> bytes:
    """Return the CDR message of a NeighborArray."""
    head = np.array([sec, nanosec, len(beacons)], "<u4")
    return ENCAPSULATION + head.tobytes() + beacons.tobytes()
