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
from msgspec import Meta

from swarm_common.files.convert import convert
from swarm_common.files.map_io import load_map
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import UNKNOWN, Grid
from swarm_common.model.schema import Name, Point, Schema
from swarm_common.model.zones import NO_ZONES, KeepoutZone, SpeedMask, SpeedZone, Zones

KEEPOUT_MASK, SPEED_MASK = MASKS = ("keepout_mask", "speed_mask")
KEEPOUT_TYPE, PERCENT_TYPE, ABSOLUTE_TYPE = range(3)  # CostmapFilterInfo.type
Corners = Annotated[
    tuple[Point, ...], Meta(min_length=3, description="a list of at least 3 points [x, y]")
]


class KeepoutEntry(Schema):
    """A keepout zone in the file."""

    name: Name
    points: Corners

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

    # [m/s]; where no robot may be is a keepout zone
    limit: Annotated[float, Meta(gt=0.0, description="a positive number (a zone in which no "
                                 "robot may be is a keepout zone)")] | None = None  # fmt: skip
    percentage: Annotated[float, Meta(ge=1.0, le=100.0)] | None = None  # of the largest speed

    def __post_init__(self) -> None:
        super().__post_init__()
        given = [key for key in ("limit", "percentage") if getattr(self, key) is not None]
        if len(given) != 1:
            raise ConfigError(
                f"it has {' and '.join(given) or 'no limit'}; expected one of limit [m/s] and"
                " percentage [% of the robot's largest speed]"
            )

    def zone(self) -> SpeedZone:
        """Return the zone."""
        is_percentage = self.limit is None
        limit = self.percentage if self.limit is None else self.limit
        return SpeedZone(self.name, self.points, limit or 0.0, is_percentage)


class FilterInfo(Schema):
    """Fields of CostmapFilterInfo, with Nav2's defaults."""

    type: float | None = None  # None if nobody says
    base: float = 0.0
    multiplier: float = 1.0


class MaskEntry(Schema):
    """A mask in the file with the fields of CostmapFilterInfo that replace those of its map."""

    mask: Annotated[str, Meta(min_length=1)]
    type: float | None = None
    base: float | None = None
    multiplier: float | None = None


Mask = Annotated[
    Annotated[str, Meta(min_length=1)] | MaskEntry,
    Meta(description="a map file, or {mask: FILE, type: ..., base: ..., multiplier: ...}"),
]


class ZonesEntry(Schema):
    """The section `zones:`."""

    keepout: tuple[KeepoutEntry, ...] | None = None
    speed: tuple[SpeedEntry, ...] | None = None
    keepout_mask: Mask | None = None
    speed_mask: Mask | None = None

    def __post_init__(self) -> None:
        for kind in (self.keepout or (), self.speed or ()):
            names = [zone.name for zone in kind]
            for name in names:
                if names.count(name) > 1:
                    raise ConfigError(f"two zones are called '{name}'; names are unique")


def make_zones(entry: ZonesEntry | None, path: Path, masks: Mapping[str, Path]) -> Zones:
    """Return the zones of a sites file.

    Args:
        path: Sites file; masks are relative to its folder.
        masks: Files of masks, by key, that replace those of the sites file.
    """
    if entry is None and not masks:
        return NO_ZONES
    entry = entry or ZonesEntry()
    own = {key: getattr(entry, key) for key in MASKS}
    own |= {key: str(mask.absolute()) for key, mask in masks.items()}
    notes: list[str] = []
    return Zones(
        keepout=tuple(KeepoutZone(zone.name, zone.points) for zone in entry.keepout or ()),
        speed=tuple(zone.zone() for zone in entry.speed or ()),
        keepout_mask=_keepout_mask(own[KEEPOUT_MASK], path),
        speed_mask=_speed_mask(own[SPEED_MASK], path, notes),
        notes=tuple(notes),
    )


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
    """Return the map file of a mask, an entry of the sites file."""
    mask = (
        convert(entry, Mask, f"{path}: zones: a mask")
        if not isinstance(entry, MaskEntry)
        else entry
    )
    return path.parent / (mask if isinstance(mask, str) else mask.mask)


def _keepout_mask(entry: str | MaskEntry | None, path: Path) -> Grid | None:
    if entry is None:
        return None
    file = mask_file(entry, path)
    info = _filter_info(entry, file)
    if info.type not in (None, KEEPOUT_TYPE):
        raise ConfigError(f"{file}: type is {info.type:g}; a keepout mask has 0")
    if (info.base, info.multiplier) != (0.0, 1.0):
        raise ConfigError(
            f"{file}: base {info.base:g}, multiplier {info.multiplier:g}; a keepout mask"
            " has 0 and 1"
        )
    return load_map(file).upright()


def _speed_mask(entry: str | MaskEntry | None, path: Path, notes: list[str]) -> SpeedMask | None:
    if entry is None:
        return None
    file = mask_file(entry, path)
    info = _filter_info(entry, file)
    if info.type not in (None, PERCENT_TYPE, ABSOLUTE_TYPE):
        raise ConfigError(f"{file}: type is {info.type:g}; a speed mask has 1 (percent) or 2 (m/s)")
    is_percentage = info.type != ABSOLUTE_TYPE
    mask = SpeedMask(load_map(file).upright(), is_percentage, info.base, info.multiplier)
    notes += _remarks(mask, file, has_type=info.type is not None)
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


def _filter_info(entry: str | MaskEntry, file: Path) -> FilterInfo:
    """Return what map and entry say; the entry counts more."""
    names = FilterInfo.__struct_fields__
    given = {key: value for key, value in read_yaml(file).items() if key in names}
    if isinstance(entry, MaskEntry):
        own = ((name, getattr(entry, name)) for name in names)
        given |= {name: value for name, value in own if value is not None}
    return convert(given, FilterInfo, file)
