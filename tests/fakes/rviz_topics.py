"""Topics that a configuration of RViz names."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class NamedTopic:
    """A topic that a configuration names: by which display or tool, and with which quality."""

    shown_by: str
    name: str
    reliability: str
    durability: str


def named_topics(config: Any, shown_by: str = "") -> list[NamedTopic]:
    """Return every topic that a configuration names."""
    if isinstance(config, list):
        return [found for item in config for found in named_topics(item, shown_by)]
    if not isinstance(config, dict):
        return []
    if "Reliability Policy" in config:
        quality = (config["Reliability Policy"], config["Durability Policy"])
        return [NamedTopic(shown_by, config["Value"], *quality)]
    kind = str(config.get("Class") or shown_by).split("/")[-1]
    return [found for item in config.values() for found in named_topics(item, kind)]
