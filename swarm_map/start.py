"""Where robots can start in a world that was made of a plan, and how many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from swarm_common.files.map_io import MAP_FILE, load_map
from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import FREE, Grid
from swarm_common.model.records import Mask
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.scene import GROUND_GAP, Scene
from swarm_map.plan_image import SPAWN_PITCH
from swarm_map.remarks import TALLEST
from swarm_map.world_writer import ROBOT
from swarm_sim.maps.spawn import spawn_poses
from swarm_sim.scene.section import section_between

USUAL_SIZE = 5  # robots that the command which is proposed starts
BLOCK = 0.5  # [m] of the blocks of which a start area consists; one is kept free around it


def startable(scene: Scene) -> tuple[int, str]:
    """Return how many robots, at most `USUAL_SIZE`, can start, and why no more can."""
    grid, reason = load_map(scene.file.with_name(MAP_FILE)), ""
    for count in range(USUAL_SIZE, 0, -1):
        try:
            poses = spawn_poses(scene, load_robot(ROBOT), count)
        except SwarmError as error:
            reason = reason or str(error)
            continue
        if all(grid.contains(pose.x, pose.y) for pose in poses):
            return count, reason
        reason = reason or "robots would start around the origin, which is beside the map"
    return 0, reason


def start_area(scene: Scene) -> dict[str, float] | None:
    """Return the largest free rectangle between the walls of a world; None without room."""
    grid = load_map(scene.file.with_name(MAP_FILE))
    x_min, y_min, x_max, y_max = section_between(scene.bodies, GROUND_GAP, TALLEST).bounds()
    (bottom, left), (top, right) = grid.cell_of(x_min, y_min), grid.cell_of(x_max, y_max)
    bottom, left = max(bottom, 0), max(left, 0)
    x, y = grid.origin_x + left * grid.resolution, grid.origin_y + bottom * grid.resolution
    cells = grid.cells[bottom : top + 1, left : right + 1]
    return open_area(replace(grid, cells=cells, origin_x=x, origin_y=y))


def open_area(grid: Grid) -> dict[str, float] | None:
    """Return the largest free rectangle of an upright map as a spawn area; None without room."""
    from scipy import ndimage

    step = max(1, round(BLOCK / grid.resolution))
    height, width = (size // step for size in grid.cells.shape)
    free = (grid.cells == FREE)[: height * step, : width * step]
    blocks: Mask = free.reshape(height, step, width, step).all(axis=(1, 3))
    if not blocks.any():
        return None
    inner = ndimage.binary_erosion(blocks, np.ones((3, 3)))
    blocks = inner if inner.any() else blocks
    low, left, high, right = (edge * step * grid.resolution for edge in _largest(blocks))
    return {
        "x_min": round(grid.origin_x + left, 3),
        "y_min": round(grid.origin_y + low, 3),
        "x_max": round(grid.origin_x + right, 3),
        "y_max": round(grid.origin_y + high, 3),
        "pitch": SPAWN_PITCH,
    }


def _largest(mask: Mask) -> tuple[int, int, int, int]:
    """Return the largest rectangle (rows from, columns from, to, to) that is all true."""
    best, found = 0, (0, 0, 0, 0)
    heights = np.zeros(mask.shape[1] + 1, np.int64)  # of the column of trues above each cell
    for row, line in enumerate(mask):
        heights[:-1] = (heights[:-1] + 1) * line
        open_at: list[tuple[int, int]] = []  # start column and height of rectangles that go on
        for column, height in enumerate(heights.tolist()):
            start = column
            while open_at and open_at[-1][1] > height:
                start, tall = open_at.pop()
                if tall * (column - start) > best:
                    best = tall * (column - start)
                    found = (row - tall + 1, start, row + 1, column)
            if height and (not open_at or open_at[-1][1] < height):
                open_at.append((start, height))
    return found
