"""Robots that fell silent where they may have left the radio range: dead there, or gone away?

They are no obstacles while they are far away: only near the place that such a robot held does it
matter whether it still stands there. See docs/architecture/safety.md, "Silent robots".
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import BEACON_WORDS, Reception
from swarm_nav.perception import absence_kernels as kernels
from swarm_nav.perception.absence_kernels import (
    FATE,
    LEFT,
    NEVER,
    PARTED,
    SILENT,
    UNKNOWN,
    Absentees,
    Hearing,
    Spot,
)
from swarm_nav.perception.neighbor_table_kernels import ID

WITNESS_TICKS = 8  # between two checks of the robots that the others hear

Words = NDArray[np.uint32]
NOBODY: Words = np.zeros((0, BEACON_WORDS), np.uint32)
NOTHING = Reception(NOBODY, np.zeros(0, np.int64))


class Absence:
    """The last beacons of robots that may have left, and the facts learned about them since."""

    def __init__(self, own_id: int) -> None:
        self._own_id = own_id
        self._take(NOBODY, np.zeros((0, 5), np.int64))

    def __len__(self) -> int:
        return len(self._words)

    def _take(self, words: Words, facts: NDArray[np.int64]) -> None:
        self._words, self._facts = words, facts
        self._floats = words.view(np.float32)
        ids = words[:, ID]
        self._places = np.full(int(ids.max(initial=0)) + 1, -1, np.int64)
        self._places[ids] = np.arange(len(ids))

    def add(self, words: Words, has_parted: NDArray[np.bool_]) -> None:
        """Take the newest beacons of robots that are not heard any more.

        Args:
            words: (n, BEACON_WORDS).
            has_parted: (n,) whether each was driving out of range.
        """
        facts = np.full((len(words), 5), NEVER, np.int64)
        facts[:, FATE], facts[:, PARTED] = UNKNOWN, has_parted
        known = self._places_of(words[:, ID]) < 0  # a robot that was taken back is still here
        self._take(np.vstack((self._words, words[known])), np.vstack((self._facts, facts[known])))

    def _places_of(self, ids: NDArray[np.uint32]) -> NDArray[np.int64]:
        places = np.full(len(ids), -1, np.int64)
        is_known = ids < len(self._places)
        places[is_known] = self._places[ids[is_known]]
        return places

    def listen(
        self,
        receptions: Iterable[Reception],
        position: tuple[float, float],
        limits: tuple[float, float, int],
        tick: int,
    ) -> tuple[Words, list[int]]:
        """Take the beacons of a tick; return the robots that seem dead, and those that have left.

        Args:
            receptions: Batches of this tick.
            position: Own (x, y) [m] in map.
            limits: (edge [m], range [m], lost_ticks), see `NeighborTable`.
            tick: Now.

        Returns:
            Beacons (k, words) of robots found silent where they were; ids of robots that have left.
        """
        is_witnessed = (tick + self._own_id) % WITNESS_TICKS == 0
        changes = 0
        before = self._facts[:, FATE].copy()
        for heard in receptions:
            changes += kernels.listen(
                Absentees(self._words, self._floats, self._facts, self._places),
                heard.words,
                heard.rows,
                Spot(*position),
                Hearing(*limits),
                tick,
                is_witnessed,
            )
        if not changes:
            return NOBODY, []
        fates = self._facts[:, FATE]
        silent = self._words[(fates == SILENT) & (before != SILENT)]
        left = self._words[fates == LEFT, ID].tolist()
        stays = (fates == UNKNOWN) | (fates == SILENT)
        self._take(self._words[stays], self._facts[stays])
        return silent, left
