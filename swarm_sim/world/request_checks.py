"""Why a change of the world is refused, and limits on the content of every `/sim` request.

Every request passes these checks before its meaning is considered: texts and lists have limits,
numbers are finite, and poses are within reach of the map. Later code need not check again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import Grid
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


LONGEST_TEXT = 256  # letters of a name, a frame id, a filter, ...
LONGEST = {"uri": 4096, "resource_string": 1_000_000}  # letters of these
MOST_ENTRIES = 1000  # of a list
MARGIN = 10.0  # [m] around the map in which things may be put
HIGHEST = 100.0  # [m] above or below the ground
REASONS = {
    "name": Reason.NAME_INVALID,
    "uri": Reason.NO_MODEL,
    "resource_string": Reason.BAD_MODEL,
    "position": Reason.BAD_PLACE,
    "orientation": Reason.BAD_PLACE,
}


def check_request(request: Any) -> None:
    """Refuse a request with a text or a list that is too long, or a number that is not finite.

    Raises:
        RefusedError: Naming the field.
    """
    _check_fields(request, "", Reason.FAILED)


def _check_fields(message: Any, path: str, reason: Reason) -> None:
    for name in message.get_fields_and_field_types():
        _check(getattr(message, name), f"{path}{name}", name, REASONS.get(name, reason))


def _check(value: Any, path: str, name: str, reason: Reason) -> None:
    if isinstance(value, str):
        limit = LONGEST.get(name, LONGEST_TEXT)
        if len(value) > limit:
            raise RefusedError(reason, f"{path} has {len(value)} letters; at most {limit} are read")
        if "\0" in value:
            raise RefusedError(reason, f"{path} has a NUL in it")
    elif isinstance(value, float):
        if not math.isfinite(value):
            raise RefusedError(reason, f"{path} is {value}; it must be finite")
    elif hasattr(value, "get_fields_and_field_types"):
        _check_fields(value, f"{path}.", reason)
    elif hasattr(value, "__len__"):
        if len(value) > MOST_ENTRIES:
            raise RefusedError(
                reason, f"{path} has {len(value)} entries; at most {MOST_ENTRIES} are read"
            )
        for number, entry in enumerate(value):
            _check(entry, f"{path}[{number}]", name, reason)


@dataclass(frozen=True, slots=True)
class PlacementArea:
    """Area in which something can be put at all: on the map and close to it."""

    low: tuple[float, float]  # (x, y) [m] in the map frame
    high: tuple[float, float]  # (x, y) [m] in the map frame

    @classmethod
    def of(cls, grid: Grid) -> PlacementArea:
        """Return that of a map, which is upright."""
        x, y, size = grid.origin_x, grid.origin_y, grid.resolution
        return cls(
            (x - MARGIN, y - MARGIN),
            (x + grid.width * size + MARGIN, y + grid.height * size + MARGIN),
        )

    def check(self, xyz_map: Sequence[float]) -> None:
        """Refuse a place out of reach.

        Raises:
            RefusedError: Saying what is in reach.
        """
        lows, highs = (*self.low, -HIGHEST), (*self.high, HIGHEST)
        if all(
            low <= value <= high for low, value, high in zip(lows, xyz_map, highs, strict=False)
        ):
            return
        place = ", ".join(f"{v:.2f}" if abs(v) < 1e6 else f"{v:g}" for v in xyz_map)
        x, y = zip(self.low, self.high, strict=True)
        raise RefusedError(
            Reason.BAD_PLACE,
            f"({place}) is out of this world; x is within {x[0]:.2f} to {x[1]:.2f}, "
            f"y within {y[0]:.2f} to {y[1]:.2f}, z within {HIGHEST:.0f} of the ground",
        )
