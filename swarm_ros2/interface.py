"""`ros2 interface`: show, list."""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from typing import Any

from ament_index_python import get_package_share_directory, get_resource, get_resources
from ament_index_python.packages import PackageNotFoundError

from swarm_common.model.errors import SwarmError

KINDS = {"msg": "Messages", "srv": "Services", "action": "Actions"}
FIELD = re.compile(
    r"^(?P<type>[A-Za-z]\w*(?:/\w+)*)(?:\[[^\]]*\])?\s+[a-z]\w*\s*(?:#.*|$|[^=\s].*)"
)


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 interface`."""
    # The wheels install to this environment without saying so to the ament index.
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, prefixes))
    verb = verbs.add_parser("list", help="List all interface types available")
    for kind, title in KINDS.items():
        verb.add_argument(
            f"-{kind[0]}",
            f"--only-{kind}s",
            action="store_true",
            dest=kind,
            help=f"Print out only the {title.lower()}",
        )
    verb.set_defaults(run=_list)
    verb = verbs.add_parser("show", help="Output the interface definition")
    verb.add_argument("type", help="Show an interface definition (e.g. 'std_msgs/msg/String')")
    verb.add_argument("--no-comments", action="store_true", help="Show no comments")
    verb.set_defaults(run=_show)


def _list(options: argparse.Namespace) -> None:
    names = [
        f"{package}/{Path(line).with_suffix('')}"
        for package in get_resources("rosidl_interfaces")
        for line in get_resource("rosidl_interfaces", package)[0].splitlines()
        if line.endswith(".idl")
    ]
    wanted = [kind for kind in KINDS if getattr(options, kind)] or list(KINDS)
    for kind in wanted:
        print(f"{KINDS[kind]}:")
        print("\n".join(f"    {name}" for name in sorted(names) if f"/{kind}/" in name))


def _show(options: argparse.Namespace) -> None:
    for line in _lines(options.type, comments=not options.no_comments):
        print(line)


def _lines(name: str, *, comments: bool, indent: str = "") -> list[str]:
    """Return a definition's lines with those of its fields' types below each field."""
    lines = []
    package = name.split("/")[0]
    for raw in _definition(name).splitlines():
        line = raw if comments else raw.split("#")[0].rstrip()
        if indent and (not line or line.startswith("#")):
            continue
        if line or comments:
            lines.append(indent + line)
        nested = _nested(line, package)
        if nested:
            lines += _lines(nested, comments=False, indent=indent + "\t")
    return lines


def _nested(line: str, package: str) -> str | None:
    """Return the full name of the message type of a field, None for basic types."""
    field = FIELD.match(line)
    if field is None or ("/" not in field["type"] and field["type"][0].islower()):
        return None
    parts = field["type"].split("/")
    return f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"


def _definition(name: str) -> str:
    parts = name.split("/")
    if len(parts) != 3 or parts[1] not in KINDS:
        raise SwarmError(f"Invalid name '{name}'. Expected the form package/msg/Name")
    try:
        share = Path(get_package_share_directory(parts[0]))
        return (share / parts[1] / f"{parts[2]}.{parts[1]}").read_text()
    except (PackageNotFoundError, OSError) as error:
        raise SwarmError(f"Could not find the interface '{name}'") from error
