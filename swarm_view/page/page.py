"""One page in a browser: the robot it follows, its layers, and its orders to the swarm."""

from __future__ import annotations

import html
import io
import json
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose
from swarm_view.page.charts import Charts
from swarm_view.page.driving import Driving
from swarm_view.page.inbox import Inbox, numbers
from swarm_view.page.panel import FILM, MOST_PLANS, NOBODY, SPEEDS, STOP_FILM, Panel, assign
from swarm_view.page.panel_text import (
    counted_legend,
    figures,
    history_html,
    is_driving,
    robot_html,
    stations_html,
    topics_html,
    verdict_html,
)
from swarm_view.page.past import Past
from swarm_view.page.plan import FROM, MOST_TUBES, PlanView, head_of_chain
from swarm_view.page.playback import Playback
from swarm_view.page.time_line import TimeLine, next_mark
from swarm_view.page.tool import ORDERS, Hand, Post, Ruler, Tool, heading
from swarm_view.scene.fleet import DrawnFleet
from swarm_view.scene.overlay import Overlay
from swarm_view.scene.page_view import PageView
from swarm_view.scene.robot_layers import RobotLayers
from swarm_view.scene.shapes import lifted, nearest_to_ray, on_floor
from swarm_view.scene.views import View
from swarm_view.scene.viser_compat import run_script
from swarm_view.state import topics
from swarm_view.state.history import History
from swarm_view.state.link import Viewpoint
from swarm_view.state.operator_link import OperatorLink
from swarm_view.state.swarm import Swarm
from swarm_view.state.topics import Layer

PANEL_PERIOD = 0.5  # [s] of wall time between two looks of the panel
PLANS_PERIOD = 5.0  # [s] of wall time between two choices of the robots whose plans are shown
SHOWN_CHANGES = 12  # of a robot's states, in its history
SLOW_PERIOD = 0.25  # [s] of wall time between two updates of trails, names and claims
PICK_RADIUS, PICK_HEIGHT = 0.25, 0.1  # [m] of the ball that stands for a robot that is clicked
FINER = 2  # times as many pixels as are saved: not every browser smoothes edges
RENDER_LIMIT = 60.0  # [s] of wall time for a page to draw a picture
SELECT_FIRST = "Select a robot first."
LEAVE_PAST = "This page shows the past; press **Live** on the time line first."
UNKNOWN_TIME = "Nothing is known of that time: the viewer remembers while a page is open."
TIME_ORDERS = ("seek", "step", "mark", "play", "live")
STATIONS_STAY = "Robots have planned with this station: write it into sites.yaml for the next run."
ROBOT_TAB = "Robot"
MOVE_IN_PLAN = "**Move**: in *Plan*, drag a robot or an object to where it is to be."


