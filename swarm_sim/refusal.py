"""Why a change of the world is refused."""

from __future__ import annotations

from enum import Enum

from swarm_common.errors import SwarmError

LONGEST_MESSAGE = 600  # letters; a message may quote what somebody has sent


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
        reason: For who does not read the message.
    """

    def __init__(self, reason: Reason, message: str) -> None:
        """Keep the reason beside the message, which is made fit to be shown."""
        super().__init__(shown(message))
        self.reason = reason

    def __reduce__(self) -> tuple[type[RefusedError], tuple[Reason, str]]:
        """Let it travel between processes."""
        return RefusedError, (self.reason, str(self))


def shown(message: str) -> str:
    """Return a message without control characters, and not longer than anybody reads."""
    text = "".join(
        letter if letter.isprintable() or letter == "\n" else "?"
        for letter in message[: 2 * LONGEST_MESSAGE]
    )
    if len(message) <= LONGEST_MESSAGE:
        return text
    half = LONGEST_MESSAGE // 2
    return f"{text[:half]} ... {shown(message[-half:])}"
