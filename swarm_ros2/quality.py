"""Quality of service: arguments, and what to ask for to hear all publishers."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from rclpy.node import Node
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSPresetProfiles,
    QoSProfile,
    QoSReliabilityPolicy,
)

from swarm_ros2 import graph

RELIABLE, BEST_EFFORT = QoSReliabilityPolicy.RELIABLE, QoSReliabilityPolicy.BEST_EFFORT
KEPT, VOLATILE = QoSDurabilityPolicy.TRANSIENT_LOCAL, QoSDurabilityPolicy.VOLATILE
POLICIES: dict[str, tuple[Any, str]] = {  # with their help texts
    "history": (QoSHistoryPolicy, "History of samples setting"),
    "reliability": (QoSReliabilityPolicy, "Quality of service reliability setting"),
    "durability": (QoSDurabilityPolicy, "Quality of service durability setting"),
}


def add_arguments(parser: argparse.ArgumentParser, preset: str) -> None:
    """Add ros2cli's options for quality of service, which change the profile `preset`."""
    parser.set_defaults(qos_preset=preset)
    parser.add_argument(
        "--qos-profile",
        choices=QoSPresetProfiles.short_keys(),
        help=f"Quality of service preset profile (default: {preset})",
    )
    parser.add_argument("--qos-depth", metavar="N", type=int, help="Queue size setting")
    for name, (policy, text) in POLICIES.items():
        choices = [member.short_key for member in policy]
        parser.add_argument(f"--qos-{name}", choices=choices, help=text)


def from_arguments(options: argparse.Namespace) -> QoSProfile:
    """Return the profile that the options describe."""
    profile = QoSPresetProfiles.get_from_short_key(options.qos_profile or options.qos_preset)
    chosen = {name: getattr(profile, name) for name in ("depth", *POLICIES)}
    if options.qos_depth is not None:
        chosen["depth"] = options.qos_depth
    for name, (policy, _) in POLICIES.items():
        key = getattr(options, f"qos_{name}")
        if key is not None:
            chosen[name] = policy.get_from_short_key(key)
    return QoSProfile(**chosen)


def for_listening(node: Node, topic: str, options: argparse.Namespace) -> QoSProfile:
    """Return the profile that hears all publishers of a topic.

    What the user asked for is taken as it is. Otherwise reliable and transient local are asked
    for only if every publisher offers them; a first one gets the time to be discovered.
    """
    profile = from_arguments(options)
    names = ("profile", "depth", *POLICIES)
    if any(getattr(options, f"qos_{name}") is not None for name in names):
        return profile
    if not graph.wait_for(lambda: node.count_publishers(topic) > 0):
        return profile
    publishers = node.get_publishers_info_by_topic(topic)
    offers = [info.qos_profile for info in publishers]
    profile.reliability = _common([q.reliability for q in offers], RELIABLE, BEST_EFFORT)
    profile.durability = _common([q.durability for q in offers], KEPT, VOLATILE)
    return profile


def _common(offers: list[Any], strong: Any, weak: Any) -> Any:
    count = offers.count(strong)
    if 0 < count < len(offers):
        print(
            f"Some, but not all, publishers are offering {_name(strong)}. Falling back to"
            f" {_name(weak)} as it will connect to all publishers",
            file=sys.stderr,
        )
    return strong if count == len(offers) else weak


def _name(policy: Any) -> str:
    return f"{type(policy).__name__}.{policy.name}"
