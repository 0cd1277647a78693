"""Reading of zones: the section `zones:` of `sites.yaml`, and Nav2's filter masks.

A mask is a map file of Nav2 with `type`, `base` and `multiplier` of CostmapFilterInfo in it, or
beside its name in `sites.yaml`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from swarm_common.files.map_io import load_map
from swarm_common.files.yaml_io import check_keys, number, numbers, read_yaml
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import UNKNOWN, Grid
from swarm_common.model.zones import NO_ZONES, KeepoutZone, Points, SpeedMask, SpeedZone, Zones

KEEPOUT_MASK, SPEED_MASK = MASKS = ("keepout_mask", "speed_mask")
SECTIONS = ("keepout", "speed", *MASKS)
KEEPOUT_TYPE, PERCENT_TYPE, ABSOLUTE_TYPE = range(3)  # CostmapFilterInfo.type
FILTER_INFO = {"type": None, "base": 0.0, "multiplier": 1.0}  # Nav2's defaults


def parse_zones(value: object, path: Path, masks: Mapping[str, Path]) -> Zones:
    """Return the zones of a sites file.

    Args:
        path: Sites file; masks are relative to its folder.
        masks: Files of masks, by key, that replace those of the sites file.
    """
    where = f"{path}: zones"
    if value is None and not masks:
        return NO_ZONES
    data = {} if value is None else value
    if not isinstance(data, dict):
        raise ConfigError(f"{where} is {value!r}; expected {', '.join(SECTIONS)}")
    check_keys(data, SECTIONS, where)
    entries = {key: data[key] for key in MASKS if data.get(key) is not None}
    entries |= {key: str(mask.absolute()) for key, mask in masks.items()}
    notes: list[str] = []
    zones = Zones(
        keepout=tuple(
            KeepoutZone(_name(item, what), _polygon(item, what))
            for item, what in _entries(data, "keepout", ("name", "points"), where)
        ),
        speed=tuple(
            SpeedZone(_name(item, what), _polygon(item, what), *_limit(item, what))
            for item, what in _entries(
                data, "speed", ("name", "points", "limit", "percentage"), where
            )
        ),
        keepout_mask=_keepout_mask(entries.get(KEEPOUT_MASK), path, where),
        speed_mask=_speed_mask(entries.get(SPEED_MASK), path, where, notes),
        notes=tuple(notes),
    )
    for kind in (zones.keepout, zones.speed):
        names = [zone.name for zone in kind]
        for name in names:
            if names.count(name) > 1:
                raise ConfigError(f"{where}: two zones are called '{name}'; names are unique")
    return zones


def copy_masks(path: Path, masks: Mapping[str, Path], folder: Path) -> dict[str, Any] | None:
    """Copy the masks of a sites file; return its content with the copies, None without masks."""
    data = read_yaml(path, may_be_empty=True) if path.is_file() else {}
    zones = dict(data.get("zones") or {}) | {k: str(mask.absolute()) for k, mask in masks.items()}
    entries = {key: zones[key] for key in MASKS if zones.get(key) is not None}
    if not entries:
        return None
    for key, entry in entries.items():
        file = mask_file(entry, path)
        content = read_yaml(file)
        image = file.parent / content["image"]
        copy = folder / key / file.name
        copy.parent.mkdir(parents=True)
        (copy.parent / image.name).write_bytes(image.read_bytes())
        copy.write_text(yaml.safe_dump(content | {"image": image.name}), encoding="utf-8")
        name = str(copy.relative_to(folder))
        zones[key] = entry | {"mask": name} if isinstance(entry, dict) else name
    return data | {"zones": zones}


def mask_file(entry: object, path: Path) -> Path:
    """Return the map file of a mask.

    Args:
        entry: Value of `keepout_mask` or `speed_mask`: a file name, or a mapping with one.
    """
    name = entry.get("mask") if isinstance(entry, dict) else entry
    if not isinstance(name, str) or not name:
        raise ConfigError(
            f"{path}: zones: a mask is {entry!r}; expected a map file, or {{mask: FILE, type: ..., "
            "base: ..., multiplier: ...}"
        )
    return path.parent / name


def _entries(
    data: Mapping[str, Any], key: str, known: tuple[str, ...], where: str
) -> list[tuple[dict[str, Any], str]]:
    """Return the zones of one kind, each with its place for messages."""
    items = data.get(key) or []
    if not isinstance(items, list):
        raise ConfigError(f"{where}.{key} is {items!r}; expected a list of zones")
    found = []
    for index, item in enumerate(items):
        what = f"{where}.{key}[{index}]"
        if not isinstance(item, dict):
            raise ConfigError(f"{what} is {item!r}; expected {', '.join(known)}")
        check_keys(item, known, what)
        found.append((item, what))
    return found


def _name(item: Mapping[str, Any], what: str) -> str:
    name = item.get("name")
    if not isinstance(name, str) or not name:
        raise ConfigError(f"{what}.name is {name!r}; expected a text, in quotes if need be")
    return name


def _polygon(item: Mapping[str, Any], what: str) -> Points:
    import shapely

    value = item.get("points")
    if not isinstance(value, list) or len(value) < 3:
        raise ConfigError(
            f"{what}.points is {value!r}; expected a list of at least 3 points [x, y]"
        )
    points = [numbers(point, 2, f"{what}.points[{i}]") for i, point in enumerate(value)]
    polygon = shapely.Polygon(points)
    if not polygon.is_valid or polygon.area == 0.0:
        raise ConfigError(
            f"{what}.points are no polygon: {shapely.is_valid_reason(polygon)};"
            " expected its corners in order, without a crossing"
        )
    return tuple((x, y) for x, y in points)


def _limit(item: Mapping[str, Any], what: str) -> tuple[float, bool]:
    """Return a limit and whether it is in percent."""
    given = [key for key in ("limit", "percentage") if item.get(key) is not None]
    if len(given) != 1:
        raise ConfigError(
            f"{what} has {' and '.join(given) or 'no limit'}; expected one of limit [m/s] and"
            " percentage [% of the robot's largest speed]"
        )
    key = given[0]
    value = number(item[key], f"{what}.{key}")
    if key == "limit" and value <= 0.0:
        raise ConfigError(
            f"{what}.limit is {value:g} m/s; it must be positive (a zone in which no robot may"
            " be is a keepout zone)"
        )
    if key == "percentage" and not 1.0 <= value <= 100.0:
        raise ConfigError(f"{what}.percentage is {value:g}; expected 1 to 100 [%]")
    return value, key == "percentage"


def _keepout_mask(entry: object, path: Path, where: str) -> Grid | None:
    if entry is None:
        return None
    file = mask_file(entry, path)
    info = _filter_info(entry, file, f"{where}.{KEEPOUT_MASK}")
    if info["type"] not in (None, KEEPOUT_TYPE):
        raise ConfigError(f"{file}: type is {info['type']:g}; a keepout mask has 0")
    if (info["base"], info["multiplier"]) != (0.0, 1.0):
        raise ConfigError(
            f"{file}: base {info['base']:g}, multiplier {info['multiplier']:g}; a keepout mask"
            " has 0 and 1"
        )
    return load_map(file).upright()


def _speed_mask(entry: object, path: Path, where: str, notes: list[str]) -> SpeedMask | None:
    if entry is None:
        return None
    file = mask_file(entry, path)
    info = _filter_info(entry, file, f"{where}.{SPEED_MASK}")
    if info["type"] not in (None, PERCENT_TYPE, ABSOLUTE_TYPE):
        raise ConfigError(
            f"{file}: type is {info['type']:g}; a speed mask has 1 (percent) or 2 (m/s)"
        )
    is_percentage = info["type"] != ABSOLUTE_TYPE
    mask = SpeedMask(load_map(file).upright(), is_percentage, info["base"], info["multiplier"])
    notes += _remarks(mask, file, has_type=info["type"] is not None)
    return mask


def _remarks(mask: SpeedMask, file: Path, *, has_type: bool) -> list[str]:
    """Return remarks on what a speed mask leaves open, and how it is understood."""
    unit = "%" if mask.is_percentage else "m/s"
    cells = mask.values.cells
    remarks = []
    if not has_type:
        remarks.append(
            f"{file} has no type: its values are limits in percent, value * {mask.multiplier:g} +"
            f" {mask.base:g}; write type: 1 (percent) or 2 (m/s), base and multiplier into it"
        )
    values = [int(value) for value in np.unique(cells[cells > 0])]
    limits, raw = mask.by_value(), mask.raw_limits()
    odd = [value for value in values if np.isinf(limits[value]) and raw[value] != 0.0]
    if odd:
        remarks.append(
            f"{file}: the value {odd[0]} comes to a limit of {raw[odd[0]]:g} {unit}: no limit,"
            " as in Nav2"
        )
    if unknown := int((cells == UNKNOWN).sum()):
        remarks.append(f"{file}: {unknown} unknown cells of the speed mask set no limit")
    return remarks


def _filter_info(entry: object, file: Path, where: str) -> dict[str, Any]:
    """Return type (None if nobody says), base and multiplier; `sites.yaml` counts more."""
    own = entry if isinstance(entry, dict) else {}
    check_keys(own, ("mask", *FILTER_INFO), where)
    given = {key: value for key, value in read_yaml(file).items() if key in FILTER_INFO}
    given |= {key: value for key, value in own.items() if key != "mask"}
    return FILTER_INFO | {key: number(value, f"{file}: {key}") for key, value in given.items()}
