"""Parameter files: defaults, the robot's data, the user's overrides for navigators and world."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from swarm_common.files.convert import convert, updated
from swarm_common.files.params_io import (
    SECTION,
    Flat,
    flatten,
    is_for,
    nest,
    read_parameter_file,
    typed,
)
from swarm_common.files.resources import share_directory
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.robot_parameters import robot_parameters
from swarm_common.model.schema import PoseNumbers
from swarm_common.model.sensors import IDEAL

NODE = "navigator"
EVERY_NAVIGATOR = "/*/navigator"  # section whose values win, as it comes last
WORLD_NODES = ("world", "sim/world")  # how a section may name it
BROKEN = "broken."
SENSORS = "sensors"
CENTRAL = "central"  # how a section names the centre


@dataclass(frozen=True, slots=True)
class WorldParams:
    """Parameters of the world that the user wants."""

    values: Mapping[str, Any] = field(default_factory=dict)  # by dotted name
    broken_map: Mapping[str, Pose] = field(default_factory=dict)  # of robots without a navigator
    sensors: Mapping[str, Any] = field(default_factory=dict)  # errors in place of the models'

    def settings(self) -> dict[str, Any]:
        """Return the values as the world process takes them."""
        values = nest({name: value for name, value in self.values.items() if value != ""})
        return values | ({SENSORS: dict(self.sensors)} if self.sensors else {})


@dataclass(frozen=True, slots=True)
class ParameterSource:
    """Which parameters the user's file sets, to name that file in complaints about its copies."""

    path: str = ""  # of the file, as people know it
    # names of parameters per pattern of node names, in the order of the file
    sections: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def located(self, message: str, copies: Path) -> str:
        """Return a complaint about a robot's parameter file in terms of the user's own file.

        Args:
            message: `FILE: what is wrong`, as the navigators say it.
            copies: Folder of the parameter files that are written for them.
        """
        begin = f"{copies}{os.sep}"
        robot, _, problem = message.removeprefix(begin).partition(".yaml: ")
        if not message.startswith(begin):
            return message
        named = set(re.findall(r"[a-z_0-9]+(?:\.[a-z_0-9]+)*", problem))
        for pattern, names in reversed([*self.sections.items()]):
            if is_for(pattern, f"/{robot}/{NODE}") and not named.isdisjoint(names):
                return f"{self.path}: {pattern}: {problem}"
        return message


@dataclass(frozen=True, slots=True)
class Overrides:
    """The user's --params file, checked: per pattern of node names, some parameters."""

    # parameters by dotted name, per pattern of node names, in the order of the file
    sections: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    world: WorldParams = field(default_factory=WorldParams)  # its section about the world
    path: str = ""  # of the file
    central: Mapping[str, Any] = field(default_factory=dict)  # parameters of a centre, unchecked

    @property
    def source(self) -> ParameterSource:
        """The file and what it sets, for messages."""
        names = {pattern: tuple(values) for pattern, values in self.sections.items()}
        return ParameterSource(self.path, names)

    def followed_by(self, parameters: Mapping[str, Any], known: Mapping[str, Any]) -> Overrides:
        """Return these and then parameters of all navigators, by dotted name.

        Args:
            known: Default of each parameter by dotted name.

        Raises:
            ConfigError: If a name or a type is wrong.
        """
        last = {name: typed(name, value, known, "parameters") for name, value in parameters.items()}
        sections = {**self.sections, EVERY_NAVIGATOR: last}
        return replace(self, sections=sections, path=self.path or "parameters")

    def for_robot(self, robot: str) -> Flat:
        """Return the parameters that the file sets for a robot; later sections win."""
        merged: Flat = {}
        for pattern, values in self.sections.items():
            if is_for(pattern, f"/{robot}/{NODE}"):
                merged.update(values)
        return merged


def load_overrides(path: Path, robots: list[str], known: Mapping[str, Any]) -> Overrides:
    """Return the overrides in a ROS 2 parameter file.

    Args:
        robots: Names of all robots; a section that fits none of them is an error.
        known: Default of each parameter by dotted name; gives the type too.

    Raises:
        ConfigError: If the file is not a parameter file, or a name or a type is wrong.
    """
    sections: dict[str, Flat] = {}
    world: WorldParams | None = None
    central: Flat = {}
    for pattern, values in read_parameter_file(path).items():
        where = f"{path}: {pattern}"
        if pattern.strip("/") in WORLD_NODES:
            if world is not None:
                raise ConfigError(f"{where}: the parameters of the world are given twice")
            world = parse_world(values, robots, where)
            continue
        if pattern.strip("/") == CENTRAL:
            central |= flatten(values, where)
            continue
        if not any(is_for(pattern, f"/{robot}/{NODE}") for robot in robots):
            names = ["/world", f"/{CENTRAL}", "/**", *(f"/{robot}/{NODE}" for robot in robots)]
            raise UnknownNameError("node", pattern, names, str(path))
        sections[pattern] = {
            name: typed(name, value, known, where) for name, value in values.items()
        }
    return Overrides(sections, world or WorldParams(), str(path), central)


def default_world_parameters() -> dict[str, Any]:
    """Return the world's parameters with their defaults, from `params/world.yaml`."""
    return read_parameter_file(share_directory("params") / "params" / "world.yaml")["/world"]


def parse_world(body: Mapping[str, Any], robots: Sequence[str], where: str) -> WorldParams:
    """Return the world's parameters.

    Args:
        body: Parameters in the section, nested or by dotted name.

    Raises:
        ConfigError: If a name is unknown or a value has the wrong type.
    """
    known = default_world_parameters()
    values: dict[str, Any] = {}
    broken: dict[str, Pose] = {}
    flat = flatten(body, where)
    of_sensors = {name: value for name, value in flat.items() if name.startswith(f"{SENSORS}.")}
    sensors = nest(of_sensors).get(SENSORS, {})
    updated(IDEAL, sensors, f"{where}: {SENSORS}")
    for name, value in flat.items():
        if name in of_sensors:
            continue
        if not name.startswith(BROKEN):
            values[name] = typed(name, value, known, where)
            continue
        robot = name.removeprefix(BROKEN)
        if robot not in robots:
            raise UnknownNameError("robot", robot, robots, f"{where}: broken")
        broken[robot] = Pose(*convert(value, PoseNumbers, f"{where}: {name}"))
    return WorldParams(values, broken, sensors)


def robot_parameter_file(
    robot: str, robot_id: int, spec: RobotSpec, initial_pose_map: Pose, values: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the parameter file of one navigator as a tree.

    Args:
        robot_id: From 1, in its beacons.
        spec: Robot model; its limits are the defaults of the controller's.
        initial_pose_map: Where it stands at the start.
        values: All other parameters by dotted name; they win.
    """
    flat: Flat = {
        "use_sim_time": True,
        "robot_id": robot_id,
        "initial_pose.x": initial_pose_map.x,
        "initial_pose.y": initial_pose_map.y,
        "initial_pose.yaw": initial_pose_map.yaw,
        **{f"robot.{name}": value for name, value in robot_parameters(spec).items()},
        **values,
    }
    return {f"/{robot}/{NODE}": {SECTION: nest(flat)}}


def write_parameter_file(path: Path, tree: Mapping[str, Any]) -> None:
    """Write a parameter file.

    Args:
        tree: Parameters as `robot_parameter_file` returns them.
    """
    dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # in C: ten times faster
    text = yaml.dump(dict(tree), Dumper=dumper, sort_keys=False)
    path.write_text(text, encoding="utf-8")
