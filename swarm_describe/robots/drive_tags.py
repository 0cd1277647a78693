"""Statements of a plugin or a controller on a robot's drive, by the words in their names.

A name is split at everything that is no letter, between `aB` and `ABc`, and at digits: `controller`
holds no `roller`, and `omnicorp` no `omni`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
# Words that start like this mean it whatever follows (castors, casterwheel); the others only alone.
PASSIVE_STARTS = ("caster", "castor", "idler", "freewheel")
PASSIVE = frozenset(("free", "passive"))
OMNI_STARTS = ("mecanum", "swedish", "omniwheel", "omnidirectional", "holonomic")
OMNI = frozenset(("omni", "roller", "rollers"))


def words(name: str) -> tuple[str, ...]:
    """Return the words of a name in lower case, in order."""
    return tuple(word.lower() for word in WORD.findall(name))


def is_passive(name: str) -> bool:
    """Return whether a name says that a wheel is not driven."""
    return any(word in PASSIVE or word.startswith(PASSIVE_STARTS) for word in words(name))


def is_omni(name: str) -> bool:
    """Return whether a name says that something rolls sideways, too."""
    return any(word in OMNI or word.startswith(OMNI_STARTS) for word in words(name))


# Words of a plugin's file or class, or of a controller's type -> drive; the first that fits counts.
MEANINGS: tuple[tuple[tuple[str, ...], str], ...] = (
    (("skid", "steer"), "skid"),
    (("skid", "steering"), "skid"),
    (("skidsteer",), "skid"),
    (("diff", "drive"), "differential"),
    (("diffdrive",), "differential"),
    (("differential",), "differential"),
    (("slotcar",), "differential"),  # RMF's
    (("libslotcar",), "differential"),
    (("mecanum",), "omni"),
    (("omni",), "omni"),
    (("omnidrive",), "omni"),
    (("omnidirectional",), "omni"),
    (("planar", "move"), "omni"),
    (("force", "based", "move"), "omni"),
    (("velocity", "control"), "omni"),
)
STEERED = ("ackermann", "tricycle", "bicycle", "steering", "swerve")


@dataclass(frozen=True, slots=True)
class DriveTags:
    """A drive as something states it: its joints, and values of a `RobotSpec` by name."""

    drive: str
    source: str  # what states it, for messages
    left: tuple[str, ...] = ()  # joints
    right: tuple[str, ...] = ()
    values: dict[str, float] = field(default_factory=dict)
    origins: dict[str, str] = field(default_factory=dict)  # of values that are from elsewhere


def drive_of(name: str) -> str | None:
    """Return the drive that a name of a plugin or controller means, None if it means none."""
    said = f" {' '.join(words(name))} "
    return next((drive for key, drive in MEANINGS if f" {' '.join(key)} " in said), None)


def is_steered(name: str) -> bool:
    """Return whether a plugin or controller steers wheels."""
    return drive_of(name) is None and any(word in STEERED for word in words(name))
