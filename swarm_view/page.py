"""One page in a browser: which robot it looks at, what it shows, and its tools."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from swarm_common.records import FloatArray, Pose
from swarm_view import topics
from swarm_view.fleet import Fleet
from swarm_view.operator_link import OperatorLink
from swarm_view.palette import GOAL, HELD, TRAIL
from swarm_view.panel import TOOLS, Panel, assign
from swarm_view.panel_text import label_text, robot_html, stations_html, verdict_html
from swarm_view.robot_layers import RobotLayers
from swarm_view.shapes import floor, lifted, nearest_to_ray, on_floor, polyline
from swarm_view.swarm import Swarm
from swarm_view.topics import Layer

PANEL_PERIOD = 0.5  # [s] of wall time between two looks of the panel
SLOW_PERIOD = 0.25  # [s] of wall time between two updates of trails, names and claims
LABEL_HEIGHT = 0.45  # [m]
DRAG_LENGTH = 0.15  # [m] from which a drag gives a heading
TRAIL_HEIGHT = 0.015  # [m]
CLOSE_UP = np.array([-1.2, -2.4, 3.2])  # [m] of the camera from its robot
FOLLOWED = 1.0  # [m] within which a camera looks at the robot that it follows
PICK_RADIUS, PICK_HEIGHT = 0.25, 0.1  # [m] of the ball that stands for a robot that is clicked
Post = Callable[[Callable[[], None]], None]


class Page:
    """A browser's view. All methods but those of `Actions` run on the main thread.

    Attributes:
        robot: Which one it looks at; empty for none.
    """

    def __init__(
        self, client: Any, robot: str, swarm: Swarm, fleet: Fleet, link: OperatorLink | None,
        url: Callable[[str], str], post: Post,
    ) -> None:  # fmt: skip
        """Build the page.

        Args:
            client: viser's handle of it.
            robot: That it opens with; empty for none.
            swarm: What is known.
            fleet: The robots' bodies.
            link: To the swarm; None for a recording.
            url: Returns the address of a robot's page.
            post: Brings a call to the main thread.
        """
        self.robot = robot
        self._client = client
        self._swarm = swarm
        self._fleet = fleet
        self._link = link
        self._url = url
        self._post = post
        self._layers = RobotLayers(client.scene)
        self._panel = Panel(client.gui, self, is_live=link is not None)
        self._panel.follow.value = bool(robot)
        client.scene.on_click()(self._on_click)
        self._tool = TOOLS[0]
        self._floor: Any = None
        self._arrow: Any = None
        self._labels: dict[str, Any] = {}
        self._extras: dict[str, Any] = {}
        self._panel_due = self._slow_due = 0.0
        self._seen: FloatArray | None = None
        self._offset = CLOSE_UP

    # Actions of the panel, on viser's threads

    def on_select(self, robot: str) -> None:
        """Look at another robot."""
        self._post(lambda: self.select(robot))

    def on_tool(self, tool: str) -> None:
        """Take another tool in hand."""
        self._post(lambda: self._take_tool(tool))

    def on_cancel(self) -> None:
        """Cancel the robot's goal."""
        self._command(lambda link: link.cancel(self.robot), needs_robot=True)

    def on_pause(self) -> None:
        """Pause or resume."""
        self._command(lambda link: link.set_paused(not link.is_paused))

    def on_step(self) -> None:
        """Do one step."""
        self._command(lambda link: link.step(1))

    def on_speed(self, speed: float) -> None:
        """Change the speed."""
        self._command(lambda link: link.set_speed(speed))

    def _command(self, do: Callable[[OperatorLink], None], *, needs_robot: bool = False) -> None:
        def run() -> None:
            if needs_robot and not self.robot:
                assign(self._panel.message, "Select a robot first.")
            elif self._link is not None:
                do(self._link)

        self._post(run)

    # What it needs

    def topics(self) -> set[str]:
        """Return the topics that it shows beside those that every page shows."""
        wanted = set()
        if self.robot:
            layers = self._panel.wanted_layers()
            wanted |= {topics.of_layer(self.robot, layer) for layer in layers}
        if self._panel.claims.value:
            wanted |= {topics.of_layer(name, Layer.MOTION) for name in self._swarm.names}
        return wanted

    def select(self, robot: str) -> None:
        """Look at a robot; empty for none."""
        self.robot = robot
        self._seen = None
        self._layers.clear()
        self._panel_due = 0.0

    def look_at(self, target: FloatArray, position: FloatArray) -> None:
        """Point the camera somewhere, unless it follows a robot."""
        if not self.robot:
            with self._client.atomic():
                self._client.camera.position = position
                self._client.camera.look_at = target

    # Drawing

    def update(self, poses: FloatArray, now: float) -> None:
        """Draw what has changed; `poses` (n, 3) is where the robots are drawn."""
        index = self._swarm.index(self.robot)
        if index is not None:
            mesh = self._fleet.meshes.get(self.robot)
            self._layers.draw(self._swarm, self.robot, mesh, self._panel.wanted_layers())
            self._layers.draw_goal(self._swarm, self.robot)
            if index < len(poses):
                self._follow(poses[index])
        if now >= self._slow_due:
            self._slow_due = now + SLOW_PERIOD
            self._draw_labels(poses)
            self._draw_extra("trails", self._panel.trails.value, self._swarm.trails.segments)
            self._draw_extra("claims", self._panel.claims.value, self._claims)
        if now >= self._panel_due:
            self._panel_due = now + PANEL_PERIOD
            self._tell()

    def show_cpu(self, text: str) -> None:
        """Keep what the panel says of the CPU."""
        self._cpu = text

    _cpu = ""

    def _tell(self) -> None:
        swarm, panel, link = self._swarm, self._panel, self._link
        panel.offer(swarm.names, self.robot)
        paused = None if link is None else link.is_paused
        assign(panel.verdict, verdict_html(swarm, paused, self._cpu))
        state = swarm.states.get(self.robot)
        assign(
            panel.status, robot_html(self.robot, state, self._url(self.robot)) if self.robot else ""
        )
        assign(panel.stations, stations_html(swarm.states))
        if link is not None:
            panel.show_running(link.is_paused, link.speed)
            if link.problem:
                assign(panel.message, link.problem)

    def _follow(self, pose: FloatArray) -> None:
        """Keep the robot in the middle; the reader turns and zooms as before."""
        place = np.array([pose[0], pose[1], 0.0])
        if not self._panel.follow.value:
            self._seen = None
            return
        if self._seen is not None and np.abs(place - self._seen).max() < 1e-3:
            return
        camera = self._client.camera
        if self._seen is None:
            self._offset = CLOSE_UP
        elif np.abs(camera.look_at - place).max() < FOLLOWED:  # else it is not there yet
            self._offset = camera.position - camera.look_at
        self._seen = place
        with self._client.atomic():
            camera.position = place + self._offset
            camera.look_at = place

    def _draw_labels(self, poses: FloatArray) -> None:
        swarm = self._swarm
        wanted = swarm.names if self._panel.names.value else [self.robot] if self.robot else []
        for name in self._labels.keys() - set(wanted):
            self._labels.pop(name).remove()
        for name in wanted:
            index = swarm.index(name)
            if index is None or index >= len(poses):
                continue
            place = (float(poses[index, 0]), float(poses[index, 1]), LABEL_HEIGHT)
            text = label_text(name, swarm.states.get(name))
            label = self._labels.get(name)
            if label is None:
                self._labels[name] = self._client.scene.add_label(
                    f"/labels/{name}", text, position=place, anchor="bottom-center",
                    font_screen_scale=0.8,
                )  # fmt: skip
            else:
                if label.text != text:
                    label.text = text
                if np.abs(label.position - place).max() > 0.01:
                    label.position = place

    def _draw_extra(self, name: str, wanted: bool, segments: Callable[[], FloatArray]) -> None:
        lines = segments() if wanted else np.zeros((0, 2, 2))
        if not len(lines):
            if name in self._extras:
                self._extras.pop(name).remove()
            return
        raised = np.full((len(lines), 2, 3), TRAIL_HEIGHT)
        raised[:, :, :2] = lines
        color, width = (TRAIL, 0.03) if name == "trails" else (HELD, 0.08)
        self._extras[name] = self._client.scene.add_line_segments(
            f"/all/{name}", raised, color, thickness=width
        )

    def _claims(self) -> FloatArray:
        parts = []
        for name in self._swarm.names:
            _, motion = self._swarm.layer(name, Layer.MOTION)
            if motion is not None and len(motion.held) > 1:
                parts.append(polyline(motion.held, 0.0)[:, :, :2])
        return np.concatenate(parts) if parts else np.zeros((0, 2, 2))

    # Tools

    def _take_tool(self, tool: str) -> None:
        self._drop_tool()
        assign(self._panel.message, "")
        if tool == TOOLS[0] or self._swarm.map is None:
            return
        if not self.robot:
            assign(self._panel.message, "Select a robot first.")
            return
        self._tool = tool
        raster = self._swarm.map
        (x, y), (width, depth) = raster.origin, raster.size
        vertices, faces = floor(x, y, x + width, y + depth)
        self._floor = self._client.scene.add_mesh_simple(
            "/tool/floor", vertices, faces, color=GOAL, opacity=0.06, position=(0.0, 0.0, 0.001),
            side="double", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self._floor.on_drag("left")(self._on_floor_drag)
        assign(self._panel.message, f"**{tool}** for {self.robot}: click the floor, or drag.")

    def _drop_tool(self) -> None:
        self._tool = TOOLS[0]
        for node in (self._floor, self._arrow):
            if node is not None:
                node.remove()
        self._floor = self._arrow = None

    def _on_click(self, event: Any) -> None:
        """A click anywhere in the scene; on viser's threads."""
        origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
        self._post(lambda: self._click(origin, direction))

    def _click(self, origin: FloatArray, direction: FloatArray) -> None:
        if self._tool != TOOLS[0]:
            point = on_floor(origin, direction)
            if point is not None:
                self._apply_tool(point, None)
            return
        poses = self._swarm.track.latest
        index = nearest_to_ray(lifted(poses[:, :2], PICK_HEIGHT), PICK_RADIUS, origin, direction)
        if index is not None:
            self.select(self._swarm.names[index])

    def _on_floor_drag(self, event: Any) -> None:
        eye = np.array(event.client.camera.position)
        start = np.array(event.start_position)[:2]
        tip = on_floor(eye, np.array(event.end_position) - eye)
        if tip is None:
            return
        if event.phase == "end":
            self._post(lambda: self._apply_tool(start, tip))
        else:
            self._post(lambda: self._draw_arrow(start, tip))

    def _draw_arrow(self, start: FloatArray, tip: FloatArray) -> None:
        if self._floor is not None and np.hypot(*(tip - start)) > DRAG_LENGTH:
            self._arrow = self._client.scene.add_arrows(
                "/tool/arrow", lifted(np.array([start, tip]), 0.08)[None], GOAL,
                shaft_radius=0.03, head_radius=0.08, head_length=0.14,
            )  # fmt: skip

    def _apply_tool(self, point: FloatArray, tip: FloatArray | None) -> None:
        tool, link = self._tool, self._link
        if link is None or tool == TOOLS[0] or not self.robot:
            return
        pose = Pose(float(point[0]), float(point[1]), self._heading(point, tip))
        if tool == "Goal":
            link.send_goal(self.robot, pose)
        else:
            link.set_initial_pose(self.robot, pose)
        self._drop_tool()
        assign(self._panel.message, f"{tool} sent: ({pose.x:.2f}, {pose.y:.2f}, {pose.yaw:.2f}).")

    def _heading(self, point: FloatArray, tip: FloatArray | None) -> float:
        """Return the yaw: that of the drag, else on from where the robot comes from."""
        if tip is not None and np.hypot(*(tip - point)) > DRAG_LENGTH:
            return math.atan2(tip[1] - point[1], tip[0] - point[0])
        pose = self._swarm.pose_at(self.robot, -1)
        if pose is None:
            return 0.0
        if self._tool == "Goal":
            return math.atan2(point[1] - pose[1], point[0] - pose[0])
        return float(pose[2])
