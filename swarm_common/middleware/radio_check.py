"""The door of the radio: bytes of `beacon` and `neighbors`, checked before a kernel reads them.

What kernels read has sizes within its capacity and finite numbers; they check nothing themselves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.middleware.beacon_kernels import FAULTS, SOUND, fault, sift
from swarm_common.middleware.cdr_layout import BIG, HEAD, LITTLE, byte_order, check_stamp
from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.beacon import (
    BEACON_DTYPE,
    BEACON_SIZE,
    BEACON_WORDS,
    BeaconArray,
    record_of,
    word_of,
)
from swarm_common.model.records import tick_from_stamp

_WORDS = {LITTLE: np.dtype("<u4"), BIG: np.dtype(">u4")}
_ID = word_of("id")
BATCH_HEAD = 3  # words: stamp and count
BATCH_BYTES = 4 * BATCH_HEAD


def read_beacon(data: bytes, robot_id: int, now: int) -> np.void:
    """Return the beacon in a CDR message of one robot.

    Args:
        robot_id: Id that the beacon must have; 0 accepts any.
        now: Tick after which no beacon can be.
    """
    words = _words(data)
    if len(words) != BEACON_WORDS:
        raise RejectedError(f"{len(data)} bytes; a beacon has {HEAD + BEACON_SIZE}")
    found = fault(words, now)
    if found != SOUND:
        raise RejectedError(f"the beacon {FAULTS[found]}")
    if robot_id and words[_ID] != robot_id:
        raise RejectedError(f"the beacon has the id {words[_ID]}; its sender's is {robot_id}")
    return record_of(words)


def read_neighbors(data: bytes, own_id: int) -> tuple[int, BeaconArray, str]:
    """Return the sound beacons of a NeighborArray message.

    Args:
        own_id: Id of the receiver, which does not hear itself.

    Returns:
        The tick, the beacons (n,) ascending by id, writable; why others were left out, or nothing.
    """
    words = _words(data)
    if len(words) < BATCH_HEAD:
        raise RejectedError(f"{len(data)} bytes; a batch has at least {HEAD + BATCH_BYTES}")
    sec, nanosec, count = words[:BATCH_HEAD].tolist()
    check_stamp(sec, nanosec)
    if count * BEACON_WORDS > len(words) - BATCH_HEAD:
        raise RejectedError(f"{len(data)} bytes are too few for {count} beacons")
    tick = tick_from_stamp(sec, nanosec)
    sound, reason = count, ""
    if count:
        rows: NDArray[np.uint32] = np.ndarray((count, BEACON_WORDS), np.uint32, words, BATCH_BYTES)
        found, sound = sift(rows, tick, own_id)
        if found != SOUND:
            reason = f"{count - sound} of {count} beacons: one {FAULTS[found]}"
    beacons: BeaconArray = np.ndarray((sound,), BEACON_DTYPE, words, BATCH_BYTES)
    return tick, beacons, reason


def _words(data: bytes) -> NDArray[np.uint32]:
    """Return the whole words behind the head, as a copy of our own byte order.

    A view would be read-only, for which numba would compile every kernel once more.
    """
    kind = _WORDS[byte_order(data)]
    return np.frombuffer(data, kind, (len(data) - HEAD) // 4, HEAD).astype(np.uint32)
