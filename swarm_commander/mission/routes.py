"""Where missions lead each robot of a swarm, without ROS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from swarm_commander.mission.leg import Stop
from swarm_commander.mission.mission import Mission, load_mission
from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites


def routes(config: Mapping[str, Any]) -> list[tuple[Mission, list[Stop]]]:
    """Return each robot's mission and its goals in order.

    Args:
        config: As `RunPlan.runner_config` writes it.

    Returns:
        One per robot, in the order of `config["robots"]`; nothing without a mission.

    Raises:
        ConfigError: If a mission or the sites are unusable.
    """
    if config["mission"] is None:
        return []
    names = {robot["mission"] for robot in config["robots"]}
    missions = {name: load_mission(name) for name in sorted(names)}
    sites = load_sites(config["sites"]) if config["sites"] else Sites()
    homes = [Pose(*home) for home in config["homes"]]
    return [
        (
            missions[robot["mission"]],
            missions[robot["mission"]].stops(
                sites,
                homes[robot["number"] - 1],
                seed=config["seed"],
                robot_id=robot["number"],
                laps=config["laps"],
                limit=config["goals_per_robot"],
                homes_map=homes,
            ),
        )
        for robot in config["robots"]
    ]


def goals(config: Mapping[str, Any]) -> dict[str, list[tuple[float, float]]]:
    """Return the places where each robot's mission leads, each once.

    Args:
        config: As of `routes`.

    Returns:
        (x, y) [m] in map by name of the robot; nothing without a mission, or with an unusable one,
        which the mission process reports.
    """
    try:
        found = routes(config)
    except ConfigError:
        return {}
    names = [robot["name"] for robot in config["robots"]]
    return {
        name: list(dict.fromkeys((stop.pose_map.x, stop.pose_map.y) for stop in stops))
        for name, (_, stops) in zip(names, found, strict=False)
    }
