"""Parameters under dotted names, as ROS 2 counts them, and nested, as files have them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from swarm_common.model.errors import ConfigError, UnknownNameError


def nest(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted parameters as the nested mapping of a parameter file."""
    tree: dict[str, Any] = {}
    for name, value in flat.items():
        *groups, key = name.split(".")
        node = tree
        for group in groups:
            node = node.setdefault(group, {})
        node[key] = value
    return tree


def typed(name: str, value: Any, known: Mapping[str, Any], where: str) -> Any:
    """Return a parameter's value, an integer as float where the default is one.

    Args:
        known: Default of each parameter by dotted name; gives the type too.
        where: Section of the file, for the message.

    Raises:
        ConfigError: If the name is unknown or the type is not that of the default.
    """
    if name not in known:
        raise UnknownNameError("parameter", name, known, where)
    expected = type(known[name])
    if expected is float and type(value) is int:
        return float(value)
    if type(value) is not expected:
        raise ConfigError(
            f"{where}: parameter '{name}' is {value!r} ({type(value).__name__});"
            f" expected a {expected.__name__} like {known[name]!r}"
        )
    return value
