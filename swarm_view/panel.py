"""The panel of one page: its displays and buttons. Widgets only, no decisions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from swarm_common.robots.source import robot_names
from swarm_view.tool import Tool
from swarm_view.topics import LABELS, SHOWN_AT_FIRST, Layer
from swarm_view.views import View

NOBODY = "(none)"
FIRST_MODEL = "turtlebot3_waffle"
SPEEDS = {
    "0.25 x": 0.25,
    "0.5 x": 0.5,
    "1 x": 1.0,
    "2 x": 2.0,
    "5 x": 5.0,
    "10 x": 10.0,
    "max": 0.0,
}


class Actions(Protocol):
    """What the panel's owner does when something is clicked; called on viser's threads."""

    def on_select(self, robot: str) -> None:
        """Another robot was chosen; empty for none."""

    def on_tool(self, tool: Tool) -> None:
        """Another tool was chosen."""

    def on_cancel(self) -> None:
        """Cancel the robot's goal."""

    def on_view(self, view: View) -> None:
        """Another view was chosen."""

    def on_walls(self, *, whole: bool) -> None:
        """Walls are to be shown whole, or cut."""

    def on_dark(self, *, dark: bool) -> None:
        """The page is to be dark, or light."""

    def on_pause(self) -> None:
        """Pause or resume."""

    def on_step(self) -> None:
        """Do one step."""

    def on_speed(self, speed: float) -> None:
        """Another speed was chosen; 0 for no limit."""

    def on_spawn(self) -> None:
        """Add a robot at a free place."""

    def on_remove(self) -> None:
        """Take the robot out."""


class Panel:
    """The widgets."""

    def __init__(self, gui: Any, actions: Actions, *, is_live: bool) -> None:
        """Build the widgets; a recording takes no goals."""
        self._gui = gui
        with gui.add_folder("Swarm"):
            self.verdict = gui.add_html("")
        self.message = gui.add_markdown("")
        self._add_view(actions)
        if is_live:
            self._add_simulation(actions)
        with gui.add_folder("Robot"):
            self.robot = gui.add_dropdown("Robot", (NOBODY,))
            self.status = gui.add_html("")
            if is_live:
                self._add_orders(actions)
        if is_live:
            self._add_spawning(actions)
        with gui.add_folder("Show of the robot", expand_by_default=False):
            self.layers = {
                layer: gui.add_checkbox(LABELS[layer], layer in SHOWN_AT_FIRST) for layer in Layer
            }
        with gui.add_folder("Show of all", expand_by_default=False):
            self.names = gui.add_checkbox("Names and states", False)
            self.trails = gui.add_checkbox("Trails", False)
            self.claims = gui.add_checkbox("Committed motion", False)
        with gui.add_folder("Stations", expand_by_default=False):
            self.stations = gui.add_html("")
        self.robot.on_update(_if_typed(lambda: actions.on_select(self._chosen())))

    def _chosen(self) -> str:
        return "" if self.robot.value == NOBODY else str(self.robot.value)

    def _add_view(self, actions: Actions) -> None:
        gui = self._gui
        with gui.add_folder("View"):
            view = gui.add_button_group(
                "Camera", [view.value for view in View],
                hint="Top and hall show all of it; the other two go with the robot",
            )  # fmt: skip
            self.whole_walls = gui.add_checkbox(
                "Whole walls", False, hint="Else they are cut at 0.5 m, so that robots are seen"
            )
            self.dark = gui.add_checkbox("Dark", False)
        view.on_click(lambda _: actions.on_view(View(view.value)))
        self.whole_walls.on_update(
            _if_typed(lambda: actions.on_walls(whole=self.whole_walls.value))
        )
        self.dark.on_update(_if_typed(lambda: actions.on_dark(dark=self.dark.value)))

    def _add_simulation(self, actions: Actions) -> None:
        gui = self._gui
        with gui.add_folder("Simulation"):
            self.pause = gui.add_button("Pause")
            self.step = gui.add_button("Step 0.1 s", disabled=True)
            self.speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1 x")
        self.pause.on_click(lambda _: actions.on_pause())
        self.step.on_click(lambda _: actions.on_step())
        self.speed.on_update(_if_typed(lambda: actions.on_speed(SPEEDS[self.speed.value])))

    def _add_orders(self, actions: Actions) -> None:
        gui = self._gui
        tools = [tool.value for tool in Tool if tool is not Tool.SPAWN]
        tool = gui.add_button_group(
            "Tool", tools, hint="Goal and initial pose: click the floor, or drag for a heading"
        )
        cancel = gui.add_button("Cancel goal")
        remove = gui.add_button("Remove robot", color="red", hint="Takes it out of the world")
        tool.on_click(lambda _: actions.on_tool(Tool(tool.value)))
        cancel.on_click(lambda _: actions.on_cancel())
        remove.on_click(lambda _: actions.on_remove())

    def _add_spawning(self, actions: Actions) -> None:
        gui, models = self._gui, robot_names()
        with gui.add_folder("New robots", expand_by_default=False):
            first = FIRST_MODEL if FIRST_MODEL in models else models[0]
            self.model = gui.add_dropdown("Model", models, initial_value=first)
            spawn = gui.add_button("Spawn at a free place", hint="Of the world's start area")
            place = gui.add_button("Spawn by a click", hint="Click the floor, or drag")
        spawn.on_click(lambda _: actions.on_spawn())
        place.on_click(lambda _: actions.on_tool(Tool.SPAWN))

    def offer(self, robots: Sequence[str], chosen: str) -> None:
        """Offer these robots for selection."""
        options = (NOBODY, *robots)
        if tuple(self.robot.options) != options:
            self.robot.options = options
        value = chosen if chosen in robots else NOBODY
        if self.robot.value != value:
            self.robot.value = value

    def show_running(self, paused: bool | None, speed: float | None) -> None:
        """Show whether the world is paused, and how fast it goes."""
        label = "Resume" if paused else "Pause"
        if self.pause.label != label:
            self.pause.label = label
            self.step.disabled = not paused
        name = next((name for name, value in SPEEDS.items() if value == speed), None)
        if name is not None and self.speed.value != name:
            self.speed.value = name

    def wanted_layers(self) -> set[Layer]:
        """Return the layers that are switched on."""
        return {layer for layer, box in self.layers.items() if box.value}


def assign(widget: Any, content: str) -> None:
    """Change what an HTML or Markdown widget says, if it has changed."""
    if widget.content != content:
        widget.content = content


def _if_typed(do: Callable[[], None]) -> Callable[[Any], None]:
    """Return a callback that ignores what we changed ourselves."""

    def on_update(event: Any) -> None:
        if event.client is not None:
            do()

    return on_update
