"""Classes of messages by their names; messages as YAML text, and YAML text as messages."""

from __future__ import annotations

import argparse
import array
import importlib
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import yaml
from builtin_interfaces.msg import Time
from rosidl_parser.definition import (
    AbstractGenericString,
    AbstractNestedType,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)
from std_msgs.msg import Header

from swarm_common.model.errors import SwarmError

SEQUENCES = (list, tuple, array.array, np.ndarray)


def to_yaml(
    message: Any,
    *,
    longest: int | None = None,
    arrays: bool = True,
    strings: bool = True,
    flow: bool = False,
) -> str:
    """Return a message as YAML, fields in the order of the definition.

    Args:
        longest: Cut arrays and strings after this many elements; None for not at all.
        arrays: Write arrays; otherwise only their type and length.
        strings: Write strings; otherwise only their length.
        flow: One line with braces instead of one line per field.
    """
    plain = to_plain(message, longest=longest, arrays=arrays, strings=strings)
    text: str = yaml.dump(
        plain, allow_unicode=True, width=sys.maxsize, default_flow_style=flow, sort_keys=False
    )
    return text


def to_plain(
    value: Any,
    *,
    longest: int | None = None,
    arrays: bool = True,
    strings: bool = True,
    slot: Any = None,
) -> Any:
    """Return a message or a field of type `slot` as dicts, lists and numbers; see `to_yaml`."""
    if isinstance(value, bytes):
        value = value.decode("latin-1")
    if isinstance(value, str):
        return _plain_string(value, longest, strings=strings)
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (bool, int, float)):
        return value
    if isinstance(value, SEQUENCES):
        if not arrays and slot is not None:
            return _describe(value, slot)
        part = value if longest is None else value[:longest]
        items = [to_plain(x, longest=longest, arrays=arrays, strings=strings) for x in part]
        return [*items, "..."] if len(part) < len(value) else items
    return {
        name: to_plain(
            getattr(value, name), longest=longest, arrays=arrays, strings=strings, slot=kind
        )
        for name, kind in zip(value.get_fields_and_field_types(), value.SLOT_TYPES, strict=True)
    }


def _plain_string(value: str, longest: int | None, *, strings: bool) -> str:
    if not strings:
        return f"<string length: <{len(value)}>>"
    if longest is not None and len(value) > longest:
        return f"{value[:longest]}..."
    return value


def _describe(value: Any, slot: Any) -> str:
    name = _type_name(slot.value_type)
    if isinstance(slot, Array):
        return f"<array type: {name}[{slot.size}]>"
    bound = f"[{slot.maximum_size}]" if isinstance(slot, BoundedSequence) else ""
    return f"<sequence type: {name}{bound}, length: {len(value)}>"


def _type_name(kind: Any) -> str:
    if isinstance(kind, BasicType):
        return str(kind.typename)
    if isinstance(kind, AbstractGenericString):
        return "string"
    return "/".join(kind.namespaced_name())


def add_values(verb: argparse.ArgumentParser, name: str, what: str, example: str) -> None:
    """Add the argument with which a user fills a message, and `--stdin` instead of it."""
    group = verb.add_mutually_exclusive_group()
    group.add_argument(
        name, nargs="?", default="{}", help=f"{what} in YAML format (e.g. '{example}')"
    )
    group.add_argument("--stdin", action="store_true", help="Read values from standard input")


def given_values(options: argparse.Namespace, name: str) -> dict[str, Any]:
    """Return what a user fills a message with; see `add_values`."""
    return parse_values(sys.stdin.read() if options.stdin else getattr(options, name))


def parse_values(text: str) -> dict[str, Any]:
    """Read the YAML mapping with which a user fills a message."""
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise SwarmError(f"The passed value is not YAML: {error}") from error
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise SwarmError("The passed value needs to be a dictionary in YAML format")
    return values


Stamp = Callable[[Time], None]  # sets one time of a message


def fill(message: Any, values: dict[str, Any], stamps: list[Stamp] | None = None) -> None:
    """Set the fields of a message from plain values.

    Args:
        values: Field names to numbers, strings, lists or nested mappings.
        stamps: Receives what sets the times to be set at sending: a Header given as ``auto``, a
            Time given as ``now``. None: these words mean nothing.
    """
    slots = dict(zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True))
    for name, value in values.items():
        if name not in slots:
            raise SwarmError(
                f"Failed to populate field: '{type(message).__name__}' has no field '{name}';"
                f" it has {', '.join(slots)}"
            )
        current = getattr(message, name)
        if stamps is not None and isinstance(current, Header) and value == "auto":
            stamps.append(partial(setattr, current, "stamp"))
            continue
        if stamps is not None and isinstance(current, Time) and value == "now":
            stamps.append(partial(setattr, message, name))
            continue
        try:
            setattr(message, name, _from_plain(current, value, slots[name], stamps))
        except (AssertionError, TypeError, ValueError) as error:
            raise SwarmError(f"Failed to populate field: {name}: {error}") from error


def _from_plain(current: Any, value: Any, slot: Any, stamps: list[Stamp] | None) -> Any:
    """Return a plain value in the type of a field."""
    if isinstance(slot, NamespacedType):
        if not isinstance(value, dict):
            raise TypeError(f"{value!r} is not a mapping of {_type_name(slot)}'s fields")
        fill(current, value, stamps)
        return current
    if isinstance(slot, AbstractNestedType):
        kind = slot.value_type
        if not isinstance(kind, NamespacedType):
            return [_basic(item, kind) for item in value]
        return [_message(kind, item, stamps) for item in value]
    return _basic(value, slot)


def _message(kind: NamespacedType, values: Any, stamps: list[Stamp] | None) -> Any:
    if not isinstance(values, dict):
        raise TypeError(f"{values!r} is not a mapping of {_type_name(kind)}'s fields")
    message = load(kind.namespaces[-1], "/".join(kind.namespaced_name()))()
    fill(message, values, stamps)
    return message


def _basic(value: Any, kind: Any) -> Any:
    if isinstance(kind, AbstractGenericString):
        return str(value)
    if kind.typename in ("float", "double"):
        return float(value)
    if kind.typename == "octet":
        return bytes([value]) if isinstance(value, int) else value
    if kind.typename != "boolean" and isinstance(value, float):
        raise TypeError(f"{value} is not a whole number")
    return value


def load(kind: str, name: str) -> Any:
    """Import an interface class.

    Args:
        kind: `msg`, `srv` or `action`.
        name: For example `std_msgs/msg/String` or, as a short form, `std_msgs/String`.
    """
    package, _, rest = name.partition("/")
    type_name = rest.removeprefix(f"{kind}/")
    if not package or not type_name or "/" in type_name:
        raise SwarmError(
            f"The passed {_LONG[kind]} type is invalid: '{name}' is not of the form"
            f" package/{kind}/Name"
        )
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), type_name)
    except (ModuleNotFoundError, AttributeError) as error:
        raise SwarmError(
            f"The passed {_LONG[kind]} type is invalid: '{name}' is not installed here ({error})"
        ) from error


_LONG = {"msg": "message", "srv": "service", "action": "action"}
