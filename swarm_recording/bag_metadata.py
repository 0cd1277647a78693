"""rosbag2's `metadata.yaml`: every key is known, checked or told of; versions 1 to 9.

Also the offered quality of a recorded topic, as these versions write it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError, close_names

# Names from version 9 on, numbers of rmw before; what says nothing is the usual one.
RELIABILITY = {
    "reliable": True, 1: True, "best_effort": False, 2: False,
    "system_default": True, 0: True, "unknown": True, 3: True, "best_available": True, 4: True,
}  # fmt: skip
DURABILITY = {
    "transient_local": True,
    1: True,
    "volatile": False,
    2: False,
    "system_default": False,
    0: False,
    "unknown": False,
    3: False,
    "best_available": False,
    4: False,
}
HISTORY = {
    "keep_last": False, 1: False, "keep_all": True, 2: True,
    "system_default": False, 0: False, "unknown": False, 3: False,
}  # fmt: skip
MOST = 1000  # messages that a player keeps for latecomers
Offer = tuple[bool, bool, int]  # is reliable, is latched, depth
METADATA = "metadata.yaml"
TOP = "rosbag2_bagfile_information"
NEWEST = 9  # version, of ROS 2 Jazzy
_SPAN = {"nanoseconds": int}
_MOMENT = {"nanoseconds_since_epoch": int}
# A type, a mapping of known keys, or a list of what its elements are.
SHAPE: dict[str, Any] = {
    "version": int,
    "storage_identifier": str,
    "duration": _SPAN,
    "starting_time": _MOMENT,
    "message_count": int,
    "topics_with_message_count": [
        {
            "topic_metadata": {
                "name": str,
                "type": str,
                "serialization_format": str,
                "offered_qos_profiles": object,  # text, from version 9 on a list
                "type_description_hash": str,
            },
            "message_count": int,
        }
    ],
    "compression_format": str,
    "compression_mode": str,
    "relative_file_paths": [str],
    "files": [{"path": str, "starting_time": _MOMENT, "duration": _SPAN, "message_count": int}],
    "custom_data": object,
    "ros_distro": str,
}
REQUIRED = ("version", "relative_file_paths", "message_count")
Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class BagMetadata:
    """Content of a bag's `metadata.yaml` that a reader can use."""

    files: tuple[str, ...] = ()  # as written, in order
    message_count: int | None = None
    counts: dict[str, int] = field(default_factory=dict)  # messages by topic
    qualities: dict[str, Any] = field(default_factory=dict)  # offered QoS by topic, as written


def read_metadata(path: Path, tell: Tell) -> BagMetadata:
    """Return what a `metadata.yaml` says; all that is not understood is told.

    Raises:
        ConfigError: If it is no such file.
    """
    tree = read_yaml(path)
    if not isinstance(tree.get(TOP), dict):
        raise ConfigError(f"{path}: '{TOP}' is missing; expected rosbag2's {METADATA}")
    for key in tree.keys() - {TOP}:
        tell(f"{path}: unknown key '{key}'")
    data = _known(tree[TOP], SHAPE, f"{path}: ", tell)
    for key in REQUIRED:
        if key not in data:
            tell(f"{path}: '{key}' is missing")
    if data.get("version", NEWEST) > NEWEST:
        tell(f"{path}: version {data['version']} is newer than {NEWEST}, the newest known one")
    topics = data.get("topics_with_message_count", [])
    named = [row for row in topics if "name" in row.get("topic_metadata", {})]
    if len(named) < len(topics):
        tell(f"{path}: {len(topics) - len(named)} topics without topic_metadata.name")
    names = [row["topic_metadata"]["name"] for row in named]
    _tell_doubles(names, f"{path}: topic", tell)
    qualities = {
        row["topic_metadata"]["name"]: row["topic_metadata"].get("offered_qos_profiles", "")
        for row in named
    }
    counts = {
        name: row["message_count"]
        for name, row in zip(names, named, strict=True)
        if "message_count" in row
    }
    return BagMetadata(_files(data, path, tell), data.get("message_count"), counts, qualities)


def _files(data: dict[str, Any], path: Path, tell: Tell) -> tuple[str, ...]:
    """Return the files that both lists of them name, in the order of the first."""
    listed = data.get("relative_file_paths", [])
    described = [row["path"] for row in data.get("files", []) if "path" in row]
    for names, key in ((listed, "relative_file_paths"), (described, "files")):
        _tell_doubles(names, f"{path}: {key}:", tell)
    # Some versions write only the last part of the path into `files`.
    short = {Path(name).name for name in listed}
    more = [name for name in described if Path(name).name not in short]
    if listed and described and (more or len(set(described)) != len(set(listed))):
        tell(
            f"{path}: relative_file_paths has {len(set(listed))} files, files has"
            f" {len(set(described))}; all are read"
        )
    return tuple(dict.fromkeys([*listed, *more]))


def _known(value: Any, shape: Any, where: str, tell: Tell) -> Any:
    """Return the part of a value that has the shape; the rest is told."""
    if isinstance(shape, list):
        if not isinstance(value, list):
            tell(f"{where}found {value!r}; expected a list")
            return []
        parts = [_known(part, shape[0], f"{where}[{i}] ", tell) for i, part in enumerate(value)]
        return [part for part in parts if part is not None]
    if not isinstance(shape, dict):
        if isinstance(value, shape) and not (shape is int and isinstance(value, bool)):
            return value
        tell(f"{where}found {value!r}; expected {'a number' if shape is int else 'a text'}")
        return None
    if not isinstance(value, dict):
        tell(f"{where}found {value!r}; expected keys {', '.join(shape)}")
        return None
    found = {}
    for key, part in value.items():
        if key not in shape:
            near = close_names(str(key), shape, most=1)
            tell(f"{where}unknown key '{key}'" + (f"; did you mean '{near[0]}'?" if near else ""))
        elif (known := _known(part, shape[key], f"{where}{key}: ", tell)) is not None:
            found[key] = known
    return found


def _tell_doubles(names: Iterable[str], where: str, tell: Tell) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            tell(f"{where} {name} is named twice; it is taken once")
        seen.add(name)


def offers(text: Any) -> list[Offer]:
    """Return the offers of all publishers that were recorded; none if nothing is said.

    Args:
        text: YAML, or the list that it stands for.

    Raises:
        ConfigError: If it is not understood.
    """
    try:
        rows = yaml.safe_load(text) if isinstance(text, str) else text
        return [_offer(row) for row in rows or ()]
    except (yaml.YAMLError, KeyError, TypeError, AttributeError, ValueError) as cause:
        raise ConfigError(f"offered_qos_profiles is not understood: {cause!r}") from cause


def _offer(row: dict[str, Any]) -> Offer:
    depth = MOST if HISTORY[row.get("history", 1)] else int(row.get("depth", 0))
    return RELIABILITY[row["reliability"]], DURABILITY[row["durability"]], depth


def united(offered: Iterable[Offer]) -> Offer:
    """Return the one offer that every subscriber of these publishers accepts.

    What several publishers keep for latecomers, one has to keep together.
    """
    rows = list(offered) or [(True, False, 0)]
    depth = sum(max(1, row[2]) for row in rows if row[1])
    return any(row[0] for row in rows), depth > 0, min(MOST, depth) or max(row[2] for row in rows)
