"""Lockstep of orders: a party begins a tick when all others have spoken in the one before.

So a message takes one tick, however long it takes on the wall clock. Only a party that is gone is
not waited for, until it speaks again. No clock, no I/O.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable

PATIENCE = 8.0  # [s] of wall time for a party's word on a tick that the world has left behind
START_PATIENCE = 600.0  # [s] the same for its first word
REPEATED = 2  # latest words of a party that it repeats while it waits


class OrderBarrier:
    """Decides when a tick may begin.

    Attributes:
        begun: Newest tick that the world has begun for certain.
    """

    def __init__(self, others: Iterable[str]) -> None:
        """Begin before tick 0.

        Args:
            others: Processes that are waited for.
        """
        self.begun = 0
        self._spoken = dict.fromkeys(others, -1)  # tick of the latest word
        self._left_out: set[str] = set()
        self._coming = 0  # tick that the world has begun or begins when all robots have answered
        self._since: float | None = None  # wall time since when the present tick could begin

    def hear(self, party: str, tick: int, *, is_in_step: bool) -> bool:
        """Record what a party says of a tick; return whether it is its first word.

        Args:
            is_in_step: Whether one of its robots has decided on the tick.
        """
        if is_in_step:
            self._coming = max(self._coming, tick + 1)
        if party not in self._spoken:
            return False
        is_first = self._spoken[party] < 0
        self._spoken[party] = max(self._spoken[party], tick)
        self._left_out.discard(party)
        return is_first

    def accepts(self, party: str, tick: int) -> bool:
        """Whether a party's word on a tick is new and none before it is missing.

        At the start the first of two words may be lost, as DDS finds a sender between them. Both
        are repeated; words further back never are.
        """
        gap = tick - self._spoken.get(party, tick - 1)
        return gap == 1 or gap > REPEATED

    def see(self, tick: int) -> None:
        """Record a tick that the world has begun."""
        self.begun = max(self.begun, tick)
        self._coming = max(self._coming, tick)

    def is_due(self, tick: int) -> bool:
        """Whether the world has begun a tick, or is about to."""
        return tick <= self._coming

    def missing(self, tick: int, among: Collection[str] | None = None) -> list[str]:
        """Return who has not spoken of a tick and is waited for.

        Args:
            among: Parties that are asked about; None for all.
        """
        return [
            party
            for party, spoken in self._spoken.items()
            if spoken < tick and party not in self._left_out and (among is None or party in among)
        ]

    def is_complete(self, tick: int, now: float, among: Collection[str] | None = None) -> bool:
        """Whether all have spoken of a tick; who is silent for too long is left out from now on.

        Nobody is silent while the world has not left the tick behind.

        Args:
            now: [s] of wall time.
            among: Who is asked; None for all.
        """
        missing = self.missing(tick, among)
        if not missing or self.begun <= tick:
            self._since = None
            return not missing
        if self._since is None:
            self._since = now
        waited = now - self._since
        for party in missing:
            if waited > (START_PATIENCE if self._spoken[party] < 0 else PATIENCE):
                self._left_out.add(party)
        return not self.missing(tick, among)
