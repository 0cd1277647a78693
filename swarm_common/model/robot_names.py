"""Names of a run's robots: their namespaces in ROS, by the number that their beacons carry as id.

Only names differ from run to run: order, ids and random draws of robots go by their numbers.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import dataclass

from swarm_common.model.errors import ConfigError

MOST = 65535  # highest number, which beacons carry in 16 bits
LONGEST = 64  # letters of a name: the longest topic in its namespace stays below the limits of DDS
DEFAULT = "Srobot{}"
FIELD = re.compile(r"\{(?::0[1-9]d?)?\}")  # for the number in a pattern
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # ROS hides what begins with an underscore
# Commands of swarm-commander that change the swarm.
FLEET_COMMANDS = ("spawn", "remove", "move", "list", "reset", "restart", "record", "frames")
# What else has a name at the root of a swarm's topics, frames, files of a run and commands.
RESERVED = frozenset(FLEET_COMMANDS) | frozenset(
    "clock diagnostics map orders parameter_events rosout sim tf tf_static"  # topics and frames
    " all merged swarm"  # windows of RViz, and their files
    " central client courier distributor mission navigators recorder server station"  # logs
    " vda5050 viewer world".split()
)
NUMBERED_LOG = re.compile(r"(station|courier)_\d+")  # log of a station or courier of orders


@dataclass(frozen=True, slots=True)
class RobotNames:
    """A list of names, and the pattern by which all robots with higher numbers are called.

    Attributes:
        listed: Names of robots 1, 2, ...; may be empty.
        pattern: Has one field `{}` or `{:02}` for the number.
    """

    listed: tuple[str, ...] = ()
    pattern: str = DEFAULT

    def __post_init__(self) -> None:
        if len(FIELD.findall(self.pattern)) != 1:
            raise ConfigError(
                f"pattern '{self.pattern}': expected one field {{}}, or {{:02}} for two digits,"
                " where the number goes, like agv{}"
            )
        longest = FIELD.sub(lambda field: field[0].format(MOST), self.pattern)
        _check(longest, f"pattern '{self.pattern}'")
        seen: set[str] = set()
        for name in self.listed:
            _check(name, f"'{name}'")
            if name in seen:
                raise ConfigError(f"two robots are called '{name}'; names must differ")
            seen.add(name)

    @classmethod
    def of(cls, words: Sequence[str], count: int, where: str) -> RobotNames:
        """Return the names of a run's robots."""
        has_pattern = bool(words) and "{" in words[-1]
        listed = tuple(words[:-1] if has_pattern else words)
        try:
            names = cls(listed, words[-1] if has_pattern else DEFAULT)
        except ConfigError as error:
            raise ConfigError(f"{where}: {error}") from None
        if len(listed) > count or (len(listed) < count and not has_pattern):
            raise ConfigError(
                f"{where}: expected as many names as robots, {count}, but found {len(listed)};"
                " or give a pattern with {} for the number, like agv{}"
            )
        for name in listed:
            if len(listed) < names._numbered(name) <= count:
                raise ConfigError(f"{where}: two robots are called '{name}'; names must differ")
        return names

    @classmethod
    def parse(cls, text: str) -> RobotNames:
        """Return the names that a process was told as `str` gives them."""
        *listed, pattern = text.split(",")
        return cls(tuple(listed), pattern)

    def __str__(self) -> str:
        return ",".join((*self.listed, self.pattern))

    def name_of(self, number: int) -> str:
        """Return the name of a robot.

        Args:
            number: From 1; the id in its beacons.
        """
        if 0 < number <= len(self.listed):
            return self.listed[number - 1]
        return self.pattern.format(number)

    def number_of(self, name: str) -> int:
        """Return the number of a robot; 0 if no robot of the run can be called like that."""
        if name in self.listed:
            return self.listed.index(name) + 1
        number = self._numbered(name)
        return number if number > len(self.listed) else 0

    def looks_like_one(self, name: str) -> bool:
        """Whether a name is a robot's, or would be if its number were in range."""
        return name in self.listed or _matcher(self.pattern).fullmatch(name) is not None

    @property
    def expected(self) -> str:
        """All names that a robot of the run can have, for people."""
        rest = [self.name_of(number) for number in (len(self.listed) + 1, MOST)]
        return ", or ".join(filter(None, (in_short(self.listed), " to ".join(rest))))

    def first(self, count: int) -> list[str]:
        """Return the names of the first robots in order."""
        return [self.name_of(number) for number in range(1, count + 1)]

    def _numbered(self, name: str) -> int:
        """Return the number that the pattern puts into a name; 0 if it gives no such name."""
        found = _matcher(self.pattern).fullmatch(name)
        number = int(found[1]) if found else 0
        return number if 1 <= number <= MOST and self.pattern.format(number) == name else 0


def natural(name: str) -> list[tuple[int, str]]:
    """Return a sort key by which agv2 comes before agv10."""
    parts = re.split(r"([0-9]+)", name)
    return [(int(part), "") if part.isdecimal() else (0, part) for part in parts]


def stem_and_number(name: str) -> tuple[str, str]:
    """Return a name without the digits at its end, and these digits."""
    stem = name.rstrip("0123456789")
    return stem, name[len(stem) :]


def in_short(names: Sequence[str]) -> str:
    """Return names for people: a range like agv1 to agv50, or each name."""
    if len(names) < 3:
        return " and ".join(names)
    stems, digits = zip(*map(stem_and_number, names), strict=True)
    numbers = [int(text or 0) for text in digits]
    if len(set(stems)) == 1 and numbers == list(range(numbers[0], numbers[0] + len(names))):
        return f"{names[0]} to {names[-1]}"
    return ", ".join(names)


@functools.lru_cache(maxsize=16)
def _matcher(pattern: str) -> re.Pattern[str]:
    before, after = FIELD.split(pattern)
    return re.compile(f"{re.escape(before)}([0-9]{{1,9}}){re.escape(after)}")


def _check(name: str, what: str) -> None:
    if not NAME.fullmatch(name) or len(name) > LONGEST:
        raise ConfigError(
            f"{what} is no name for a robot; expected at most {LONGEST} letters (a to z),"
            " digits and underscores, a letter first, like agv_1; a namespace within another,"
            " like fleet/agv1, is not supported"
        )
    if name in RESERVED or NUMBERED_LOG.fullmatch(name):
        raise ConfigError(
            f"{what} is no name for a robot: something else of a swarm is called {name}"
        )
