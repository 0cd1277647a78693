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
from swarm_nav.perception.absence_kernels import NEVER, SILENT, UNKNOWN, Absentees, Sightings, Spot
from swarm_nav.perception.neighbor_table_kernels import ID

JUDGED_EVERY = 8  # ticks
INITIAL_IDS = 128
INITIAL_ROWS = 32

Words = NDArray[np.uint32]
Heard = tuple[Reception, tuple[float, float]]  # a batch, and the own position (x, y) [m] in map
NOBODY: Words = np.zeros((0, BEACON_WORDS), np.uint32)


class Absence:
    """The last beacons of robots that fell silent, and where all robots were seen last.

    Every robot tells the others where it knows each robot to have been last, and when. So what one
    of them knows of a robot that is out of hearing reaches all that it meets.

    Attributes:
        sightings: Last known place of each robot; a row per id.
    """

    def __init__(self, own_id: int) -> None:
        """Start without knowing anybody.

        Args:
            own_id: Id of this robot; robots check and send sightings in turn by it.
        """
        self._own_id = own_id
        self._told: Words = np.zeros(4 * SIGHTINGS, np.uint32)
        self._count = 0  # of absent robots
        self._use_sightings(_sightings(INITIAL_IDS))
        self._use_absent(_absentees(INITIAL_ROWS, INITIAL_IDS))

    def _use_sightings(self, sightings: Sightings) -> None:
        self.sightings, self._plain_sightings = sightings, tuple(sightings)

    def _use_absent(self, absent: Absentees) -> None:
        self._absent, self._plain_absent = absent, tuple(absent)

    def __len__(self) -> int:
        return self._count

    def _grow(self, ids: int) -> None:
        known = _sightings(ids)
        known.ticks[: len(self.sightings.ticks)] = self.sightings.ticks
        known.places[: len(self.sightings.places)] = self.sightings.places
        known.asks[: len(self.sightings.asks)] = self.sightings.asks
        self._use_sightings(known)

    def _have_room(self, rows: int, ids: int) -> None:
        """Make room for absent robots, with ids below `ids`."""
        old = self._absent
        if rows <= len(old.words) and ids <= len(old.rows):
            return
        new = _absentees(max(2 * rows, len(old.words)), max(2 * ids, len(old.rows)))
        for name in ("words", "facts", "rows"):
            getattr(new, name)[: len(getattr(old, name))] = getattr(old, name)
        self._use_absent(new)

    def add(
        self, words: Words, has_parted: NDArray[np.bool_], *, is_obstacle: bool = False
    ) -> None:
        """Receive the newest beacons of robots that are not heard any more.

        Args:
            words: (n, BEACON_WORDS); those of robots that are known to be silent are left out.
            has_parted: (n,) whether each was driving out of range.
            is_obstacle: Whether they fell silent well within range, and are obstacles already.
        """
        self._have_room(self._count + len(words), int(words[:, ID].max(initial=0)) + 1)
        fate = SILENT if is_obstacle else UNKNOWN
        self._count = kernels.add(self._absent, self._count, words, has_parted, fate)

    def tell(self, tick: int) -> Words:
        """Return the sightings for a beacon, its words from `sighted_id` on.

        Args:
            tick: Tick of the beacon. The next call overwrites what is returned.
        """
        kernels.write_sightings(self._plain_sightings, self._own_id, tick, self._told)
        return self._told

    def listen(
        self, inbox: Sequence[Heard], position: tuple[float, float], edge: float, tick: int
    ) -> tuple[Words, list[int]]:
        """Receive the beacons of a tick, and find out what became of robots that are not heard.

        Args:
            position: Own (x, y) [m] in map.
            edge: [m] within which a robot that lives is heard.

        Returns:
            Beacons (k, words) of robots found silent where they were; ids of robots that have left
            the place where they were thought to be.
        """
        is_changed = False
        for heard, _ in inbox:
            batch = heard.words, heard.rows
            needed, is_back = kernels.hear(self._plain_sightings, self._plain_absent, *batch)
            if needed > len(self.sightings.ticks):
                self._grow(2 * needed)
                kernels.hear(self._plain_sightings, self._plain_absent, *batch)
            is_changed |= is_back
        if self._count and (tick + self._own_id) % JUDGED_EVERY == 0:
            spot = Spot(*position)
            is_changed |= kernels.judge(self._absent, self._count, self.sightings, spot, edge, tick)
        if not is_changed:
            return NOBODY, []
        silent = np.zeros((self._count, BEACON_WORDS), np.uint32)
        left = np.zeros(self._count, np.int64)
        self._count, *sizes = kernels.sort_out(self._absent, self._count, silent, left)
        return silent[: sizes[0]], left[: sizes[1]].tolist()


def _sightings(ids: int) -> Sightings:
    never = np.full(ids, NEVER, np.int64)
    return Sightings(never, np.zeros((ids, 2), np.float32), np.zeros(ids, np.bool_))


def _absentees(rows: int, ids: int) -> Absentees:
    words = np.zeros((rows, BEACON_WORDS), np.uint32)
    facts = np.zeros((rows, 3), np.int64)
    return Absentees(words, words.view(np.float32), facts, np.full(ids, -1, np.int64))
