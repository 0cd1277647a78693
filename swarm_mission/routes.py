"""Where missions lead each robot of a swarm, without ROS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import DEFAULT, RobotNames
from swarm_common.model.sites import Sites
from swarm_mission.leg import Stop
from swarm_mission.mission import Mission, load_mission

LOOKED_AT = 1000  # first goals of each robot whose places are told: missions may have millions


def routes(config: Mapping[str, Any]) -> list[tuple[Mission, list[Stop]]]:
    """Return each robot's mission and its goals in order.

    Args:
        config: Configuration as `RunPlan.runner_config` writes it.

    Returns:
        One per robot, in the order of `config["robots"]`, which have missions; where they have
        orders, all places that they may be sent to.

    Raises:
        ConfigError: If a mission or the sites are unusable.
    """
    names = {robot["mission"] for robot in config["robots"]}
    missions = {name: load_mission(name) for name in sorted(names)}
    sites = load_sites(config["sites"]) if config["sites"] else Sites()
    homes = [Pose(*home) for home in config["homes"]]
    robot_names = RobotNames.parse(config.get("names", DEFAULT))
    orders = next((each for each in missions.values() if each.orders is not None), None)
    if orders is not None:
        orders = orders.with_groups(sites)
        return [
            (orders, orders.order_stops(sites, homes[robot["number"] - 1]))
            for robot in config["robots"]
        ]
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
                names=robot_names,
            ),
        )
        for robot in config["robots"]
    ]


def goals(config: Mapping[str, Any]) -> dict[str, list[tuple[float, float]]]:
    """Return the places of each robot's first `LOOKED_AT` goals, each once.

    Args:
        config: Configuration as for `routes`.

    Returns:
        (x, y) [m] in map by name of the robot; nothing without a mission, or with an unusable one,
        which the mission process reports.
    """
    if config["mission"] is None:
        return {}
    most = min(config["goals_per_robot"] or LOOKED_AT, LOOKED_AT)
    try:
        found = routes({**config, "goals_per_robot": most})
    except ConfigError:
        return {}
    return {
        robot["name"]: list(dict.fromkeys((stop.pose_map.x, stop.pose_map.y) for stop in stops))
        for robot, (_, stops) in zip(config["robots"], found, strict=True)
    }
