"""Parties that coordinate the traffic of the robots."""

from __future__ import annotations

from enum import StrEnum


class Coordination(StrEnum):
    """Party that decides which robot waits or goes first; stop filters guard in any case."""

    DECENTRAL = "decentral"  # the robots among themselves
    CENTRAL = "central"  # one process for all robots
    CENTRAL_WITH_FALLBACK = "central-with-fallback"  # the robots while it is silent
    FLEET = "fleet"  # a fleet control, by base and horizon alone

    @property
    def has_centre(self) -> bool:
        """Whether one process of ours decides for all robots."""
        return self in (Coordination.CENTRAL, Coordination.CENTRAL_WITH_FALLBACK)
