"""Layers that one page shows of its robot: scan, plans, claims, costmaps, goal."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

import numpy as np

from swarm_common.model import palette
from swarm_common.model.records import FloatArray, Scan
from swarm_view.scene.images import cost_image
from swarm_view.scene.robot_mesh import RobotMesh
from swarm_view.scene.scenery import draw_image
from swarm_view.scene.shapes import lifted, loop, polyline
from swarm_view.state.decode import CommittedMotion, Raster, scan_points
from swarm_view.state.swarm import Swarm
from swarm_view.state.topics import Layer

SCAN_FRAME = "base_scan"


class RobotLayers:
    """The nodes under `/robot` in the scene of one page."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._drawn: dict[Layer, tuple[str, int]] = {}  # robot and version
        self._handles: dict[str, Any] = {}
        self._goal: Any = None

    def draw(
        self, swarm: Swarm, robot: str, mesh: RobotMesh | None, layers: Collection[Layer]
    ) -> None:
        """Draw the changes of a robot's layers, and remove layers that are not shown."""
        for layer in [layer for layer in self._drawn if layer not in layers]:
            self._remove(layer)
        for layer in layers:
            version, content = swarm.layer(robot, layer)
            if self._drawn.get(layer) == (robot, version):
                continue
            if content is None:
                self._remove(layer)
            else:
                self._draw(swarm, robot, mesh, layer, content)
            self._drawn[layer] = robot, version

    def draw_goal(self, swarm: Swarm, robot: str) -> None:
        """Draw where a robot is going to."""
        state = swarm.states.get(robot)
        goal = None if state is None else state.goal_map
        if (robot, goal) == self._goal:
            return
        self._goal = robot, goal
        self._clear("goal")
        if goal is not None:
            tip = (goal.x + 0.4 * np.cos(goal.yaw), goal.y + 0.4 * np.sin(goal.yaw), 0.06)
            self._handles["goal"] = self._scene.add_arrows(
                "/robot/goal",
                np.array([[(goal.x, goal.y, 0.06), tip]]),
                palette.GOAL,
                shaft_radius=0.035,
                head_radius=0.09,
                head_length=0.15,
            )

    def clear(self) -> None:
        """Remove everything."""
        for layer in list(self._drawn):
            self._remove(layer)
        self._clear("goal")
        self._goal = None

    def _draw(
        self, swarm: Swarm, robot: str, mesh: RobotMesh | None, layer: Layer, content: Any
    ) -> None:
        name = layer.name.lower()
        if layer is Layer.SCAN:
            self._draw_scan(swarm, robot, mesh, content)
        elif layer is Layer.PLAN:
            self._line(name, polyline(content, 0.03), palette.PLAN, 0.03)
        elif layer is Layer.LOCAL_PLAN:
            self._line(name, polyline(content, 0.05), palette.LOCAL_PLAN, 0.045)
        elif layer is Layer.MOTION:
            self._draw_motion(content)
        elif layer is Layer.FOOTPRINT:
            self._line(name, loop(content, 0.04), palette.FOOTPRINT, 0.02)
        elif layer is Layer.PARTICLES:
            self._points(name, lifted(content, 0.05), palette.PARTICLES, 0.03)
        else:
            height = 0.006 if layer is Layer.GLOBAL_COSTMAP else 0.008
            self._draw_costs(name, content, cost_image(content, swarm.map), height)

    def _draw_scan(self, swarm: Swarm, robot: str, mesh: RobotMesh | None, scan: Scan) -> None:
        pose = swarm.pose_at(robot, scan.tick)
        if pose is None:
            return
        root_from_scan = np.eye(4) if mesh is None else mesh.links.get(SCAN_FRAME, np.eye(4))
        points = lifted(scan_points(scan), 0.0) @ root_from_scan[:3, :3].T + root_from_scan[:3, 3]
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        points[:, :2] = points[:, :2] @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]
        self._points("scan", points, palette.SCAN, 0.035)

    def _draw_costs(self, name: str, raster: Raster, image: Any, height: float) -> None:
        handle = self._handles.get(name)
        if handle is None or handle.image.shape != image.shape:
            self._handles[name] = draw_image(self._scene, f"/robot/{name}", raster, image, height)
            return
        handle.position = (*raster.center, height)
        if not np.array_equal(handle.image, image):
            handle.image = image

    def _draw_motion(self, motion: CommittedMotion) -> None:
        parts = (
            ("motion_intent", motion.intent, palette.INTENT, 0.02, 0.02),
            ("motion_wanted", motion.wanted, palette.WANTED, 0.06, 0.022),
            ("motion_held", motion.held, palette.HELD, 0.09, 0.024),
        )
        for name, points, color, thickness, height in parts:
            self._line(name, polyline(points, height), color, thickness)

    def _line(self, name: str, segments: FloatArray, color: palette.RGB, width: float) -> None:
        self._update(
            name,
            segments,
            lambda: self._scene.add_line_segments(
                f"/robot/{name}", segments, color, thickness=width
            ),
        )

    def _points(self, name: str, points: FloatArray, color: palette.RGB, size: float) -> None:
        self._update(
            name, points,
            lambda: self._scene.add_point_cloud(
                f"/robot/{name}", points, color, point_size=size, point_shape="circle",
                precision="float32",
            ),
        )  # fmt: skip

    def _update(self, name: str, points: FloatArray, draw: Callable[[], Any]) -> None:
        """Change the points of a node; draw it if there is none, remove it if there are none."""
        if not len(points):
            self._clear(name)
        elif name in self._handles:  # cheaper than a new node, here and on the page
            self._handles[name].points = points.astype(np.float32)
        else:
            self._handles[name] = draw()

    def _remove(self, layer: Layer) -> None:
        self._drawn.pop(layer, None)
        name = layer.name.lower()
        for key in [key for key in self._handles if key == name or key.startswith(f"{name}_")]:
            self._clear(key)

    def _clear(self, name: str) -> None:
        handle = self._handles.pop(name, None)
        if handle is not None:
            handle.remove()
