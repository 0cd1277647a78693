"""Definitions of message types as MCAP wants them: the type's own text, then those it uses."""

from __future__ import annotations

import functools
import json
import os
import re
import sys
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from swarm_common.model.errors import ConfigError

SEPARATOR = "=" * 80
FIELD = re.compile(
    r"(?P<type>[A-Za-z]\w*(?:/\w+)*)(?:<=\d+)?(?P<array>\[(?:<=)?\d*\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?P<value>=.*|[-+.\d'\"\[].*|[tT]rue|[fF]alse)?"
)
CONSTANT = "="  # how the value of a constant begins
HEAD = re.compile(r"MSG:\s*(\S+)")
FILLER = "structure_needs_at_least_one_member"  # of a type without fields
BASIC = frozenset(
    "bool byte char float32 float64 int8 uint8 int16 uint16 int32 uint32 int64 uint64 string"
    " wstring".split()
)
SAME = {"byte": "uint8", "char": "uint8"}  # in the bytes of a message
Layout = dict[str, tuple[tuple[str, str], ...]]  # (type, name) of each field, by message type


@functools.cache
def schema_text(name: str) -> str:
    """Return the schema (encoding ``ros2msg``) of a type like ``nav_msgs/msg/Path``.

    Raises:
        ConfigError: If its definition is not installed.
    """
    texts: dict[str, str] = {}
    waiting = [name]
    while waiting:
        kind = waiting.pop(0)
        if kind in texts:
            continue
        texts[kind] = _definition(kind)
        waiting += _used_types(texts[kind], kind.split("/")[0])
    head, *rest = texts.items()
    parts = [head[1]]
    for kind, text in rest:
        package, _, short = kind.split("/")
        parts.append(f"{SEPARATOR}\nMSG: {package}/{short}\n{text}")
    return "\n".join(part.rstrip("\n") for part in parts) + "\n"


@functools.cache
def type_hash(name: str) -> str:
    """Return the hash (``RIHS01_...``) of a type's description; empty if it is not installed."""
    package, kind, short = name.split("/")
    try:
        file = _share(package) / kind / f"{short}.json"
        hashes = json.loads(file.read_text(encoding="utf-8"))["type_hashes"]
        return str(next(entry["hash_string"] for entry in hashes if entry["type_name"] == name))
    except (PackageNotFoundError, OSError, ValueError, KeyError, StopIteration):
        return ""


def _used_types(text: str, package: str) -> list[str]:
    types = [kind.partition("[")[0] for kind, _ in _fields(text, package)]
    return [kind for kind in types if "/" in kind]


def _fields(text: str, package: str) -> list[tuple[str, str]]:
    """Return type and name of each field of a definition; types of messages with full names.

    Raises:
        ConfigError: If a line is not understood.
    """
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        bare = line.partition("#")[0].strip()
        field = FIELD.fullmatch(bare)
        if not bare or (field is not None and (field["value"] or "").startswith(CONSTANT)):
            continue
        if field is None:
            raise ConfigError(f"line {number} of a message definition is not understood: {bare!r}")
        found.append((_full(field["type"], package) + (field["array"] or ""), field["name"]))
    return [row for row in found if row[1] != FILLER]


def _full(kind: str, package: str) -> str:
    if kind in BASIC:
        return SAME.get(kind, kind)
    parts = kind.split("/")
    if kind == "Header":  # short for that of std_msgs, as in ROS 1
        package = "std_msgs"
    return f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"


def layout(text: str, name: str) -> Layout:
    """Return the fields of a type and of those that it uses, from a schema ``ros2msg``.

    Args:
        text: Schema as `schema_text` returns it.
        name: Name of the type, like ``nav_msgs/msg/Path``.

    Raises:
        ConfigError: If it is not understood.
    """
    found: Layout = {}
    for part in re.split(r"^=+$\n?", text, flags=re.MULTILINE):
        if found:
            head, _, part = part.partition("\n")
            match = HEAD.fullmatch(head.strip())
            if match is None:
                raise ConfigError(f"the definition of {name} has {head!r} in place of 'MSG: TYPE'")
            kind = _full(match[1], "")
        else:
            kind = name
        if kind in found:
            raise ConfigError(f"the definition of {name} has {kind} twice")
        found[kind] = tuple(_fields(part, kind.split("/")[0]))
    return found


def check_definition(text: str, name: str) -> None:
    """Check that messages of a definition have the bytes of the installed type.

    Raises:
        ConfigError: If they have not, or the definition is not understood.
    """
    ours, theirs = layout(schema_text(name), name), layout(text, name)
    for kind in theirs:
        if kind not in ours:
            raise ConfigError(f"its definition has {kind}, which the installed {name} does not use")
        if ours[kind] != theirs[kind]:
            raise ConfigError(
                f"its definition of {kind} is not the installed one: {_shown(theirs[kind])}"
                f" instead of {_shown(ours[kind])}"
            )


def _shown(fields: tuple[tuple[str, str], ...]) -> str:
    return ", ".join(f"{kind} {name}" for kind, name in fields) or "no fields"


def _definition(name: str) -> str:
    package, kind, short = name.split("/")
    try:
        return (_share(package) / kind / f"{short}.msg").read_text(encoding="utf-8")
    except (PackageNotFoundError, OSError) as cause:
        raise ConfigError(f"the definition of {name} is not installed: {cause}") from cause


def _share(package: str) -> Path:
    # The wheels install to this environment without saying so to the ament index.
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(dict.fromkeys(filter(None, prefixes)))
    return Path(get_package_share_directory(package))
