"""Reading of `sites.yaml`: stations, holding circuits and the spawn area of a world."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from swarm_common.errors import ConfigError
from swarm_common.records import Pose
from swarm_common.sites import Sites, SpawnArea
from swarm_common.yaml_io import check_keys, number, numbers, read_yaml

SECTIONS = ("stations", "circuits", "spawn")


def load_sites(path: str | Path) -> Sites:
    """Return the sites in a file.

    Raises:
        ConfigError: If the file is malformed; the message names file and key.
    """
    path = Path(path)
    data = read_yaml(path)
    check_keys(data, SECTIONS, str(path))
    stations = _section(data, "stations", path)
    circuits = _section(data, "circuits", path)
    return Sites(
        stations={
            str(name): Pose(*numbers(value, 3, f"{path}: stations.{name} [x, y, yaw]"))
            for name, value in stations.items()
        },
        circuits={
            str(name): _circuit(value, f"{path}: circuits.{name}")
            for name, value in circuits.items()
        },
        spawn=_spawn(data["spawn"], f"{path}: spawn") if data.get("spawn") else None,
    )


def _section(data: dict[str, Any], name: str, path: Path) -> dict[str, Any]:
    section = data.get(name) or {}
    if not isinstance(section, dict):
        raise ConfigError(f"{path}: {name} is {section!r}; expected 'name: value' lines")
    return section


def _circuit(value: object, what: str) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list) or len(value) < 3:
        raise ConfigError(f"{what} is {value!r}; expected a list of at least 3 points [x, y]")
    points = [numbers(point, 2, f"{what}[{index}]") for index, point in enumerate(value)]
    return tuple((x, y) for x, y in points)


def _spawn(value: object, what: str) -> SpawnArea:
    if not isinstance(value, dict):
        raise ConfigError(f"{what} is {value!r}; expected x_min, y_min, x_max, y_max")
    known = [field.name for field in fields(SpawnArea)]
    check_keys(value, known, what)
    missing = [name for name in known[:4] if name not in value]
    if missing:
        raise ConfigError(f"{what} lacks {', '.join(missing)}")
    area = SpawnArea(**{key: number(item, f"{what}.{key}") for key, item in value.items()})
    if area.x_max < area.x_min or area.y_max < area.y_min or area.pitch <= 0.0:
        raise ConfigError(f"{what} is empty: {area}; expected x_min <= x_max, y_min <= y_max")
    return area
