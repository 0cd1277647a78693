"""Numba kernel of the radio's door: which beacons say what no robot can mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.middleware.cdr_layout import MOST_SECONDS
from swarm_common.model.beacon import (
    FLAG_LEFT,
    FOOTPRINT_POINTS,
    HELD_POINTS,
    INTENT_POINTS,
    MODE_DONE,
    MOST_ID,
    NO_ROBOT,
    SIGHTED_ASKS,
    SIGHTINGS,
    WANTED_POINTS,
    word_of,
)
from swarm_common.model.records import TICK_NANOSECONDS
from swarm_common.process.numba_compat import njit

SOUND, BAD_ID, BAD_STAMP, BAD_SIZE, BAD_NUMBER, BAD_ORDER = range(6)
FAULTS = (
    "",
    "has an id that is not its sender's, or that no robot has",
    "has a stamp that is not its tick's, or is not of now",
    "has a size beyond its capacity, or an unknown mode",
    "has a number that is not finite or is out of range",
    "does not come in the order of ids",
)
MOST_COORDINATE = np.float32(1e6).view(np.uint32)  # [m]
MOST_RADIUS = np.float32(20.0).view(np.uint32)  # [m]
MOST_NUMBER = np.float32(1e3).view(np.uint32)  # [m/s], [rad/s], [rad]

ID, TICK, SEC, NANOSEC = word_of("id"), word_of("tick"), word_of("sec"), word_of("nanosec")
RADIUS, POSE = word_of("radius"), word_of("pose")  # with the twist behind it
FLAGS, MODE, SIZES = word_of("flags"), word_of("mode"), word_of("held_size")
HELD, WANTED, INTENT = word_of("held"), word_of("wanted"), word_of("intent")
FOOTPRINT, TARGET = word_of("footprint"), word_of("target")
SIGHTED_ID, SIGHTED_TICK, SIGHTED_AT = map(word_of, ("sighted_id", "sighted_tick", "sighted_at"))


@njit(cache=True)
def within(words: NDArray[np.uint32], start: int, count: int, limit_bits: np.uint32) -> bool:
    """Whether `count` floats from `start` on are finite and at most the limit in size.

    Without their sign the bits of floats are ordered as the floats are, NaN and infinity last;
    the largest of integers is found without a branch.

    Args:
        words: (words,) of a beacon.
        start: First of them.
        count: Number of them that count.
        limit_bits: The limit's bits.
    """
    largest = np.uint32(0)
    for k in range(start, start + count):
        largest = max(largest, words[k] & np.uint32(0x7FFFFFFF))
    return largest <= limit_bits


@njit(cache=True)
def fault(words: NDArray[np.uint32], now: int) -> int:
    """Return the fault of a beacon, SOUND if there is none; others are indices into `FAULTS`.

    No beacon is of a tick after `now`. One of a robot that was taken out holds nothing.

    Args:
        words: (words,)
        now: Tick.
    """
    tick = np.int64(words[TICK])
    if words[ID] == NO_ROBOT or words[ID] > MOST_ID:
        return BAD_ID
    stamp = tick * TICK_NANOSECONDS
    if tick > now or tick > MOST_SECONDS * 10 or words[SEC] != stamp // 1_000_000_000:
        return BAD_STAMP
    if words[NANOSEC] != stamp % 1_000_000_000:
        return BAD_STAMP
    held, wanted = np.int64(words[SIZES]), np.int64(words[SIZES + 1])
    intent, footprint = np.int64(words[SIZES + 2]), np.int64(words[SIZES + 3])
    is_left = (words[FLAGS] & FLAG_LEFT) != 0
    if held > HELD_POINTS or wanted > WANTED_POINTS or (held < 1 and not is_left):
        return BAD_SIZE
    if intent > INTENT_POINTS or footprint > FOOTPRINT_POINTS or words[MODE] > MODE_DONE:
        return BAD_SIZE
    if words[RADIUS] > MOST_RADIUS:  # as bits, also a negative one is
        return BAD_NUMBER
    if not within(words, POSE, 2, MOST_COORDINATE) or not within(words, POSE + 2, 3, MOST_NUMBER):
        return BAD_NUMBER
    for k in range(TARGET, TARGET + 4):  # target and station; NaN for none
        if np.uint32(0x7F800000) >= words[k] & np.uint32(0x7FFFFFFF) > MOST_COORDINATE:
            return BAD_NUMBER
    for k in range(SIGHTINGS):
        if words[SIGHTED_ID + k] >= 2 * SIGHTED_ASKS:
            return BAD_ID
        if words[SIGHTED_TICK + k] > now:
            return BAD_STAMP
    if not within(words, SIGHTED_AT, 2 * SIGHTINGS, MOST_COORDINATE):
        return BAD_NUMBER
    if within(words, HELD, FOOTPRINT - HELD, MOST_COORDINATE) and within(
        words, FOOTPRINT, 2 * FOOTPRINT_POINTS, MOST_RADIUS
    ):
        return SOUND  # nearly always; this includes the points beyond the sizes
    is_sound = (
        within(words, HELD, 2 * held, MOST_COORDINATE)
        and within(words, WANTED, 2 * wanted, MOST_COORDINATE)
        and within(words, INTENT, 2 * intent, MOST_COORDINATE)
        and within(words, FOOTPRINT, 2 * footprint, MOST_RADIUS)
    )
    return SOUND if is_sound else BAD_NUMBER


@njit(cache=True)
def sift(words: NDArray[np.uint32], now: int, own_id: int) -> tuple[int, int]:
    """Move the sound beacons of a batch to its front.

    Their ids ascend, and none is the receiver's own.

    Args:
        words: (n, words); changed.
        now: Tick.
        own_id: Id of the receiver.

    Returns:
        The last fault found, and how many beacons are sound.
    """
    count, last_fault = 0, SOUND
    last = np.int64(NO_ROBOT)
    for row in range(words.shape[0]):
        found = fault(words[row], now)
        own = np.int64(words[row, ID])
        if found == SOUND and own == own_id:
            found = BAD_ID
        elif found == SOUND and own <= last:
            found = BAD_ORDER
        if found != SOUND:
            last_fault = found
            continue
        last = own
        if count != row:
            words[count] = words[row]
        count += 1
    return last_fault, count
