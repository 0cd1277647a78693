"""Robots that fell silent: dead where they were, or gone away?

Those that may have left the radio range are no obstacles while they are far away: only near the
place that such a robot held does it matter whether it still stands there. See
docs/architecture/safety.md, "Silent robots".
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import BEACON_WORDS, SIGHTINGS, Reception
from swarm_nav.perception import absence_kernels as kernels
from swarm_nav.perception.absence_kernels import (
    FATE,
    LEFT,
    MOVED,
    NEVER,
    PARTED,
    SILENT,
    UNKNOWN,
    Absentees,
    Sightings,
    Spot,
)
from swarm_nav.perception.neighbor_table_kernels import ID

JUDGED_EVERY = 8  # ticks
INITIAL_IDS = 128
SIGHTED_WORDS = 4 * SIGHTINGS  # of a beacon

Words = NDArray[np.uint32]
NOBODY: Words = np.zeros((0, BEACON_WORDS), np.uint32)


class Absence:
    """The last beacons of robots that fell silent, and where all robots were seen last.

    Every robot tells the others where it knows each robot to have been last, and when. So what one
    of them knows of a robot that is out of hearing reaches all that it meets.

    Attributes:
        sightings: Where each robot was last; a row per id.
    """

    def __init__(self, own_id: int) -> None:
        """Start without knowing anybody.

        Args:
            own_id: Of this robot; robots check and tell in turn by it.
        """
        self._own_id = own_id
        self.sightings = _sightings(INITIAL_IDS)
        self._take(NOBODY, np.zeros((0, 3), np.int64))

    def __len__(self) -> int:
        return len(self._words)

    def _grow(self, ids: int) -> None:
        """Have room for sightings of ids below `ids`."""
        known = _sightings(ids)
        known.ticks[: len(self.sightings.ticks)] = self.sightings.ticks
        known.places[: len(self.sightings.places)] = self.sightings.places
        self.sightings = known

    def _take(self, words: Words, facts: NDArray[np.int64]) -> None:
        self._words, self._facts = words, facts
        self._floats = words.view(np.float32)
        ids = words[:, ID]
        self._places = np.full(int(ids.max(initial=0)) + 1, -1, np.int64)
        self._places[ids] = np.arange(len(ids))
        self._absent = words, facts, self._places  # for calls in every tick

    def add(
        self, words: Words, has_parted: NDArray[np.bool_], *, is_obstacle: bool = False
    ) -> None:
        """Take the newest beacons of robots that are not heard any more.

        Args:
            words: (n, BEACON_WORDS); those of robots that are known to be silent are left out.
            has_parted: (n,) whether each was driving out of range.
            is_obstacle: Whether they fell silent well within range, and are obstacles already.
        """
        is_new = self._places_of(words[:, ID]) < 0
        if is_new.any():
            facts = np.full((np.count_nonzero(is_new), 3), NEVER, np.int64)
            facts[:, FATE] = SILENT if is_obstacle else UNKNOWN
            facts[:, PARTED] = has_parted[is_new]
            self._take(np.vstack((self._words, words[is_new])), np.vstack((self._facts, facts)))

    def _places_of(self, ids: NDArray[np.uint32]) -> NDArray[np.int64]:
        places = np.full(len(ids), -1, np.int64)
        is_known = ids < len(self._places)
        places[is_known] = self._places[ids[is_known]]
        return places

    def tell(self, tick: int, out: Words) -> None:
        """Write the sightings for a beacon.

        Args:
            tick: Of the beacon.
            out: (SIGHTED_WORDS,) words of the beacon from `sighted_id` on; written.
        """
        kernels.tell(*self.sightings, self._own_id, tick, out)

    def listen(
        self, receptions: Sequence[Reception], position: tuple[float, float], edge: float, tick: int
    ) -> tuple[Words, list[int]]:
        """Take the beacons of a tick, and find out what became of robots that are not heard.

        Args:
            receptions: Batches of this tick.
            position: Own (x, y) [m] in map.
            edge: [m] within which a robot that lives is heard.
            tick: Now.

        Returns:
            Beacons (k, words) of robots found silent where they were; ids of robots that have left
            the place where they were thought to be.
        """
        is_changed = False
        for heard in receptions:
            batch = heard.words, heard.rows
            needed, is_back = kernels.hear(*self.sightings, *self._absent, *batch)
            if needed > len(self.sightings.ticks):
                self._grow(2 * needed)
                kernels.hear(*self.sightings, *self._absent, *batch)
            is_changed |= is_back
        fates = self._facts[:, FATE]
        before = fates
        if len(fates) and (tick + self._own_id) % JUDGED_EVERY == 0:
            before = fates.copy()
            absent = Absentees(self._words, self._floats, self._facts, self._places)
            is_changed |= kernels.judge(absent, self.sightings, Spot(*position), edge, tick) > 0
        if not is_changed:
            return NOBODY, []
        silent = self._words[(fates == SILENT) & (before != SILENT)]
        left = self._words[(fates == LEFT) | (fates == MOVED), ID].tolist()
        fates[fates == MOVED] = UNKNOWN
        stays = (fates == UNKNOWN) | (fates == SILENT)
        self._take(self._words[stays], self._facts[stays])
        return silent, left


def _sightings(ids: int) -> Sightings:
    return Sightings(np.full(ids, NEVER, np.int64), np.zeros((ids, 2), np.float32))
