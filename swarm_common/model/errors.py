"""Errors that carry a message for the user: what was found, where, what to do."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

# In the message of a navigator's result whose reason is the map alone: no other try can succeed.
ON_THIS_MAP = "on this map"
_WORDS = re.compile(r"[^a-z0-9]+")


class SwarmError(Exception):
    """Base of every error that this project raises on purpose.

    Attributes:
        faults: The errors that this one lists, if it tells of several.
    """

    faults: tuple[SwarmError, ...] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        """Keep message and attributes, so that every error passes between processes.

        `Exception` would call the class with the message alone, which many do not take.
        """
        return _restored, (type(self), self.args), self.__dict__


def _restored(kind: type[SwarmError], args: tuple[Any, ...]) -> SwarmError:
    """Return an error without a call of its `__init__`, which composes the message."""
    return kind.__new__(kind, *args)


class ConfigError(SwarmError):
    """A parameter file, mission, sites file or command-line value is unusable."""


class NoSwarmError(ConfigError):
    """No swarm runs where one was looked for."""

    def __init__(self, domain: int) -> None:
        """Compose the message, which says how to start a swarm or reach one."""
        super().__init__(
            f"no swarm is running in ROS domain {domain} on this machine;"
            " start one with swarm-up, or source the env.sh in its run folder"
        )


class SwarmEndedError(SwarmError):
    """The swarm that a command works with is gone."""

    def __init__(self) -> None:
        super().__init__("the swarm has ended")


class MapError(SwarmError):
    """A map file is unusable or disagrees with the world."""


class MapImageError(MapError):
    """The image of a map is missing or unusable."""


class DescriptionError(SwarmError):
    """A description of a robot or a world is unusable, or a file that it names."""


class WorldError(DescriptionError):
    """A world file is unusable."""


class RobotModelError(DescriptionError):
    """A robot description is unusable."""


class MissingPackageError(RobotModelError):
    """ROS packages are nowhere to be found."""

    def __init__(self, packages: Iterable[str], searched: str) -> None:
        """Compose the message, which says how to name the packages' folders."""
        self.packages = tuple(dict.fromkeys(packages))
        self.searched = searched
        names = " and ".join(f"'{name}'" for name in self.packages)
        several = len(self.packages) > 1
        super().__init__(
            f"package{'s' if several else ''} {names} {'are' if several else 'is'} not in "
            f"{searched}; give {'their folders' if several else 'its folder'} with "
            "--package-path, ROS_PACKAGE_PATH, or for a robot packages: in robot.yaml"
        )


def close_names(name: str, known: Iterable[str], most: int = 3) -> list[str]:
    """Return the known names that a misspelt one is nearest to, at equal edit distance.

    A name of several words is also met by one of them: `wafle` by `turtlebot3_waffle`.
    """
    wanted = name.casefold()
    apart = {}
    for each in known:
        folded = each.casefold()
        apart[each] = min(edit_distance(wanted, word) for word in (folded, *_WORDS.split(folded)))
    least = min(apart.values(), default=0)
    if least > max(1, len(wanted) // 3):
        return []
    nearest = (each for each, distance in apart.items() if distance == least)
    # whole names before those of which only a word is near
    return sorted(nearest, key=lambda each: (abs(len(each) - len(name)), each))[:most]


def edit_distance(one: str, other: str) -> int:
    """Return how many letters to insert, delete, replace or swap (Damerau 1964)."""
    rows = [list(range(len(other) + 1))]
    for place, letter in enumerate(one, 1):
        row = [place]
        for at, wanted in enumerate(other, 1):
            changed = rows[-1][at - 1] + (letter != wanted)
            least = min(changed, rows[-1][at] + 1, row[-1] + 1)
            if place > 1 and at > 1 and one[place - 2 : place] == wanted + other[at - 2]:
                least = min(least, rows[-2][at - 2] + 1)
            row.append(least)
        rows.append(row)
    return rows[-1][-1]


def is_path(name: str) -> bool:
    """Whether a name that a user gave is that of a file."""
    return "/" in name or name.endswith((".urdf", ".xacro", ".sdf", ".world", ".yaml", ".yml"))


class UnknownNameError(ConfigError):
    """A name is not among the known ones.

    Attributes:
        kind: Kind of thing that the name stands for, for example ``world``.
        name: The name as given.
        known: All valid names, sorted.
        where: File that the name is in, or place in one; empty if unknown.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str], where: str = "") -> None:
        """Compose the message, which proposes names like the given one, or lists all.

        Args:
            where: File that the name is in; empty if it is in none.
        """
        self.kind = kind
        self.name = name
        self.known = sorted(known)
        self.where = where
        place = f" in {where}" if where else ""
        is_file = kind in ("robot", "world") and is_path(name)
        what = f"there is no file or folder '{name}'" if is_file else f"unknown {kind} '{name}'"
        super().__init__(f"{what}{place}; {self._advice()}")

    def _advice(self) -> str:
        close = close_names(self.name, self.known)
        if close:
            return "did you mean " + " or ".join(f"'{name}'" for name in close) + "?"
        return "known: " + (", ".join(self.known) or "none")
