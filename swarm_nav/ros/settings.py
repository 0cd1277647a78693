"""A navigator's parameter file: what is fixed at the start, and the brain's parameters."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_common.files.params_io import is_for, read_parameter_file
from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.robot_names import DEFAULT, RobotNames
from swarm_common.model.robot_parameters import frames_from_parameter, robot_from_parameters
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig, config_from_parameters, parameter_values
from swarm_nav.core.plugins import check_plugins

NODE = "navigator"
USE_SIM_TIME = "use_sim_time"
ROBOT_PREFIX = "robot."
LIMITED = ("max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "max_vel_y", "acc_lim_y")
FIXED: dict[str, Any] = {
    USE_SIM_TIME: True,
    "robot_id": 0,
    "robot_names": DEFAULT,
    "initial_pose.x": 0.0,
    "initial_pose.y": 0.0,
    "initial_pose.yaw": 0.0,
    "sites": "",
    "frames": "",
    "map_sha256": "",
    "autostart": True,
    "wait_for_mission": False,
    "wait_for_courier": False,
    "on_demand": False,
    "with_lidar": True,
}
FIXED_EFFECTS = {
    USE_SIM_TIME: "time is that of /clock",
    "robot_id": "from 1, in beacons",
    "robot_names": "names of all robots by id, for messages: a list, and a pattern for the rest",
    "initial_pose.x": "[m] in map, where odometry began",
    "initial_pose.y": "[m] in map, where odometry began",
    "initial_pose.yaw": "[rad] in map, where odometry began",
    "sites": "file with the world's named places",
    "frames": "links that are fixed to base_footprint: x, y, z [m] and quaternion of each, in JSON",
    "map_sha256": "digest of the only map that is taken at first; empty for any",
    "autostart": "be active as soon as there is a map",
    "wait_for_mission": "withhold the answers to ticks until a mission has given its goal",
    "wait_for_courier": "withhold the answer to each tick until a courier has released it",
    "on_demand": "create what few clients use when the first of them appears",
    "with_lidar": "ticks bring scans",
}


@dataclass(frozen=True, slots=True)
class NodeSettings:
    """Settings with which one navigator node is started."""

    name: str  # namespace
    config: NavConfig  # parameters of the brain, changeable while it runs
    spec: RobotSpec
    fixed: Mapping[str, Any]  # parameters that are read once, by ROS name

    @property
    def robot_id(self) -> int:
        """Number of the robot in beacons, from 1."""
        return int(self.fixed["robot_id"])

    @property
    def names(self) -> RobotNames:
        """Names of all robots."""
        return RobotNames.parse(str(self.fixed["robot_names"]))

    @property
    def sites(self) -> Sites:
        """Named places of the world; read once for all robots of a process."""
        path = str(self.fixed["sites"])
        return _sites_in(path) if path else Sites()

    @property
    def frames(self) -> dict[str, tuple[float, ...]]:
        """Place of each fixed link in base_footprint: x, y, z [m] and quaternion x, y, z, w."""
        return _frames_in(str(self.fixed["frames"]))

    @property
    def initial_pose_map(self) -> Pose:
        """Pose of the robot in map when its odometry began."""
        return Pose(*(float(self.fixed[f"initial_pose.{name}"]) for name in ("x", "y", "yaw")))


@functools.cache
def _sites_in(path: str) -> Sites:
    return load_sites(path)


_frames_in = functools.cache(frames_from_parameter)  # equal robots share them


def read_node_settings(name: str, path: str | Path) -> NodeSettings:
    """Return the settings of a robot's navigator in a ROS 2 parameter file.

    Args:
        name: Name of the robot, like Srobot3; sections of other robots are ignored.

    Raises:
        SwarmError: If the file cannot be read, or a parameter is missing, unknown, of the wrong
            type or impossible.
    """
    values: dict[str, Any] = {}
    for pattern, given in read_parameter_file(Path(path)).items():
        if is_for(pattern, f"/{name}/{NODE}"):
            values |= given
    return parse_node_settings(name, values, str(path))


def parse_node_settings(name: str, values: Mapping[str, Any], where: str) -> NodeSettings:
    """Return the settings in flat parameters.

    Args:
        values: By flat name: those of `FIXED`, of the brain, and of the robot model with its
            prefix.
        where: Origin of the values, for messages.

    Raises:
        SwarmError: If a parameter is missing, unknown, of the wrong type or impossible.
    """
    robot = {key: value for key, value in values.items() if key.startswith(ROBOT_PREFIX)}
    own = {key: value for key, value in values.items() if key in FIXED}
    rest = {key: value for key, value in values.items() if key not in robot and key not in own}
    known = parameter_values(NavConfig())
    for key in rest:
        if key not in known:
            raise UnknownNameError("parameter", key, [*known, *FIXED], where)
    fixed = FIXED | {key: _typed(key, value, FIXED[key], where) for key, value in own.items()}
    spec = robot_from_parameters(
        {key.removeprefix(ROBOT_PREFIX): value for key, value in robot.items()}
    )
    _frames_in(fixed["frames"])
    try:
        RobotNames.parse(fixed["robot_names"])
    except ConfigError as error:
        raise ConfigError(f"{where}: robot_names: {error}") from None
    if fixed["robot_id"] < 1:
        raise ConfigError(f"{where}: robot_id is {fixed['robot_id']}; it must be 1 or more")
    try:
        config = config_from_parameters(rest, where=where)
        check_limits(config, spec)
        check_plugins(config)
    except UnknownNameError:
        raise
    except ConfigError as error:
        message = str(error)
        raise ConfigError(message if where in message else f"{where}: {message}") from None
    return NodeSettings(name, config, spec, fixed)


def check_limits(config: NavConfig, spec: RobotSpec) -> None:
    """Refuse a controller that asks for more than the robot can do.

    Raises:
        ConfigError: Naming the limit.
    """
    for name in LIMITED:
        value, limit = getattr(config.controller, name), getattr(spec, name)
        if value > limit * (1.0 + 1e-6):
            raise ConfigError(f"{name} is {value}; a {spec.model} reaches {limit}")


def _typed(name: str, value: Any, default: Any, where: str) -> Any:
    if isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if type(value) is not type(default):
        raise ConfigError(
            f"{where}: parameter '{name}' is {value!r} ({type(value).__name__});"
            f" it must be a {type(default).__name__}"
        )
    return value
