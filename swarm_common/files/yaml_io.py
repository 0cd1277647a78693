"""Strict reading of YAML files: malformed text, unknown keys and wrong types are errors."""

from __future__ import annotations

import contextlib
import itertools
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml

from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError

LARGEST = 1e300  # of numbers
SHORT, FEW = 20_000, 200  # characters, openings
MAX_SHOWN = 200  # characters of a value in a message
LONGEST = 4_000_000  # [bytes] of a file
MOST_NODES = 2_000_000  # of a document in which each alias is replaced by what it stands for


class UniqueKeys:
    """For a loader of PyYAML: a key that occurs twice is an error, and so are too many aliases."""

    def get_single_node(self) -> yaml.Node | None:
        """Return the document, or raise if writing it out would never end."""
        document: yaml.Node | None = super().get_single_node()  # type: ignore[misc]
        if document is not None:
            _count(document, {})
        return document

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return the mapping of a node.

        Args:
            deep: Whether to construct what is in it at once, as for PyYAML's own.

        Raises:
            yaml.MarkedYAMLError: If a key occurs twice.
        """
        seen: set[str] = set()
        for key_node, _ in node.value:
            if key_node.value in seen and key_node.tag != "tag:yaml.org,2002:merge":
                raise yaml.MarkedYAMLError(
                    problem=f"key '{key_node.value}' occurs twice", problem_mark=key_node.start_mark
                )
            if isinstance(key_node.value, str):
                seen.add(key_node.value)
        pairs: dict[Any, Any] = super().construct_mapping(node, deep)  # type: ignore[misc]
        return pairs


class UniqueKeyLoader(UniqueKeys, yaml.SafeLoader):
    """PyYAML's safe loader with unique keys."""


