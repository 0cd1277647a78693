"""The radio: who hears whose beacon at a tick, with range, loss and delay.

Whether a message is lost depends only on (seed, tick, sender, receiver), so that no order of
arrival and no other random number can change it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.beacon import BEACON_DTYPE, BEACON_SIZE, BeaconArray
from swarm_common.errors import ConfigError
from swarm_common.records import CONTROL_PERIOD
from swarm_sim.randomness import hash_words, uniform

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioConfig:
    """Quality of the radio; `radio:` of the world."""

    range: float = 6.0  # [m] between the centres of two robots
    loss: float = 0.0  # share of the messages that are lost, each receiver on its own
    delay: float = 0.0  # [s] in addition to the one tick that a beacon always takes

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        if not self.range > 0.0:
            raise ConfigError(f"radio.range is {self.range} m; it must be positive")
        if not 0.0 <= self.loss <= 1.0:
            raise ConfigError(f"radio.loss is {self.loss}; it must lie between 0 and 1")
        if not 0.0 <= self.delay < math.inf:
            raise ConfigError(f"radio.delay is {self.delay} s; it must not be negative")


class Radio:
    """Keeps the beacons under way and says who hears what."""

    def __init__(self, config: RadioConfig, count: int, seed: int) -> None:
        """Start with silence.

        Args:
            config: Quality.
            count: Number of robots.
            seed: Of the losses.
        """
        self._config = config
        self._count = count
        self._seed = seed
        delay_ticks = math.ceil(config.delay / CONTROL_PERIOD - 1e-9)
        silence = (np.zeros((0, BEACON_SIZE), np.uint8), np.zeros((count, 0), np.bool_))
        self._under_way: deque[tuple[NDArray[np.uint8], NDArray[np.bool_]]] = deque(
            [silence] * (delay_ticks + 1)
        )

    def send(self, tick: int, beacons: Sequence[np.void | None], positions: FloatArray) -> None:
        """Take the beacons that robots send at a tick; ends the tick.

        Args:
            tick: Tick at which they are sent.
            beacons: One per robot; None from a robot that sends nothing.
            positions: True positions (n, 2) at that tick.
        """
        senders = np.array([i for i, b in enumerate(beacons) if b is not None], np.int64)
        joined = b"".join([b.tobytes() for b in beacons if b is not None])
        order = np.argsort(np.frombuffer(joined, BEACON_DTYPE)["id"], kind="stable")
        # As plain bytes: numpy copies records of many members member by member.
        sent = np.frombuffer(joined, np.uint8).reshape(len(senders), BEACON_SIZE)[order]
        senders = senders[order]
        gap = positions[:, None, :] - positions[None, senders, :]
        heard = np.hypot(gap[..., 0], gap[..., 1]) <= self._config.range
        heard[senders, np.arange(len(senders))] = False
        if self._config.loss > 0.0:
            receivers = np.arange(self._count)[:, None]
            words = hash_words(self._seed, tick, senders[None, :], receivers)
            heard &= uniform(words) >= self._config.loss
        self._under_way.popleft()
        self._under_way.append((sent, heard))

    def heard(self, receiver: int) -> BeaconArray:
        """Return the beacons that reach a robot at the present tick, ordered by id."""
        sent, heard = self._under_way[0]
        received: BeaconArray = sent[heard[receiver]].reshape(-1).view(BEACON_DTYPE)
        return received
