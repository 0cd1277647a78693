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


def add_arguments(parser: argparse.ArgumentParser, preset: str) -> None:
    """Add ros2cli's options for quality of service, which change the profile `preset`."""
    parser.set_defaults(qos_preset=preset)
    parser.add_argument(
        "--qos-profile",
        choices=QoSPresetProfiles.short_keys(),
        help=f"Quality of service preset profile (default: {preset})",
    )
    parser.add_argument("--qos-depth", metavar="N", type=int, help="Queue size setting")
    parser.add_argument(
        "--qos-history",
        choices=[p.short_key for p in QoSHistoryPolicy],
        help="History of samples setting",
    )
    parser.add_argument(
        "--qos-reliability",
        choices=[p.short_key for p in QoSReliabilityPolicy],
        help="Quality of service reliability setting",
    )
    parser.add_argument(
        "--qos-durability",
        choices=[p.short_key for p in QoSDurabilityPolicy],
        help="Quality of service durability setting",
    )


def from_arguments(options: argparse.Namespace) -> QoSProfile:
    """Return the profile that the options describe."""
    profile = QoSPresetProfiles.get_from_short_key(options.qos_profile or options.qos_preset)
    changes: dict[str, Any] = {
        "depth": options.qos_depth,
        "history": _policy(QoSHistoryPolicy, options.qos_history),
        "reliability": _policy(QoSReliabilityPolicy, options.qos_reliability),
        "durability": _policy(QoSDurabilityPolicy, options.qos_durability),
    }
    chosen = {name: getattr(profile, name) for name in changes}
    chosen |= {name: value for name, value in changes.items() if value is not None}
    return QoSProfile(**chosen)


def for_listening(node: Node, topic: str, options: argparse.Namespace) -> QoSProfile:
    """Return the profile that hears all publishers of a topic.

    What the user asked for is taken as it is. Otherwise reliable and transient local are asked
    for only if every publisher offers them; a first one gets the time to be discovered.
    """
    profile = from_arguments(options)
    given = (
        options.qos_profile,
        options.qos_depth,
        options.qos_history,
        options.qos_reliability,
        options.qos_durability,
    )
    if any(value is not None for value in given):
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


def _policy(kind: Any, short_key: str | None) -> Any:
    return None if short_key is None else kind.get_from_short_key(short_key)


def _name(policy: Any) -> str:
    return f"{type(policy).__name__}.{policy.name}"
