"""Numba kernels of the radio: which robots hear each other, and the beacons each receives."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, IntArray
from swarm_common.process.numba_compat import njit


@njit(cache=True)
def mixed(word: np.uint64, part: np.uint64) -> np.uint64:
    """Return the word with one more coordinate in it, as `randomness.hash_words` chains them.

    Args:
        word: 64 bits.
        part: The coordinate.
    """
    word += np.uint64(0x9E3779B97F4A7C15) + part
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


@njit(cache=True)
def draw(prefix: tuple[int, int, int], words: NDArray[np.uint64]) -> None:
    """Write a random word for each place (n, k): `hash_words` of the prefix, row and column.

    Args:
        prefix: Coordinates before row and column.
        words: (n, k) receives the words.
    """
    head = np.uint64(0)
    for part in prefix:
        head = mixed(head, np.uint64(part))
    for row in range(words.shape[0]):
        word = mixed(head, np.uint64(row))
        for column in range(words.shape[1]):
            words[row, column] = mixed(word, np.uint64(column))


@njit(cache=True)
def listen(
    positions: FloatArray,
    senders: IntArray,
    reach: float,
    loss: float,
    seed: int,
    tick: int,
    heard: NDArray[np.bool_],
) -> int:
    """Write which receiver (row) hears which sender (column); return how many messages arrive.

    Args:
        positions: True positions (n, 2) of all robots.
        senders: (s,) indices of the robots that send.
        reach: [m]
        loss: Share of the messages that are lost.
        seed: Seed of the losses.
        tick: At which they are sent.
        heard: (n, s)
    """
    head = mixed(mixed(np.uint64(0), np.uint64(seed)), np.uint64(tick))
    count = 0
    for column in range(senders.shape[0]):
        sender = senders[column]
        word = mixed(head, np.uint64(sender))
        for receiver in range(positions.shape[0]):
            dx = positions[receiver, 0] - positions[sender, 0]
            dy = positions[receiver, 1] - positions[sender, 1]
            arrives = receiver != sender and math.hypot(dx, dy) <= reach
            if arrives and loss > 0.0:
                drawn = mixed(word, np.uint64(receiver)) >> np.uint64(11)
                arrives = float(drawn) * 2.0**-53 >= loss
            heard[receiver, column] = arrives
            count += arrives
    return count


@njit(cache=True)
def rows_heard(heard: NDArray[np.bool_], starts: IntArray, rows: IntArray) -> None:
    """List the beacons that each receiver hears, one receiver after the other.

    Args:
        heard: (n, s) true where receiver n hears sender s.
        starts: (n + 1,) receives where each one's list begins.
        rows: (messages,) receives the senders' columns.
    """
    count = 0
    for receiver in range(heard.shape[0]):
        starts[receiver] = count
        for column in range(heard.shape[1]):
            if heard[receiver, column]:
                rows[count] = column
                count += 1
    starts[heard.shape[0]] = count
