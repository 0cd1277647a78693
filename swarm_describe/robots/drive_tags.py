"""Statements of a plugin or a controller on a robot's drive."""

from __future__ import annotations

from dataclasses import dataclass, field

from swarm_describe.robots.words import words

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
    said = words(name)
    return next((drive for key, drive in MEANINGS if _holds(said, key)), None)


def is_steered(name: str) -> bool:
    """Return whether a plugin or controller steers wheels."""
    return drive_of(name) is None and any(word in STEERED for word in words(name))


def _holds(said: tuple[str, ...], key: tuple[str, ...]) -> bool:
    return any(said[start : start + len(key)] == key for start in range(len(said)))
