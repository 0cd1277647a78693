"""One page in a browser: the robot it follows, its layers, and its orders to the swarm."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from swarm_common.model.records import FloatArray, Pose
from swarm_view import topics
from swarm_view.fleet import Fleet
from swarm_view.inbox import Inbox, numbers
from swarm_view.operator_link import OperatorLink
from swarm_view.overlay import Overlay
from swarm_view.panel import Panel, assign
from swarm_view.panel_text import is_driving, robot_html, stations_html, verdict_html
from swarm_view.robot_layers import RobotLayers
from swarm_view.shapes import lifted, nearest_to_ray
from swarm_view.sight import Sight
from swarm_view.swarm import Swarm
from swarm_view.tool import Hand, Post, Tool
from swarm_view.topics import Layer
from swarm_view.views import View

PANEL_PERIOD = 0.5  # [s] of wall time between two looks of the panel
SLOW_PERIOD = 0.25  # [s] of wall time between two updates of trails, names and claims
PICK_RADIUS, PICK_HEIGHT = 0.25, 0.1  # [m] of the ball that stands for a robot that is clicked
SELECT_FIRST = "Select a robot first."


class Page:
    """A browser's view. All methods but those named `on_` run on the main thread.

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
            swarm: The swarm's state as received.
            fleet: The robots' bodies.
            link: To the swarm; None for a recording.
            url: Returns the address of a robot's page.
            post: Brings a call to the main thread.
        """
        self.robot = robot
        self._swarm = swarm
        self._fleet = fleet
        self._link = link
        self._url = url
        self._post = post
        self._layers = RobotLayers(client.scene)
        self._overlay = Overlay(client.scene, swarm)
        self._sight = Sight(client, fleet)
        self._hand = Hand(client.scene, self._use, post)
        self._panel = Panel(client.gui, self, is_live=link is not None)
        self._sight.take(View.FOLLOW if robot else View.HALL)
        client.scene.on_click()(self._on_click)
        Inbox(client, self._on_message)
        self._panel_due = self._slow_due = 0.0
        self._was_there = False
        self._cpu = ""

    # Actions of the panel, on viser's threads

    def on_select(self, robot: str) -> None:
        """Look at another robot."""
        self._post(lambda: self.select(robot))

    def on_tool(self, tool: Tool) -> None:
        """Take another tool in hand."""
        self._post(lambda: self._take_tool(tool))

    def on_cancel(self) -> None:
        """Cancel the robot's goal."""
        self._command(lambda link: link.cancel(self.robot, self._say), needs_robot=True)

    def on_view(self, view: View) -> None:
        """Look from somewhere else."""
        self._post(lambda: self.look(view))

    def on_walls(self, *, whole: bool) -> None:
        """Show walls whole or cut."""
        self._post(lambda: self._sight.show_walls(whole=whole))

    def on_dark(self, *, dark: bool) -> None:
        """Be dark or light."""
        self._post(lambda: self._sight.set_dark(dark=dark))

    def on_pause(self) -> None:
        """Pause or resume."""
        self._command(lambda link: link.set_paused(not link.is_paused, self._say))

    def on_step(self) -> None:
        """Do one step."""
        self._command(lambda link: link.step(1, self._say))

    def on_speed(self, speed: float) -> None:
        """Change the speed."""
        self._command(lambda link: link.set_speed(speed, self._say))

    def on_spawn(self) -> None:
        """Add a robot at a free place."""
        self._command(lambda link: link.spawn(self._panel.model.value, None, self._say))

    def on_remove(self) -> None:
        """Take the robot out."""
        self._command(lambda link: link.remove(self.robot, self._say), needs_robot=True)

    def _command(self, do: Callable[[OperatorLink], None], *, needs_robot: bool = False) -> None:
        def run() -> None:
            if needs_robot and not self.robot:
                self._say(SELECT_FIRST)
            elif self._link is not None:
                do(self._link)

        self._post(run)

    def _say(self, text: str) -> None:
        assign(self._panel.message, text)

    # What it needs

    @property
    def eye(self) -> FloatArray:
        """Where its camera is (3,), in map."""
        return self._sight.eye

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
        self._was_there = False
        self._sight.rest()
        self._layers.clear()
        self._panel_due = 0.0

    def look(self, view: View) -> None:
        """Look from a preset."""
        if view in (View.FOLLOW, View.EYE) and not self.robot:
            self._say(SELECT_FIRST)
            return
        self._sight.take(view)
        self._panel.whole_walls.value = view is View.EYE or self._panel.whole_walls.value

    # Drawing

    def update(self, poses: FloatArray, now: float, cpu: str) -> None:
        """Draw the changes.

        Args:
            poses: Where the robots are drawn (n, 3), in map.
            now: Wall time [s].
            cpu: Text of the panel about the CPU.
        """
        self._draw_robot(poses, now)
        if now >= self._slow_due:
            self._slow_due = now + SLOW_PERIOD
            panel = self._panel
            self._sight.scale_marks(poses, now)
            self._draw_labels(poses)
            self._overlay.draw_trails(wanted=panel.trails.value)
            self._overlay.draw_claims(wanted=panel.claims.value)
        if now >= self._panel_due:
            self._panel_due = now + PANEL_PERIOD
            self._tell(cpu)

    def _draw_labels(self, poses: FloatArray) -> None:
        camera = self._sight.camera
        if camera is None:
            return
        chosen = [self.robot] if self.robot else []
        states = self._swarm.states
        others = [name for name in self._swarm.names if name != self.robot]
        if self._panel.names.value:  # of labels in one place, those of robots that drive go first
            chosen += sorted(others, key=lambda name: is_driving(states.get(name)))
        self._overlay.draw_labels(chosen, poses, self._sight.sizes, camera)

    def _draw_robot(self, poses: FloatArray, now: float) -> None:
        index = self._swarm.index(self.robot)
        if self._swarm.map is not None:
            self._sight.show_map(self._swarm.map)
        self._sight.update(poses, index, now)
        if index is None:
            if self._was_there:
                self._say(f"{self.robot} is not there any more.")
                self.select("")
            return
        self._was_there = True
        mesh = self._fleet.meshes.get(self.robot)
        self._layers.draw(self._swarm, self.robot, mesh, self._panel.wanted_layers())
        self._layers.draw_goal(self._swarm, self.robot)

    def _tell(self, cpu: str) -> None:
        swarm, panel, link = self._swarm, self._panel, self._link
        panel.offer(swarm.names, self.robot)
        paused = None if link is None else link.is_paused
        assign(panel.verdict, verdict_html(swarm, paused, cpu))
        assign(panel.status, self._robot_text() if self.robot else "")
        assign(panel.stations, stations_html(swarm.states))
        if link is not None:
            panel.show_running(link.is_paused, link.speed)

    def _robot_text(self) -> str:
        robot, state = self.robot, self._swarm.states.get(self.robot)
        true_pose = None if state is None else self._swarm.true_pose(robot, state.tick)
        return robot_html(robot, state, self._url(robot), true_pose)

    # Clicks and tools

    def _on_message(self, kind: str, value: Any) -> None:
        """The page's script tells something; on viser's threads."""
        if kind == "size" and (size := numbers(value, 2)) is not None:
            self._post(lambda: self._sight.resize(*size))

    def _take_tool(self, tool: Tool) -> None:
        self._hand.drop()
        self._say("")
        if tool is Tool.SELECT or self._swarm.map is None:
            return
        if tool is not Tool.SPAWN and not self.robot:
            self._say(SELECT_FIRST)
            return
        self._hand.take(tool, self._swarm.map)
        whose = "" if tool is Tool.SPAWN else f" for {self.robot}"
        self._say(f"**{tool.value}**{whose}: click the floor, or drag.")

    def _on_click(self, event: Any) -> None:
        """A click anywhere in the scene; on viser's threads."""
        origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
        self._post(lambda: self._click(origin, direction))

    def _click(self, origin: FloatArray, direction: FloatArray) -> None:
        if self._hand.tool is not Tool.SELECT:
            self._hand.click(origin, direction)
            return
        poses = self._swarm.track.latest
        index = nearest_to_ray(lifted(poses[:, :2], PICK_HEIGHT), PICK_RADIUS, origin, direction)
        if index is not None:
            self.select(self._swarm.names[index])

    def _use(self, tool: Tool, point: FloatArray, yaw: float | None) -> None:
        """Do what a tool is for at a place (2,) in map."""
        link = self._link
        if link is None or (tool is not Tool.SPAWN and not self.robot):
            return
        heading = self._usual_heading(tool, point) if yaw is None else yaw
        pose = Pose(float(point[0]), float(point[1]), heading)
        self._say(f"{tool.value} sent: ({pose.x:.2f}, {pose.y:.2f}, {pose.yaw:.2f}).")
        if tool is Tool.SPAWN:
            link.spawn(self._panel.model.value, pose, self._say)
        elif tool is Tool.GOAL:
            link.send_goal(self.robot, pose, self._say)
        else:
            link.set_initial_pose(self.robot, pose, self._say)

    def _usual_heading(self, tool: Tool, point: FloatArray) -> float:
        """Return the yaw for a click: for a goal on from where the robot comes from."""
        pose = self._swarm.pose_at(self.robot, -1)
        if pose is None or tool is Tool.SPAWN:
            return 0.0
        if tool is Tool.GOAL:
            return math.atan2(point[1] - pose[1], point[0] - pose[0])
        return float(pose[2])
