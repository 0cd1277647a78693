"""Beacons for a host in one message: what comes out is what each robot would have been sent."""

import numpy as np
import pytest

from swarm_common.middleware.beacon_batch import BatchReader, BatchWriter
from swarm_common.middleware.sealed import ForgedError
from swarm_common.model.beacon import (
    BEACON_DTYPE,
    BEACON_WORDS,
    Reception,
    serialize_neighbors,
    words_of,
)

SECRET = "a secret of this swarm"


def receptions(robots, share, seed=0):
    """Return who hears whom, with beacons that use some of their points."""
    random = np.random.default_rng(seed)
    beacons = np.zeros(robots, BEACON_DTYPE)
    beacons["id"] = np.arange(1, robots + 1)
    beacons["held"][:, :6] = random.normal(size=(robots, 6, 2))
    words = words_of(beacons)
    heard = random.random((robots, robots)) < share
    return {n + 1: Reception(words, np.flatnonzero(heard[n])) for n in range(robots)}


def message(robots, reader=None):
    return BatchWriter(SECRET, "run", "host").encode(3, 400, robots)


@pytest.mark.parametrize(("robots", "share"), [(1, 0.0), (1, 1.0), (10, 0.3), (20, 1.0), (60, 0.7)])
def test_every_robot_gets_the_message_of_one_host_byte_for_byte(robots, share):
    heard = receptions(robots, share)
    parts = dict(BatchReader(SECRET, "run", "host").decode(message(heard)))
    assert parts == {n: serialize_neighbors(3, 400, each.beacons) for n, each in heard.items()}


def test_a_beacon_crosses_the_network_once():
    """At 20 robots that all hear each other: 19 times as much, before."""
    robots = receptions(20, 1.0)
    alone = sum(len(serialize_neighbors(0, 0, each.beacons)) for each in robots.values())
    assert len(message(robots)) < alone / 20
    assert len(message(robots)) < 20 * BEACON_WORDS * 4


def test_only_what_was_sealed_for_this_host_in_this_run_and_once():
    data = message(receptions(3, 1.0))
    reader = BatchReader(SECRET, "run", "host")
    assert len(reader.decode(data)) == 3
    assert reader.decode(data) == []
    for other in (
        ("another secret", "run", "host"),
        (SECRET, "run 2", "host"),
        (SECRET, "run", "h"),
    ):
        with pytest.raises(ForgedError):
            BatchReader(*other).decode(data)


def test_no_byte_can_be_changed_or_left_out():
    data = message(receptions(2, 1.0))
    for at in range(16, len(data), 7):
        changed = bytearray(data)
        changed[at] ^= 1
        with pytest.raises(ForgedError):
            BatchReader(SECRET, "run", "host").decode(bytes(changed))
    for size in (0, 3, 15, 16, 47, 48, 60, len(data) - 1):
        with pytest.raises(ForgedError):
            BatchReader(SECRET, "run", "host").decode(data[:size])
