"""`ros2 interface`: show, list, package, packages, proto."""

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
from swarm_ros2 import text
from swarm_ros2.verbs import add_flag, add_verb

INDEX = "rosidl_interfaces"
KINDS = {"msg": "Messages", "srv": "Services", "action": "Actions"}
FIELD = re.compile(
    r"^(?P<type>[A-Za-z]\w*(?:/\w+)*)(?:\[[^\]]*\])?\s+[a-z]\w*\s*(?:#.*|$|[^=\s].*)"
)


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 interface`."""
    # The wheels install to this environment without saying so to the ament index.
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, prefixes))
    for name, text_, run in (
        ("list", "List all interface types available", _list),
        ("package", "Output a list of available interface types within one package", _package),
        ("packages", "Output a list of packages that provide interfaces", _packages),
    ):
        verb = add_verb(verbs, name, text_, run)
        for kind, title in KINDS.items():
            only = f"Print out only the {title.lower()}"
            add_flag(verb, f"-{kind[0]}", f"--only-{kind}s", dest=kind, help=only)
        if name == "package":
            verb.add_argument("package_name", help="Name of the ROS package (e.g. 'std_msgs')")
    kind = "An interface (e.g. 'std_msgs/msg/String')"
    verb = add_verb(verbs, "proto", "Output an interface prototype", _proto, type=kind)
    add_flag(verb, "--no-quotes", help="Output has no outer quotes")
    kind = "Show an interface definition (e.g. 'std_msgs/msg/String')"
    verb = add_verb(verbs, "show", "Output the interface definition", _show, type=kind)
    group = verb.add_mutually_exclusive_group()
    add_flag(group, "--no-comments", help="Show no comments")
    add_flag(group, "--all-comments", help="Also those of nested types")


def _list(options: argparse.Namespace) -> None:
    names = [name for package in get_resources(INDEX) for name in _names(package)]
    for kind in _wanted(options):
        print(f"{KINDS[kind]}:")
        print("\n".join(f"    {name}" for name in sorted(names) if f"/{kind}/" in name))


def _package(options: argparse.Namespace) -> None:
    package, wanted = options.package_name, _wanted(options)
    if package not in get_resources(INDEX):
        raise SwarmError(f"Unknown package '{package}'")
    print("\n".join(name for name in sorted(_names(package)) if name.split("/")[1] in wanted))


def _packages(options: argparse.Namespace) -> None:
    wanted = _wanted(options)
    for package in sorted(get_resources(INDEX)):
        if any(name.split("/")[1] in wanted for name in _names(package)):
            print(package)


def _proto(options: argparse.Namespace) -> None:
    _definition(options.type)  # for the message if there is none
    kind = options.type.split("/")[1]
    found = text.load(kind, options.type)
    found = {
        "msg": found,
        "srv": getattr(found, "Request", None),
        "action": getattr(found, "Goal", None),
    }[kind]
    prototype = text.to_yaml(found())
    print(prototype if options.no_quotes else f'"{prototype}"')


def _names(package: str) -> list[str]:
    lines = get_resource(INDEX, package)[0].splitlines()
    return [f"{package}/{Path(line).with_suffix('')}" for line in lines if line.endswith(".idl")]


def _wanted(options: argparse.Namespace) -> list[str]:
    return [kind for kind in KINDS if getattr(options, kind)] or list(KINDS)


def _show(options: argparse.Namespace) -> None:
    comments, nested = not options.no_comments, options.all_comments
    print("\n".join(_lines(options.type, comments=comments, nested=nested)))


def _lines(name: str, *, comments: bool, nested: bool, indent: str = "") -> list[str]:
    """Return a definition's lines with those of its fields' types below each field.

    `comments` shows its own comments, `nested` those of its fields' types.
    """
    lines = []
    package = name.split("/")[0]
    for raw in _definition(name).splitlines():
        line = raw if comments else raw.split("#")[0].rstrip()
        if line or (comments and not indent):
            lines.append(indent + line)
        if kind := _type_of(line, package):
            lines += _lines(kind, comments=nested, nested=nested, indent=indent + "\t")
    return lines


def _type_of(line: str, package: str) -> str | None:
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
