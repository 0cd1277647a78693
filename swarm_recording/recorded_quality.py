"""The offered quality of a recorded topic, as rosbag2's versions write it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import yaml

from swarm_common.model.errors import ConfigError

# Names from version 9 on, numbers of rmw before; what says nothing is the usual one.
RELIABILITY = {
    "reliable": True, 1: True, "best_effort": False, 2: False,
    "system_default": True, 0: True, "unknown": True, 3: True, "best_available": True, 4: True,
}  # fmt: skip
DURABILITY = {
    "transient_local": True, 1: True, "volatile": False, 2: False,
    "system_default": False, 0: False, "unknown": False, 3: False, "best_available": False,
    4: False,
}  # fmt: skip
HISTORY = {
    "keep_last": False, 1: False, "keep_all": True, 2: True,
    "system_default": False, 0: False, "unknown": False, 3: False,
}  # fmt: skip
MOST = 1000  # messages that a player keeps for latecomers
Offer = tuple[bool, bool, int]  # is reliable, is latched, depth


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