class FastLoader(UniqueKeys, getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """The same in C, which is ten times faster but has no limit to how deep it nests."""


def _integer(loader: Any, node: yaml.ScalarNode) -> int:
    """Return a number that ROS can hold, or raise."""
    value: int = loader.construct_yaml_int(node)
    if not -(2**63) <= value < 2**63:
        raise yaml.MarkedYAMLError(
            problem="an integer of more than 64 bits", problem_mark=node.start_mark
        )
    return value


# 1e-3 is a number in YAML 1.2, and to Nav2; PyYAML's rules are those of 1.1.
for _loader in (UniqueKeyLoader, FastLoader):
    _loader.add_constructor("tag:yaml.org,2002:int", _integer)
    _loader.add_implicit_resolver(
        "tag:yaml.org,2002:float",
        re.compile(r"^[-+]?(\d+(\.\d*)?|\.\d+)[eE][-+]?\d+$"),
        list("-+.0123456789"),
    )


def _count(node: yaml.Node, known: dict[int, int]) -> int:
    """Return the number of nodes below a node, itself included; aliases count like copies."""
    if id(node) not in known:
        known[id(node)] = MOST_NODES  # found there again: it contains itself
        children = node.value if isinstance(node, yaml.CollectionNode) else ()
        if isinstance(node, yaml.MappingNode):
            children = itertools.chain.from_iterable(children)
        known[id(node)] = 1 + sum(_count(child, known) for child in children)
    if known[id(node)] >= MOST_NODES:
        raise yaml.MarkedYAMLError(
            problem=f"aliases make more than {MOST_NODES} values of it",
            problem_mark=node.start_mark,
        )
    return known[id(node)]


def _is_shallow(text: str) -> bool:
    """Whether a text is too short, and has too few brackets, to nest deep."""
    openings = sum(text.count(opening) for opening in "[{-?")
    return len(text) < SHORT and openings < FEW


def _parse(text: str) -> Any:
    if _is_shallow(text):
        with contextlib.suppress(yaml.YAMLError):  # the other one says better where it is
            return yaml.load(text, FastLoader)
    return yaml.load(text, UniqueKeyLoader)


def read_yaml(
    path: Path, error: type[SwarmError] = ConfigError, *, may_be_empty: bool = False
) -> dict[str, Any]:
    """Return the mapping at the top of a YAML file.

    Args:
        may_be_empty: Whether a file without any key is an empty mapping, not an error.

    Raises:
        SwarmError: `error`, naming file and line, if the file cannot be read or parsed.
    """
    try:
        with path.open("rb") as file:  # which may be a pipe
            content = file.read(LONGEST + 1)
        text = content.decode() if len(content) <= LONGEST else ""
    except OSError as cause:
        raise error(f"cannot read {path}: {cause}") from cause
    except UnicodeDecodeError as cause:
        at = content.count(b"\n", 0, cause.start) + 1
        raise error(f"{path}, line {at}: it is not UTF-8; save it as UTF-8") from cause
    if not text and content:
        raise error(f"{path} has more than {LONGEST // 1_000_000} MB; expected lines of YAML")
    try:
        data = _parse(text)
    except yaml.MarkedYAMLError as cause:
        mark = cause.problem_mark
        where = f"{path}, line {mark.line + 1}" if mark else str(path)
        raise error(f"{where}: malformed YAML: {cause.problem}") from cause
    except (yaml.YAMLError, ValueError, TypeError, OverflowError, RecursionError) as cause:
        what = "nested too deep" if isinstance(cause, RecursionError) else str(cause).split("\n")[0]
        raise error(f"{path}: malformed YAML: {what}") from cause
    if data is None and may_be_empty:
        return {}
    if data is None:
        raise error(f"{path} is empty; expected 'key: value' lines")
    if not isinstance(data, dict):
        raise error(f"{path}: expected 'key: value' lines, found {type(data).__name__}")
    return data


def _shown(value: object) -> str:
    text = repr(value) if not isinstance(value, int) or abs(value) < LARGEST else "a huge number"
    return text if len(text) <= MAX_SHOWN else text[:MAX_SHOWN] + " ..."


def check_keys(data: dict[str, Any], known: Iterable[str], where: str) -> None:
    """Refuse keys that are not known.

    Args:
        where: File and place in it, for messages.

    Raises:
        UnknownNameError: For the first key that is not among the known ones.
    """
    names = list(known)
    for key in data:
        if key not in names:
            raise UnknownNameError("key", str(key), names, where)


def number(value: object, what: str, error: type[SwarmError] = ConfigError) -> float:
    """Return a finite number; true and false are none.

    Raises:
        SwarmError: `error`, saying what was expected.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > LARGEST:
        raise error(f"{what} is {_shown(value)}; expected a number")
    if not math.isfinite(value):
        raise error(f"{what} is {value}; expected a number")
    return float(value)


def yaw_number(value: object, what: str, error: type[SwarmError] = ConfigError) -> float:
    """Return an angle [rad] of at most a turn to either side: a larger one may be in degrees.

    Raises:
        SwarmError: `error`, saying what was expected.
    """
    angle = number(value, what, error)
    if abs(angle) > math.tau + 1e-6:
        raise error(f"{what}: yaw is {angle:g}; expected -2 pi to 2 pi, in radians")
    return angle


def pose_numbers(
    value: object, what: str, error: type[SwarmError] = ConfigError
) -> tuple[float, float, float]:
    """Return x, y [m] and yaw [rad].

    Raises:
        SwarmError: `error`, saying what was expected.
    """
    x, y, angle = numbers(value, 3, f"{what} [x, y, yaw]", error)
    return x, y, yaw_number(angle, what, error)


def numbers(
    value: object, count: int, what: str, error: type[SwarmError] = ConfigError
) -> tuple[float, ...]:
    """Return a tuple of finite numbers.

    Args:
        count: How many there must be.

    Raises:
        SwarmError: `error`, saying what was expected.
    """
    if not isinstance(value, list) or len(value) != count:
        raise error(f"{what} is {value!r}; expected a list of {count} numbers")
    return tuple(number(item, what, error) for item in value)
