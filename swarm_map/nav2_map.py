"""Worlds of Nav2's maps: a wall wherever the map is occupied, at the same places."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from swarm_common.files.map_io import load_map
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import FREE, OCCUPIED, UNKNOWN
from swarm_map.floor_plan import FloorPlan
from swarm_map.plan_image import MAX_PIXELS, WallRaster
from swarm_map.start import open_area


def load_nav2_map(path: Path, wall_height: float, drop: float = 0.0) -> tuple[FloorPlan, float]:
    """Return the plan that a map is, in the frame of the map, and the map's resolution [m].

    Args:
        drop: [m]; occupied spots that are no longer and no wider are left out.
    """
    turned = load_map(path)
    if turned.cells.size > MAX_PIXELS:
        raise ConfigError(f"{path}: {turned.cells.size} cells; expected at most {MAX_PIXELS:.0e}")
    grid = turned.upright()
    raster = WallRaster(path, grid.cells == OCCUPIED, grid.resolution, grid.origin_x, grid.origin_y)
    if not raster.walls.any():
        raise ConfigError(f"{path}: no cell is occupied, by its image, thresholds and negate")
    notes = raster.drop_specks(drop)
    others = np.count_nonzero(turned.cells == UNKNOWN)
    if others:
        notes.append(f"unknown cells of {path} are floor: {others} of {turned.cells.size}")
    if np.any((turned.cells > FREE) & (turned.cells < OCCUPIED)):
        notes.append(f"cells of {path} between free and occupied are floor")
    if turned.origin_yaw:
        notes.append(f"{path} is turned by {turned.origin_yaw:g} rad; its walls are stairs here")
    sites = {"spawn": spawn} if (spawn := open_area(grid)) else {}
    return FloorPlan(path.stem, raster.things(wall_height), sites, tuple(notes)), grid.resolution
