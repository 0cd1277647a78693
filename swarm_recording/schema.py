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
TYPE = r"(?P<type>[A-Za-z]\w*(?:/\w+)*)(?:<=\d+)?(?:\[[^\]]*\])?"
FIELD = re.compile(rf"^\s*{TYPE}\s+[a-z]\w*(?!\s*=)")
BASIC = frozenset(
    "bool byte char float32 float64 int8 uint8 int16 uint16 int32 uint32 int64 uint64 string"
    " wstring".split()
)


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
    """Return the full names of the message types that a definition uses, in order."""
    found = []
    for line in text.splitlines():
        field = FIELD.match(line.split("#")[0].rstrip())
        if field is None or field["type"] in BASIC:
            continue
        parts = field["type"].split("/")
        found.append(f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}")
    return found


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
