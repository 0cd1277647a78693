"""Words in which settings are declared: a base, and constraints that are asked often.

`swarm_common.files.convert` reads them. The description of a `Meta` says what is expected; its
`check` is a predicate beside the constraints that msgspec has.
"""

from __future__ import annotations

import math
from typing import Annotated, dataclass_transform

import msgspec
from msgspec import Meta


def is_name(text: str) -> bool:
    """Whether messages, tables and commands can show a name: one line, not empty."""
    return bool(text) and text == text.strip() and text.isprintable()


def _is_angle(value: float) -> bool:
    return abs(value) <= math.tau + 1e-6


Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Share = Annotated[float, Meta(ge=0.0, lt=1.0)]
Count = Annotated[int, Meta(ge=1)]
Name = Annotated[
    str,
    Meta(description="text on one line, without blanks around it", extra={"check": is_name}),
]
Yaw = Annotated[  # a larger one may be in degrees
    float,
    Meta(description="a number from -2 pi to 2 pi, in radians", extra={"check": _is_angle}),
]
Point = Annotated[tuple[float, float], Meta(description="a list of 2 numbers [x, y]")]
PoseNumbers = Annotated[
    tuple[float, float, Yaw], Meta(description="a list of 3 numbers [x, y, yaw]")
]


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(msgspec.field,))
class Schema(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of what is read from files: immutable, and no other keys than its fields."""
