"""The radio of orders: loses and delays messages as the world's radio does beacons.

It reaches the whole hall. Whether a message is lost depends on seed, tick, sender, receiver and
number of the message only.
"""

from __future__ import annotations

import math
import zlib
from collections import defaultdict
from collections.abc import Iterable, Sequence

from swarm_common.model.records import CONTROL_PERIOD
from swarm_mission.orders.messages import AnyMessage, Envelope

WORD = 2**64 - 1


class OrderRadio:
    """Keeps the messages in transit."""

    def __init__(
        self, loss: float = 0.0, delay: float = 0.0, seed: int = 0, *, senders: Sequence[str] = ()
    ) -> None:
        """Begin with nothing in transit.

        Args:
            loss: Share of the messages that are lost, each receiver on its own.
            delay: [s] in addition to the one tick that a message always takes.
            senders: In the order in which their messages of a tick count; those that are not
                named follow, in the order in which they send.
        """
        self._loss, self._seed = loss, seed
        self._delay_ticks = 1 + math.ceil(delay / CONTROL_PERIOD - 1e-9)
        self._ranks = {name: rank for rank, name in enumerate(senders)}
        self._transit: dict[int, list[Envelope]] = defaultdict(list)  # by tick of the sending

    def send(self, tick: int, envelopes: Iterable[Envelope]) -> None:
        """Send messages at a tick; the order of the senders' calls does not matter."""
        self._transit[tick] += envelopes

    def receive(self, tick: int, receivers: Sequence[str]) -> dict[str, list[AnyMessage]]:
        """Return what has arrived until a tick, by receiver; whatever nobody hears is gone."""
        heard: dict[str, list[AnyMessage]] = defaultdict(list)
        for sent in sorted(sent for sent in self._transit if sent + self._delay_ticks <= tick):
            envelopes = sorted(self._transit.pop(sent), key=self._rank)
            for number, envelope in enumerate(envelopes):
                for name in (envelope.receiver,) if envelope.receiver else receivers:
                    if name != envelope.sender and not self._is_lost(sent, number, envelope, name):
                        heard[name].append(envelope.message)
        return heard

    def _rank(self, envelope: Envelope) -> int:
        return self._ranks.get(envelope.sender, len(self._ranks))

    def _is_lost(self, tick: int, number: int, envelope: Envelope, receiver: str) -> bool:
        if not self._loss:
            return False
        words = (zlib.crc32(envelope.sender.encode()), zlib.crc32(receiver.encode()))
        word = 0
        for part in (self._seed, tick, *words, number):
            word = mixed(word + part)
        return (word >> 11) * 2.0**-53 < self._loss


def mixed(word: int) -> int:
    """Return a word with its bits mixed (SplitMix64), as the world's radio draws its losses."""
    word = (word + 0x9E3779B97F4A7C15) & WORD
    word = ((word ^ (word >> 30)) * 0xBF58476D1CE4E5B9) & WORD
    word = ((word ^ (word >> 27)) * 0x94D049BB133111EB) & WORD
    return word ^ (word >> 31)
