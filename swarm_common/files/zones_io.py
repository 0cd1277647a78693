"""Reading of zones: the section `zones:` of `sites.yaml`, and Nav2's filter masks.

A mask is a map file of Nav2 with `type`, `base` and `multiplier` of CostmapFilterInfo in it, or
beside its name in `sites.yaml`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import yaml
from msgspec import Meta, structs

from swarm_common.files.convert import convert
from swarm_common.files.map_io import load_map
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import KEEPOUT, UNKNOWN, Grid
from swarm_common.model.schema import Name, Polygon, Schema, told
from swarm_common.model.zones import NO_ZONES, KeepoutZone, Lanes, SpeedMask, SpeedZone, Zones

KEEPOUT_MASK, SPEED_MASK, LANES = MASKS = ("keepout_mask", "speed_mask", "lanes")
LEARNED = "learned"  # key of a file of lanes: what they were made for
KEEPOUT_TYPE, PERCENT_TYPE, ABSOLUTE_TYPE = range(3)  # CostmapFilterInfo.type
SpeedLimit = Annotated[
    float, told("a positive number (a zone in which no robot may be is a keepout zone)", gt=0.0)
]


class KeepoutEntry(Schema):
    """A keepout zone in the file."""

    name: Name
    points: Polygon

    def __post_init__(self) -> None:
        import shapely

        polygon = shapely.Polygon(self.points)
        if not polygon.is_valid or polygon.area == 0.0:
            raise ConfigError(
                f"points are no polygon: {shapely.is_valid_reason(polygon)};"
                " expected its corners in order, without a crossing"
            )


class SpeedEntry(KeepoutEntry):
    """A zone with a speed limit in the file."""

    limit: SpeedLimit | None = None  # [m/s]
    percentage: Annotated[float, Meta(ge=1.0, le=100.0)] | None = None  # of the largest speed

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.limit is None) == (self.percentage is None):
            found = "limit and percentage" if self.limit is not None else "no limit"
            raise ConfigError(
                f"it has {found}; expected one of limit [m/s] and percentage [% of the robot's"
                " largest speed]"
            )


class FilterInfo(Schema):
    """Fields of CostmapFilterInfo."""

    type: float | None = None
    base: float | None = None
    multiplier: float | None = None


MapFile = Annotated[str, Meta(min_length=1)]


class MaskEntry(FilterInfo, kw_only=True):
    """A mask in the file; its fields count more than those of its map."""

    mask: MapFile


Mask = Annotated[
    MapFile | MaskEntry, told("a map file, or {mask: FILE, type: ..., base: ..., multiplier: ...}")
]


class ZonesEntry(Schema):
    """The section `zones:`."""

    keepout: tuple[KeepoutEntry, ...] | None = None
    speed: tuple[SpeedEntry, ...] | None = None
    keepout_mask: Mask | None = None
    speed_mask: Mask | None = None
    lanes: Mask | None = None  # preferred lanes

    def __post_init__(self) -> None:
        for kind in (self.keepout or (), self.speed or ()):
            names = [zone.name for zone in kind]
            for name in names:
                if names.count(name) > 1:
                    raise ConfigError(f"two zones are called '{name}'; names are unique")


Masks = Mapping[str, Path | None]
"""Files of masks by their key, in place of those of the sites file; None for no mask."""


def with_lanes(entry: ZonesEntry | None, lanes: Mask | None) -> ZonesEntry | None:
    """Return zones with the lanes that stand beside them in a sites file."""
    return entry if lanes is None else structs.replace(entry or ZonesEntry(), lanes=lanes)


def make_zones(entry: ZonesEntry | None, path: Path, masks: Masks) -> Zones:
    """Return the zones of a sites file.

    Args:
        path: Sites file; masks are relative to its folder.
    """
    if entry is None and not masks:
        return NO_ZONES
    entry = entry or ZonesEntry()
    given = {key: mask for key in MASKS if (mask := getattr(entry, key)) is not None}
    given |= {key: str(mask.absolute()) for key, mask in masks.items() if mask is not None}
    given = {key: mask for key, mask in given.items() if masks.get(key, mask) is not None}
    own = {
        key: MaskEntry(mask=mask) if isinstance(mask, str) else mask for key, mask in given.items()
    }
    notes: list[str] = []
    return Zones(
        keepout=tuple(KeepoutZone(zone.name, zone.points) for zone in entry.keepout or ()),
        speed=tuple(
            SpeedZone(zone.name, zone.points, zone.limit or zone.percentage or 0.0, not zone.limit)
            for zone in entry.speed or ()
        ),
        keepout_mask=_cost_mask(own.get(KEEPOUT_MASK), path.parent),
        speed_mask=_speed_mask(own.get(SPEED_MASK), path.parent, notes),
        lanes=_lanes(own.get(LANES), path.parent),
        notes=tuple(notes),
    )


def copy_masks(path: Path, masks: Masks, folder: Path) -> dict[str, Any] | None:
    """Copy the masks of a sites file; return its content with the copies, None if it has none."""
    data = read_yaml(path, may_be_empty=True) if path.is_file() else {}
    zones = dict(data.get("zones") or {})
    if (lanes := data.pop(LANES, None)) is not None:
        zones[LANES] = lanes
    zones |= {key: mask and str(mask.absolute()) for key, mask in masks.items()}
    entries = {key: zones[key] for key in MASKS if zones.get(key) is not None}
    if not entries and not masks:
        return None
    for key, entry in entries.items():
        file = path.parent / (entry["mask"] if isinstance(entry, dict) else entry)
        content = read_yaml(file)
        image = file.parent / content["image"]
        copy = folder / key / file.name
        copy.parent.mkdir(parents=True)
        (copy.parent / image.name).write_bytes(image.read_bytes())
        copy.write_text(yaml.safe_dump(content | {"image": image.name}), encoding="utf-8")
        name = str(copy.relative_to(folder))
        zones[key] = entry | {"mask": name} if isinstance(entry, dict) else name
    return data | {"zones": {key: zone for key, zone in zones.items() if zone is not None}}


def load_lanes(path: Path) -> Lanes:
    """Return the lanes of a mask.

    Raises:
        ConfigError: If it is unusable, or closes floor.
    """
    lanes = _lanes(MaskEntry(mask=str(path.absolute())), path.parent)
    assert lanes is not None
    return lanes


def _lanes(entry: MaskEntry | None, folder: Path) -> Lanes | None:
    values = _cost_mask(entry, folder)
    if entry is None or values is None:
        return None
    file = folder / entry.mask
    if (values.cells >= KEEPOUT).any():
        raise ConfigError(
            f"{file}: the value 100 closes a cell; lanes only cost, 1 to 99 (cells that no robot"
            " may enter belong into the keepout mask)"
        )
    return Lanes(values, convert(read_yaml(file).get(LEARNED, {}), dict[str, str], file))


def _cost_mask(entry: MaskEntry | None, folder: Path) -> Grid | None:
    """Return a mask of costs, as Nav2's KeepoutFilter takes it."""
    if entry is None:
        return None
    file = folder / entry.mask
    kind, base, multiplier = _filter_info(entry, file)
    if kind not in (None, KEEPOUT_TYPE):
        raise ConfigError(f"{file}: type is {kind:g}; a keepout mask has 0")
    if (base, multiplier) != (0.0, 1.0):
        raise ConfigError(
            f"{file}: base {base:g}, multiplier {multiplier:g}; a keepout mask has 0 and 1"
        )
    return load_map(file).upright()


def _speed_mask(entry: MaskEntry | None, folder: Path, notes: list[str]) -> SpeedMask | None:
    if entry is None:
        return None
    file = folder / entry.mask
    kind, base, multiplier = _filter_info(entry, file)
    if kind not in (None, PERCENT_TYPE, ABSOLUTE_TYPE):
        raise ConfigError(f"{file}: type is {kind:g}; a speed mask has 1 (percent) or 2 (m/s)")
    mask = SpeedMask(load_map(file).upright(), kind != ABSOLUTE_TYPE, base, multiplier)
    notes += _remarks(mask, file, has_type=kind is not None)
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


def _filter_info(entry: MaskEntry, file: Path) -> tuple[float | None, float, float]:
    """Return type (None if nobody says), base and multiplier, by default Nav2's."""
    names = FilterInfo.__struct_fields__
    given = {key: value for key, value in read_yaml(file).items() if key in names}
    own = ((name, getattr(entry, name)) for name in names)
    given |= {name: value for name, value in own if value is not None}
    info = convert(given, FilterInfo, file)
    multiplier = 1.0 if info.multiplier is None else info.multiplier
    return info.type, info.base or 0.0, multiplier
