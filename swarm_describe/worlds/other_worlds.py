"""Floor plans, maps and worlds of other programs: what a file is, and how to make a world of it."""

from __future__ import annotations

import enum
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError, SwarmError

YAML = (".yaml", ".yml")
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".gif", ".pgm", ".ppm", ".pnm", ".tif", ".tiff")
PLANS = (*YAML, *PICTURES, ".map")
DRAW = "draw its walls as a floor plan (docs/creating.md), or as a picture, and make a world of it"


class YamlKind(enum.Enum):
    """Kind of content of a YAML file; the value completes "FILE is ..."."""

    PLAN = "a floor plan"
    NAV2_MAP = "a map of Nav2's"
    RMF = "a building of Open-RMF's"
    FLATLAND = "a world of flatland's"
    IR_SIM = "a world of ir-sim's"


def yaml_kind(path: Path) -> YamlKind:
    """Return the kind of a YAML file, by its keys; an unknown one counts as a floor plan."""
    try:
        data = read_yaml(path)
    except SwarmError:  # whoever reads it as a plan tells what is wrong with it
        return YamlKind.PLAN
    if "image" in data and ("resolution" in data or "origin" in data):
        return YamlKind.NAV2_MAP
    if "levels" in data or "building_name" in data:
        return YamlKind.RMF
    if "layers" in data:
        return YamlKind.FLATLAND
    if "world" in data or "robot" in data or "obstacle" in data:
        return YamlKind.IR_SIM
    return YamlKind.PLAN


def check_plan_kind(path: Path) -> None:
    """Raise if a YAML file is no floor plan, with the way from it to a world.

    Raises:
        ConfigError: If it is a world or a building of another program.
    """
    kind = yaml_kind(path)
    if kind is not YamlKind.PLAN:
        raise ConfigError(f"{path} is {kind.value}; {_way(path, kind)}")


def refuse_plan(path: Path) -> None:
    """Raise if a file that is given as a world has to be made into one first.

    Raises:
        ConfigError: With the command that makes a world of it.
    """
    suffix = path.suffix.lower()
    if suffix not in PLANS:
        return
    kind = yaml_kind(path) if suffix in YAML else YamlKind.PLAN
    raise ConfigError(f"{path} is {kind.value}; {_way(path, kind)}")


def _way(path: Path, kind: YamlKind) -> str:
    """Return how a file becomes a world."""
    name = shlex.quote(str(path))
    if kind is YamlKind.RMF:
        return (
            "with Open-RMF installed, 'ros2 run rmf_building_map_tools building_map_generator "
            f"gazebo {name} building.world models' makes a world of it; give building.world"
        )
    if kind is YamlKind.FLATLAND:
        maps = [path.parent / name for name in _maps_of_layers(read_yaml(path))]
        usable = [file for file in maps if file.is_file() and yaml_kind(file) is YamlKind.NAV2_MAP]
        return _build(usable[0], "the map of its layer") if usable else DRAW
    if kind is YamlKind.IR_SIM:
        pictures = [path.parent / name for name in _pictures_of_obstacles(read_yaml(path))]
        usable = [file for file in pictures if file.is_file()]
        return _build(usable[0], "its obstacle_map") if usable else DRAW
    return _build(path, "it")


def _build(path: Path, what: str) -> str:
    first = " first" if what == "it" else ""
    return f"build a world of {what}{first}: swarm-map new {shlex.quote(str(path))}"


def _maps_of_layers(data: Mapping[str, Any]) -> list[str]:
    layers = data["layers"] if isinstance(data["layers"], list) else []
    maps = [layer.get("map") for layer in layers if isinstance(layer, dict)]
    return [name for name in maps if isinstance(name, str)]


def _pictures_of_obstacles(data: Mapping[str, Any]) -> list[str]:
    world = data.get("world")
    found = world.get("obstacle_map") if isinstance(world, dict) else None
    if isinstance(found, dict):
        found = found.get("path")
    return [found] if isinstance(found, str) else []
