"""Cameras: how points are projected, and the presets that show a whole hall."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_view.state.decode import Raster

PANEL_WIDTH, STRIP_HEIGHT = 340.0, 150.0  # [px] of the picture that panel and time line cover
MARGIN = 0.04  # of the free part of the picture, left empty around a hall
FROM_ABOVE = np.array([0.0, -1e-3, 1.0])  # not quite: straight down has no upright
OBLIQUE = np.array([0.0, -0.75, 1.0])
WALL_TOP = 0.5  # [m] height of the walls that is to be in the picture
EYE_HEIGHT, EYE_REACH = 0.25, 2.0  # [m] of the robot's eye, and of the point that it looks at
STEPS = 30  # of the bisection
SHIFTS = 8  # in which the hall comes to the middle of the free part
NEAREST, FARTHEST = 0.5, 2000.0  # [m] of a camera from the middle of a hall


class View(Enum):
    """A preset; the value is its name on the panel."""

    PLAN = "Plan"
    TOP = "Top"
    HALL = "Hall"
    FOLLOW = "Follow"
    EYE = "Robot's eye"


@dataclass(frozen=True, slots=True)
class Camera:
    """A perspective view."""

    position: FloatArray  # (3,) in map
    target: FloatArray  # (3,) in map, in the middle of the picture
    fov: float  # [rad] from the lower to the upper edge
    width: float  # of the picture [px]
    height: float  # of the picture [px]

    @property
    def focal_length(self) -> float:
        """[px]: a metre at a depth of one metre."""
        return 0.5 * self.height / math.tan(0.5 * self.fov)

    @property
    def axes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Unit vectors (3,) in map: ahead, to the right and down in the picture."""
        ahead = self.target - self.position
        ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-12)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= max(float(np.linalg.norm(right)), 1e-12)
        return ahead, right, np.cross(ahead, right)

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where points (n, 3) are seen (n, 2) [px] from the upper left, and their depths."""
        ahead, right, down = self.axes
        offsets = points - self.position
        depths = offsets @ ahead
        share = self.focal_length / np.maximum(depths, 1e-6)
        pixels = np.column_stack([offsets @ right * share, offsets @ down * share])
        return pixels + 0.5 * np.array([self.width, self.height]), depths

    def sizes(self, points: FloatArray) -> FloatArray:
        """Return how many metres a pixel is wide (n,) at points (n, 3)."""
        gaps = np.linalg.norm(points - self.position, axis=1)
        metres: FloatArray = gaps / self.focal_length
        return metres


def camera_of(reported: Any, size: tuple[float, float]) -> Camera | None:
    """Return the view that a page of a size [px] reports; None before its first report.

    The size that viser reports is not the page's: it draws fewer pixels where that is slow.
    """
    try:
        return Camera(
            np.asarray(reported.position, np.float64),
            np.asarray(reported.look_at, np.float64),
            float(reported.fov),
            *size,
        )
    except AssertionError:  # viser's way to say so
        return None


def whole(raster: Raster, view: View, fov: float, width: float, height: float) -> Camera:
    """Return the camera that shows a whole map beside the panel, for a picture of a size [px].

    `fov` [rad] is measured from the lower to the upper edge.
    """
    (x, y), (long, deep) = raster.origin, raster.size
    corners = np.array(
        [
            (x + i * long, y + j * deep, k * WALL_TOP)
            for i in (0.0, 1.0)
            for j in (0.0, 1.0)
            for k in (0.0, 1.0)
        ]
    )
    direction = FROM_ABOVE if view is View.TOP else OBLIQUE
    direction = direction / np.linalg.norm(direction)
    middle = np.array([x + 0.5 * long, y + 0.5 * deep, 0.0])
    free = np.maximum((0.4 * width, 0.5 * height), (width - PANEL_WIDTH, height - STRIP_HEIGHT))
    camera = Camera(middle + direction, middle, fov, width, height)
    for _ in range(SHIFTS):
        distance = _distance(camera, corners, (1.0 - 2.0 * MARGIN) * free)
        camera = replace(camera, position=camera.target + distance * direction)
        pixels, _ = camera.project(corners)
        off = 0.5 * (pixels.max(axis=0) + pixels.min(axis=0)) - 0.5 * free
        # Moving the camera along the floor moves the picture by as much at the middle's depth.
        metres = distance / camera.focal_length
        shift = np.array([off[0] * metres, -off[1] * metres / max(0.3, direction[2]), 0.0])
        camera = replace(camera, position=camera.position + shift, target=camera.target + shift)
    return camera


def _distance(camera: Camera, points: FloatArray, room: FloatArray) -> float:
    """Return how far a camera must be from its target to see points in so many pixels (2,)."""
    ahead, _, _ = camera.axes
    low, high = NEAREST, FARTHEST
    for _ in range(STEPS):
        distance = math.sqrt(low * high)
        seen = replace(camera, position=camera.target - distance * ahead)
        pixels, depths = seen.project(points)
        extent = pixels.max(axis=0) - pixels.min(axis=0)
        is_seen = bool((depths > 0.1).all() and (extent <= room).all())
        low, high = (low, distance) if is_seen else (distance, high)
    return high


def eye_of(pose: FloatArray, radius: float) -> tuple[FloatArray, FloatArray]:
    """Return (target, position) of a camera at the front of a robot with a pose (3,) in map."""
    ahead = np.array([math.cos(pose[2]), math.sin(pose[2]), 0.0])
    position = np.array([pose[0], pose[1], EYE_HEIGHT]) + radius * ahead
    return position + EYE_REACH * ahead - np.array([0.0, 0.0, 0.25]), position
