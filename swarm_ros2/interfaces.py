"""Python classes of interfaces by their ROS names."""

from __future__ import annotations

import importlib
from typing import Any

from swarm_common.model.errors import SwarmError


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
