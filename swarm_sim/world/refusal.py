"""Why a change of the world is refused."""

from __future__ import annotations

from enum import Enum

from swarm_common.model.errors import SwarmError
from swarm_common.process.standard_streams import shown


class Reason(Enum):
    """Why something is refused."""

    NAME_TAKEN = "name taken"
    NAME_INVALID = "name invalid"
    NO_MODEL = "no model"
    BAD_MODEL = "bad model"
    MISSING_FILES = "missing files"
    BAD_FORMAT = "bad format"
    BAD_PLACE = "bad place"
    BAD_NAMESPACE = "bad namespace"
    UNKNOWN = "unknown"
    UNSUPPORTED = "unsupported"
    FAILED = "failed"


class RefusedError(SwarmError):
    """A change of the world that is not made.

    Attributes:
        reason: Code for clients that do not read the message.
    """

    def __init__(self, reason: Reason, message: str) -> None:
        """Keep the reason beside the message."""
        super().__init__(shown(message))
        self.reason = reason
