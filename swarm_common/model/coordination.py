"""Who coordinates the robots' traffic."""

from __future__ import annotations

from enum import StrEnum


class Coordination(StrEnum):
    """Who decides which robot waits, makes way or goes first; stop filters guard in any case."""

    DECENTRAL = "decentral"  # the robots among themselves
    FLEET = "fleet"  # a fleet control, by base and horizon alone
