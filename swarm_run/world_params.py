"""The section `/world:` of a --params file: radio, engine, robots that are broken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from swarm_common.files.convert import convert, updated
from swarm_common.files.params_io import flatten, read_parameter_file
from swarm_common.files.resources import share_directory
from swarm_common.model.errors import UnknownNameError
from swarm_common.model.records import Pose
from swarm_common.model.schema import PoseNumbers
from swarm_common.model.sensors import IDEAL
from swarm_run.flat import nest, typed

WORLD_NODES = ("world", "sim/world")  # how a section may name it
BROKEN = "broken."
SENSORS = "sensors"


@dataclass(frozen=True, slots=True)
class WorldParams:
    """Parameters of the world that the user wants.

    Attributes:
        values: Parameters by dotted name, without those of broken robots.
        broken_map: By name, where robots stand that have no navigator.
        sensors: Errors of all robots' sensors in place of their models'.
    """

    values: Mapping[str, Any] = field(default_factory=dict)
    broken_map: Mapping[str, Pose] = field(default_factory=dict)
    sensors: Mapping[str, Any] = field(default_factory=dict)

    def settings(self) -> dict[str, Any]:
        """Return the values as the world process takes them."""
        values = nest({name: value for name, value in self.values.items() if value != ""})
        return values | ({SENSORS: dict(self.sensors)} if self.sensors else {})


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