class Page:
    """A browser's view; runs on the main thread, except for viser's callbacks.

    Attributes:
        robot: The selected robot; empty for none.
    """

    def __init__(
        self, client: Any, place: Viewpoint, swarm: Swarm, fleet: DrawnFleet,
        link: OperatorLink | None, url: Callable[[str, Viewpoint | None], str], post: Post,
        history: History, playback: Playback | None,
    ) -> None:  # fmt: skip
        """Build the page.

        Args:
            link: Sends orders to the swarm; None for a recording.
            url: Returns the address of a robot's page, or of a viewpoint.
            post: Brings a call to the main thread.
            playback: Controls a recording; None for a live swarm.
        """
        self._client = client
        self.robot = place.robot
        self.history = history
        self._playback = playback
        self._past = Past(client, swarm, history)
        self._time_line = TimeLine(client, is_live=playback is None)
        self._charts = Charts(client, self._time_line.panel)
        self._present = self._swarm = swarm
        self._fleet = fleet
        self._link = link
        self._url = url
        self._post = post
        self._layers = RobotLayers(client.scene)
        self._overlay = Overlay(client.scene, swarm)
        self._view = PageView(client, fleet)
        self._hand = Hand(client, self._use, post)
        self._panel = Panel(client.gui, is_live=link is not None)
        if playback is not None:
            self._panel.keep_only({topics.split(name)[1] for name in playback.robot_topics})
        self._plan = PlanView(client)
        self._has_look = bool(place.robot) or place.camera is not None  # else many get the plan
        if place.robot:
            self._open_tab(ROBOT_TAB)
        self._view.take(View.FOLLOW if place.robot else View.HALL)
        self._opened_with: Viewpoint | None = place
        self._ruler = Ruler(client.scene)
        self._driving: Driving | None = None
        self._is_filming = False
        client.scene.on_click()(self._on_click)
        Inbox(client, self._on_message)
        self._run(f"hints = {json.dumps(self._panel.hints)}")
        self._panel_due = self._slow_due = 0.0
        self._planned: list[str] = []
        self._plans_due = 0.0
        self._was_there = False
        self._noticed = ""
        self._connect()

    # What the panel's widgets do

    def _connect(self) -> None:
        """Let the widgets act."""
        panel, click, change = self._panel, self._when_clicked, self._when_changed
        change(panel.robot, lambda robot: self.select("" if robot == NOBODY else robot))
        click(panel.view, lambda: self.look(View(panel.view.value)))
        change(panel.whole_walls, lambda whole: self._view.show_walls(whole=whole))
        change(panel.dark, lambda dark: self._view.set_dark(dark=dark))
        click(panel.measure, lambda: self._receive_tool(Tool.MEASURE))
        panel.picture.on_click(lambda _: self._save_picture())  # on viser's thread: it waits
        click(panel.film, self._film)
        click(panel.keys, lambda: self._run("showKeys()"))
        click(panel.link, self._copy_link)
        if self._link is not None:
            self._connect_orders(self._link)

    def _connect_orders(self, link: OperatorLink) -> None:
        """Let the widgets act that give orders to the swarm."""
        panel, say, give = self._panel, self._say, self._give_order
        click, change = self._when_clicked, self._when_changed
        driving = self._driving = Driving(link)
        click(panel.pause, lambda: give(lambda: link.set_paused(not link.is_paused, say)))
        click(panel.step, lambda: give(lambda: link.step(1, say)))
        change(panel.speed, lambda name: give(lambda: link.set_speed(SPEEDS[name], say)))
        click(panel.spawn, lambda: give(lambda: link.spawn(panel.model.value, None, say)))
        click(panel.place, lambda: self._receive_tool(Tool.SPAWN))
        click(panel.tool, lambda: self._receive_tool(Tool(panel.tool.value)))
        click(panel.head, lambda: self._follow_chain(self.robot))
        click(panel.cancel, lambda: give(lambda: link.cancel(self.robot, say), needs_robot=True))
        click(panel.remove, lambda: give(lambda: self._ask_to_remove(link), needs_robot=True))
        drive = self._drive
        click(panel.drive, lambda: give(lambda: drive(driving), needs_robot=not driving.robot))
        change(panel.share, driving.set_share)

    def _when_clicked(self, button: Any, do: Callable[[], None]) -> None:
        """Do something on the main thread when a button is clicked."""
        button.on_click(lambda _: self._post(do))

    def _when_changed(self, widget: Any, do: Callable[[Any], None]) -> None:
        """Do something with a value that the reader has changed, not with one that we changed."""

        def on_update(event: Any) -> None:
            value = event.target.value
            if event.client is not None:
                self._post(lambda: do(value))

        widget.on_update(on_update)

    def _give_order(self, order: Callable[[], None], *, needs_robot: bool = False) -> None:
        """Give an order to the swarm, unless the page shows the past."""
        if needs_robot and not self.robot:
            self._say(SELECT_FIRST)
        elif self._past.time is not None:
            self._say(LEAVE_PAST)
        else:
            order()

    def _ask_to_remove(self, link: OperatorLink) -> None:
        robot = self.robot
        self._panel.confirm(
            f"Take {robot} out of the world? Its goal counts as missed.",
            f"Remove {robot}",
            lambda: self._post(lambda: link.remove(robot, self._say)),
        )

    def _drive(self, driving: Driving) -> None:
        if driving.robot:
            driving.end()
        else:
            driving.begin(self.robot, self._say, self._show_driving)
        self._show_driving()

    def _save_picture(self) -> None:
        """Save a picture; waits for the page."""
        client, camera = self._client, self._view.camera
        if camera is None:
            return
        size = round(camera.width), round(camera.height)
        image = client.get_render(
            FINER * size[1], FINER * size[0], transport_format="png", timeout=RENDER_LIMIT
        )
        content = io.BytesIO()
        smooth = Image.fromarray(image).convert("RGB").resize(size, Image.Resampling.LANCZOS)
        smooth.save(content, "PNG")
        name = f"swarm_{self.shown_time:.1f}s.png"
        client.send_file_download(name, content.getvalue(), save_immediately=True)
        self._post(lambda: self._say(f"Saved {name}."))

    def _film(self) -> None:
        self._is_filming = not self._is_filming
        self._panel.film.label = STOP_FILM if self._is_filming else FILM
        name = json.dumps(f"swarm_{self.shown_time:.1f}s")
        script = "startFilm()" if self._is_filming else f"stopFilm({name})"
        run_script(self._client, f"window.swarm.{script}")

    def _copy_link(self) -> None:
        camera, time = self._view.camera, self.shown_time
        is_past = self._playback is not None or self._past.time is not None
        view = None if camera is None else np.array([camera.position, camera.target])
        place = Viewpoint(self.robot, view, time if is_past else None, self._view.is_dark)
        run_script(self._client, f"window.swarm.copy({json.dumps(self._url('', place))})")

    def _show_driving(self) -> None:
        robot = "" if self._driving is None else self._driving.robot
        self._panel.show_driving(robot)
        run_script(self._client, f"window.swarm.setDriving({str(bool(robot)).lower()})")

    def close(self) -> None:
        """Release the robot that is driven; the page is gone."""
        if self._driving is not None:
            self._driving.end()

    def _say(self, text: str) -> None:
        assign(self._panel.message, text)

    def notice(self, text: str) -> None:
        """Say something in the middle of the page; empty for nothing."""
        if text != self._noticed:
            self._noticed = text
            run_script(self._client, f"window.swarm.notice({json.dumps(text)})")

    def end(self, text: str) -> None:
        """Say why nothing comes any more; the page keeps its picture."""
        run_script(self._client, f"window.swarm.end({json.dumps(text)})")

    # What it needs

    @property
    def eye(self) -> FloatArray:
        """Where its camera is (3,), in map."""
        return self._view.eye

    def topics(self) -> set[str]:
        """Return the topics that it shows beside those that every page shows."""
        wanted = set()
        if self.robot:
            layers = self._panel.wanted_layers()
            wanted |= {topics.of_layer(self.robot, layer) for layer in layers}
        wanted |= {topics.of_layer(name, Layer.PLAN) for name in self._planned}
        if self._shows_tubes():
            wanted |= {topics.of_layer(name, Layer.MOTION) for name in self._swarm.names}
        return wanted

    def select(self, robot: str) -> None:
        """Look at a robot; empty for none."""
        self.robot = robot
        self._was_there = False
        self._view.rest()
        self._layers.clear()
        if robot:
            self._open_tab(ROBOT_TAB)
        self._panel_due = 0.0

    def look(self, view: View) -> None:
        """Look from a preset."""
        if view in (View.FOLLOW, View.EYE) and not self.robot:
            self._say(SELECT_FIRST)
            return
        self._has_look = True
        if view is View.PLAN:
            self._plan.fit()
            self._plan.follow(is_wanted=False)
        elif view is View.FOLLOW and self._plan.is_on:
            self._plan.follow(is_wanted=True)
            return
        self._plan.show(is_on=view is View.PLAN)
        self._view.take(view)
        self._view.show_walls(whole=view is View.EYE or self._panel.whole_walls.value)

    def _follow_chain(self, robot: str) -> None:
        """Select the robot that a chain of waiting robots leads to, and say what it does."""
        if not robot:
            self._say(SELECT_FIRST)
            return
        head, sentence = head_of_chain(robot, self._swarm.states)
        self.select(head)
        self._say(html.escape(sentence))

    def _open_tab(self, name: str) -> None:
        self._run(f"openTab({json.dumps(name)})")

    def _run(self, call: str) -> None:
        run_script(self._client, f"window.swarm.{call}")

    # Drawing

    def update(self, poses: FloatArray, now: float, cpu: str) -> None:
        """Update the page for robots at poses (n, 3) in map; `now` is wall time, `cpu` a text."""
        if self._driving is not None:
            self._driving.update(now)
        self._past.play(now)
        if self._past.time is not None:
            poses = self._past.swarm.track.latest
        self._show(self._past.time is not None)
        self._draw_robot(poses, now)
        if self._plan.is_on:
            self._plan.move(poses)
        self._draw_time(now)
        self._charts.update(self.history, now)
        if now >= self._slow_due:
            self._slow_due = now + SLOW_PERIOD
            self._choose_plans(poses, now)
            if self._plan.is_on:
                self._draw_plan()
            else:
                self._draw_scene(poses, now)
        if now >= self._panel_due:
            self._panel_due = now + PANEL_PERIOD
            self._tell(cpu)

    def _draw_scene(self, poses: FloatArray, now: float) -> None:
        panel = self._panel
        self._view.scale_marks(poses, now)
        self._draw_labels(poses)
        self._overlay.draw_plans(self._planned)
        self._overlay.draw_trails(wanted=panel.trails.value)
        self._overlay.draw_claims(wanted=panel.claims.value)

    def _draw_plan(self) -> None:
        planned = self._planned
        if self.robot and Layer.PLAN in self._panel.wanted_layers():
            planned = [*planned, self.robot]
        fleet = self._past.fleet if self._past.time is not None else self._fleet
        self._plan.tell(
            self._swarm, fleet.meshes, self.robot, planned, is_dark=self._view.is_dark,
            names=self._panel.names.value, tubes=self._shows_tubes(),
        )  # fmt: skip

    def _shows_tubes(self) -> bool:
        is_small = self._plan.is_on and len(self._swarm.names) <= MOST_TUBES
        return bool(self._panel.claims.value) or is_small

    def _show(self, is_past: bool) -> None:
        """Show the swarm of the present, or of the past."""
        swarm = self._past.swarm if is_past else self._present
        if swarm is self._swarm:
            return
        self._swarm = self._overlay.swarm = swarm
        self._view.fleet = self._past.fleet if is_past else self._fleet
        self._layers.clear()
        self._slow_due = self._panel_due = 0.0

    def _draw_time(self, now: float) -> None:
        shown = self._playback or (None if self._past.time is None else self._past)
        is_paused = bool(self._link and self._link.is_paused)
        is_playing = not is_paused if shown is None else shown.is_playing
        is_past = self._past.time is not None
        self._time_line.update(
            self.history, now, self.shown_time, is_playing=is_playing, is_past=is_past
        )

    def _choose_plans(self, poses: FloatArray, now: float) -> None:
        """Choose the robots whose plans are shown: those nearest to the middle of the picture."""
        names, camera = self._swarm.names, self._view.camera
        if not self._panel.plans.value or self._past.time is not None:
            self._planned = []
        elif len(names) <= MOST_PLANS:
            self._planned = list(names)
        elif camera is not None and len(poses) == len(names) and now >= self._plans_due:
            self._plans_due = now + PLANS_PERIOD
            gaps = np.hypot(*(poses[:, :2] - camera.target[:2]).T)
            self._planned = [names[row] for row in np.argsort(gaps, kind="stable")[:MOST_PLANS]]

    def _draw_labels(self, poses: FloatArray) -> None:
        camera = self._view.camera
        if camera is None:
            return
        chosen = [self.robot] if self.robot else []
        states = self._swarm.states
        others = [name for name in self._swarm.names if name != self.robot]
        if self._panel.names.value:  # of labels in one place, those of robots that drive go first
            chosen += sorted(others, key=lambda name: is_driving(states.get(name)))
        self._overlay.draw_labels(chosen, poses, self._view.sizes, camera)

    def _draw_robot(self, poses: FloatArray, now: float) -> None:
        index = self._swarm.index(self.robot)
        if not self._has_look and len(self._swarm.names) >= FROM and self._swarm.map is not None:
            self.look(View.PLAN)
        if self._swarm.map is not None:
            self._view.show_map(self._swarm.map)
        self._view.update(poses, index, now)
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
        swarm, panel, link, robot = self._swarm, self._panel, self._link, self.robot
        time = self.shown_time
        panel.offer(swarm.names, robot)
        paused = None if link is None else link.is_paused
        assign(panel.verdict, verdict_html(swarm, paused, cpu))
        if self._is_filming:
            rows, legend = figures(swarm, paused, cpu), counted_legend(swarm.states)
            self._run(f"figures = {json.dumps(rows)}; window.swarm.legend = {json.dumps(legend)}")
        assign(panel.status, self._robot_text() if robot else "")
        changes = self.history.changes(robot, time, SHOWN_CHANGES) if robot else []
        assign(panel.history, history_html(changes, time) if robot else "")
        assign(panel.topics, topics_html(robot) if robot else "")
        is_wanted = robot and panel.way.value
        self._overlay.draw_way(self.history.way(robot, time) if is_wanted else None)
        assign(panel.stations, stations_html(swarm.states))
        if link is not None:
            panel.show_running(link.is_paused, link.speed)

    def _robot_text(self) -> str:
        robot, state = self.robot, self._swarm.states.get(self.robot)
        true_pose = None if state is None else self._swarm.true_pose(robot, state.tick)
        time = self.shown_time
        since = self.history.state_since(robot, time)
        saw_begin = since is None or self.history.saw_begin(robot, since)
        return robot_html(
            robot, self._swarm.states, self._url(robot, None), true_pose, since, time, saw_begin,
            is_past=self._past.time is not None,
        )  # fmt: skip

    # Clicks and tools

    def _on_message(self, kind: str, value: Any) -> None:
        """The page's script tells something; on viser's threads."""
        if kind == "size" and (size := numbers(value, 2)) is not None:
            self._post(lambda: self._resize(*size))
        elif kind == "drive" and self._driving and (way := numbers(value, 2)) is not None:
            steer = self._driving.steer
            self._post(lambda: steer(way[0], way[1], time.monotonic()))
        elif kind == "filmed" and isinstance(value, int | float):
            self._post(lambda: self._say(f"Saved a film of {value / 1e6:.1f} MB."))
        elif kind == "select" and value in self._swarm.names:
            self._post(lambda: self.select(value))
        elif kind == "follow-chain" and value in self._swarm.names:
            self._post(lambda: self._follow_chain(value))
        elif kind == "plan-floor" and (place := numbers(value, 2)) is not None:
            self._post(lambda: self._click_floor(np.array(place)))
        elif kind == "plan-tool" and (drawn := numbers(value, 4)) is not None:
            self._post(lambda: self._use_in_plan(np.array(drawn[:2]), np.array(drawn[2:])))
        elif kind == "plan-carry" and isinstance(value, list):
            if (line := numbers(value[1:], 4)) is not None:
                name, start, end = str(value[0]), np.array(line[:2]), np.array(line[2:])
                self._post(lambda: self._carry(name, start, end))
        elif kind == "key" and isinstance(value, str):
            self._post(lambda: self._press(value))
        elif kind == "copied" and isinstance(value, str):
            self._post(lambda: self._say(f"Copied: `{value}`"))
        elif kind in TIME_ORDERS and isinstance(value, int | float) and abs(value) < 1e7:
            self._post(lambda: self._turn_time(kind, float(value)))

    def _resize(self, width: float, height: float) -> None:
        self._view.resize(width, height)
        self._time_line.place(width)
        self._open()

    def _open(self) -> None:
        """Go where the address says; done once, when the page can be told."""
        place, self._opened_with = self._opened_with, None
        if place is None:
            return
        if place.is_dark:
            self._panel.dark.value = True
            self._view.set_dark(dark=True)
        if place.camera is not None:
            position, target = place.camera
            self._view.go(target, position)
        if place.time is not None:
            self._turn_time("seek", place.time)

    def _turn_time(self, kind: str, value: float) -> None:
        """Go to another time: of a recording with all pages, of a live swarm on this one only."""
        now, past, playback = time.monotonic(), self._past, self._playback
        shown = self.shown_time
        if kind == "mark":
            mark = next_mark(self.history.marks, shown, 1 if value > 0 else -1)
            if mark is None:
                self._say("There is no further mark.")
                return
            kind, value = "seek", mark.time
            self._say(f"{mark.time:.1f} s: {html.escape(mark.text)}")
        elif kind == "step":
            past.is_playing = False
            if playback is not None:
                playback.step(round(value))
                return
            kind, value = "seek", shown + value * CONTROL_PERIOD
        if playback is not None:
            playback.toggle() if kind == "play" else playback.jump(value)
        elif kind == "live" or (kind == "seek" and value >= self.history.span[1]):
            past.leave()
        elif kind == "play":
            past.is_playing = not past.is_playing
        elif not past.go(value, now):
            self._say(UNKNOWN_TIME)
        elif (gap := self.history.gap_at(value)) is not None:
            self._say(f"Nothing is known from {gap[0]:.1f} s to {gap[1]:.1f} s: no page was open.")

    @property
    def shown_time(self) -> float:
        """[s] of simulated time that the page shows."""
        if self._playback is not None:
            return self._playback.time
        return self._swarm.time if self._past.time is None else self._past.time

    def _receive_tool(self, tool: Tool) -> None:
        self._hand.drop()
        self._ruler.clear()
        self._say("")
        if tool is Tool.SELECT or self._swarm.map is None:
            return
        if self._past.time is not None and tool is not Tool.MEASURE:
            self._say(LEAVE_PAST)
        elif tool in ORDERS and not self.robot:
            self._say(SELECT_FIRST)
        elif tool is Tool.MOVE:
            self.look(View.PLAN)
            self._hand.take(tool, self._swarm.map)
            self._say(MOVE_IN_PLAN)
        else:
            self._hand.take(tool, self._swarm.map)
            whose = f" for {self.robot}" if tool in ORDERS else ""
            self._say(f"**{tool.value}**{whose}: click the floor, or drag.")

    def _on_click(self, event: Any) -> None:
        """A click anywhere in the scene; on viser's threads."""
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
        elif (point := on_floor(origin, direction)) is not None:
            self._click_floor(point)

    def _click_floor(self, point: FloatArray) -> None:
        if self._past.time is None:  # there, what was refused stays in sight
            self._say(f"Clicked: x {point[0]:.2f}, y {point[1]:.2f}.")

    def _use_in_plan(self, start: FloatArray, tip: FloatArray) -> None:
        tool = self._hand.tool
        if tool not in (Tool.SELECT, Tool.MOVE):
            self._hand.drop()
            self._use(tool, start, None if (start == tip).all() else tip)

    def _carry(self, name: str, start: FloatArray, end: FloatArray) -> None:
        """Put a robot or an object elsewhere; the world refuses where it does not fit."""
        if name in self._swarm.stations:
            self._say(f"`{name}: [{end[0]:.2f}, {end[1]:.2f}, …]`  \n{STATIONS_STAY}")
            return
        link = self._link
        if link is None or self._past.time is not None:
            self._say(LEAVE_PAST)
            return
        pose = self._swarm.pose_at(name, -1)
        yaw = None if pose is None else float(pose[2])
        self._say(f"Moving {html.escape(name)} to ({end[0]:.2f}, {end[1]:.2f}).")
        known = "" if pose is None else name
        link.move(known, self._swarm.names, start, end, yaw, self._say)

    def _press(self, key: str) -> None:
        """Do what a key of the page stands for; see `swarm.keys` in page.js."""
        if key == "f":
            self.look(View.FOLLOW)
        elif key == "g":
            self._receive_tool(Tool.GOAL)
        elif key == "p":
            self.look(View.HALL if self._plan.is_on else View.PLAN)
        elif key == "Escape" and self._hand.tool is not Tool.SELECT:
            self._receive_tool(Tool.SELECT)
        elif key == "Escape" and self._past.time is not None:
            self._turn_time("live", 0.0)
        elif key == "Escape":
            self.select("")

    def _measure(self, point: FloatArray, tip: FloatArray | None) -> None:
        distance = self._ruler.point(point) if tip is None else self._ruler.measure(point, tip)
        if distance is not None:
            self._say(f"Measured: {distance:.2f} m.")
        elif self._swarm.map is not None:
            self._hand.take(Tool.MEASURE, self._swarm.map)
            self._say("**Measure**: click the other place.")

    def _use(self, tool: Tool, point: FloatArray, tip: FloatArray | None) -> None:
        """Apply a tool to a place (2,) in map, with an arrow to `tip` (2,)."""
        if tool is Tool.MEASURE:
            self._measure(point, tip)
            return
        link = self._link
        if link is None or (tool in ORDERS and not self.robot):
            return
        yaw = None if tip is None else heading(point, tip)
        yaw = self._usual_heading(tool, point) if yaw is None else yaw
        pose = Pose(float(point[0]), float(point[1]), yaw)
        self._say(f"{tool.value} sent: ({pose.x:.2f}, {pose.y:.2f}, {pose.yaw:.2f}).")
        if tool is Tool.SPAWN:
            link.spawn(self._panel.model.value, pose, self._say)
        elif tool is Tool.GOAL:
            link.send_goal(self.robot, pose, self._say)
        else:
            link.set_initial_pose(self.robot, pose, self._say)

    def _usual_heading(self, tool: Tool, point: FloatArray) -> float:
        """Return the yaw for a click without a drag: a goal faces away from the robot."""
        pose = self._swarm.pose_at(self.robot, -1)
        if pose is None or tool is Tool.SPAWN:
            return 0.0
        if tool is Tool.GOAL:
            return math.atan2(point[1] - pose[1], point[0] - pose[0])
        return float(pose[2])
