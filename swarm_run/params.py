"""Parameter files of the navigators: defaults, the robot's data, the user's overrides."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from swarm_common.files.params_io import SECTION, Flat, flatten, is_for, read_parameter_file
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.robot_parameters import robot_parameters
from swarm_run.flat import nest, typed
from swarm_run.world_params import WORLD_NODES, WorldParams, parse_world

NODE = "navigator"
EVERY_NAVIGATOR = "/*/navigator"  # section whose values win, as it comes last
CENTRAL = "central"  # how a section names the centre


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


class Overrides:
    """The user's --params file: per pattern of node names, some parameters.

    Attributes:
        world: Its section about the world.
        central: Its section about a centre, which the centre itself checks.
        sections: Parameters by dotted name, per pattern of node names, in the order of the file.
        source: The file and what it sets, for messages.
    """

    def __init__(
        self,
        sections: Mapping[str, Mapping[str, Any]],
        world: WorldParams | None = None,
        path: Path = Path(),
        central: Mapping[str, Any] | None = None,
    ) -> None:
        """Keep the sections of a file that has been checked.

        Args:
            sections: Parameters by dotted name, per pattern of node names, in the order of the
                file.
            world: None for the defaults.
            central: Parameters of a centre by name, unchecked.
        """
        self.world = world or WorldParams()
        self.central = dict(central or {})
        self.sections = dict(sections)
        names = {pattern: tuple(values) for pattern, values in sections.items()}
        self.source = ParameterSource(str(path), names)

    def followed_by(self, parameters: Mapping[str, Any], known: Mapping[str, Any]) -> Overrides:
        """Return these and then parameters of all navigators, by dotted name.

        Args:
            known: Default of each parameter by dotted name.

        Raises:
            ConfigError: If a name or a type is wrong.
        """
        last = {name: typed(name, value, known, "parameters") for name, value in parameters.items()}
        sections = {**self.sections, EVERY_NAVIGATOR: last}
        return Overrides(sections, self.world, Path(self.source.path or "parameters"), self.central)

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
    return Overrides(sections, world, path, central)


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
