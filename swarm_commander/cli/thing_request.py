"""The request with which `swarm-commander spawn` adds an object to the world."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from simulation_interfaces.srv import SpawnEntity

from swarm_common.middleware import ros_io
from swarm_common.middleware.ros_io import resource_in
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose

GROUND = "ground"  # frame id: x, y and yaw in the map, z such that the thing stands on the ground
MODEL = """<sdf version="1.7"><model name="{name}"><static>{static}</static><link name="link">
<inertial><mass>{mass}</mass></inertial>
<collision name="collision"><geometry>{shape}</geometry></collision></link></model></sdf>"""


def thing_request(
    name: str,
    source: str,
    box: tuple[float, float, float] | None,
    cylinder: tuple[float, float] | None,
    mass: float | None,
    pose: tuple[float, float, float] | None,
) -> Any:
    """Return a request for `/sim/spawn_entity`.

    Args:
        name: Name of the object; empty for the name of its model.
        source: Path of an SDF or URDF, or a URI; empty for a box or a cylinder.
        box: Edges [m].
        cylinder: Radius and height [m].
        mass: [kg] of a box or cylinder that can be pushed; None if it stands.

    Raises:
        ConfigError: If the values contradict each other or are impossible.
    """
    given = [option for option in (source or None, box, cylinder) if option is not None]
    if len(given) > 1:
        raise ConfigError("--object, --box and --cylinder exclude each other; give one of them")
    if pose is None:
        raise ConfigError("a thing needs a place; give --pose X Y YAW")
    if source and mass is not None:
        raise ConfigError("--mass is for --box and --cylinder; the file of an --object says it")
    if source and _is_path(source) and not Path(source).exists():
        raise ConfigError(f"--object {source}: there is no such file")
    request = SpawnEntity.Request(name=name, allow_renaming=not name)
    request.initial_pose.header.frame_id = GROUND
    request.initial_pose.pose = ros_io.pose_msg(Pose(*pose))
    if source:
        resource_in(request).uri = str(Path(source).absolute()) if _is_path(source) else source
    else:
        resource_in(request).resource_string = _model(box, cylinder, mass)
    return request


def _is_path(source: str) -> bool:
    return "://" not in source


def _model(
    box: tuple[float, float, float] | None, cylinder: tuple[float, float] | None, mass: float | None
) -> str:
    numbers = (*(box or ()), *(cylinder or ()), 1.0 if mass is None else mass)
    if not all(math.isfinite(number) and number > 0.0 for number in numbers):
        raise ConfigError("edges, radius, height [m] and mass [kg] must be positive numbers")
    name, shape = "box", ""
    if box is not None:
        shape = f"<box><size>{box[0]} {box[1]} {box[2]}</size></box>"
    elif cylinder is not None:
        name = "cylinder"
        shape = f"<cylinder><radius>{cylinder[0]}</radius><length>{cylinder[1]}</length></cylinder>"
    static = "true" if mass is None else "false"
    return MODEL.format(name=name, static=static, mass=numbers[-1], shape=shape)
