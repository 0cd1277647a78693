"""The panel of one page: its displays and buttons. Widgets only; `Page` says what they do."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any

from swarm_describe.robots.source import robot_names
from swarm_view.page.tool import BUTTONS, ORDERS, Tool
from swarm_view.scene.views import View
from swarm_view.state.topics import LABELS, SHOWN_AT_FIRST, Layer

MOST_PLANS = 20
FILM, STOP_FILM = "Record film", "Stop and save film"
_KEY = (
    "border:1px solid #8888;border-radius:6px;background:transparent;color:inherit;width:3em;"
    "height:2.2em;touch-action:none;cursor:pointer"
)
PAD = (
    "<div style='padding:0.3em 0.8em;font-size:0.85rem;text-align:center'>"
    + "".join(
        f"<button style='{_KEY}' data-swarm-way='{key}'>{sign}</button>{after}"
        for key, sign, after in (
            ("KeyW", "W ▴", "<br>"),
            ("KeyA", "A ◂", " "),
            ("KeyS", "S ▾", " "),
            ("KeyD", "D ▸", ""),
        )
    )
    + "<br>Keep a key pressed: without one the robot stops.</div>"
)
NOBODY = "(none)"
FIRST_MODEL = "turtlebot3_waffle"
SPEEDS = {
    "0.25 x": 0.25, "0.5 x": 0.5, "1 x": 1.0, "2 x": 2.0, "5 x": 5.0, "10 x": 10.0, "max": 0.0,
}  # fmt: skip


class Panel:
    """The widgets; those that give orders to the swarm are there on live pages only."""

    def __init__(self, gui: Any, *, is_live: bool) -> None:
        self._gui = gui
        self.hints: dict[str, str] = {}  # of buttons by their labels, which viser does not show
        self.message = gui.add_markdown("")  # in sight, whatever is open below
        tabs = gui.add_tab_group()
        with tabs.add_tab("Run"):
            if is_live:
                self._add_simulation()
            self.verdict = gui.add_html("")
            with gui.add_folder("Stations", expand_by_default=False):
                self.stations = gui.add_html("")
            if is_live:
                self._add_spawning()
        with tabs.add_tab("Robot"):
            self.robot = gui.add_dropdown("Robot", (NOBODY,))
            self.status = gui.add_html("")
            if is_live:
                self._add_orders()
            with gui.add_folder("Show", expand_by_default=False):
                self.layers = {
                    layer: gui.add_checkbox(LABELS[layer], layer in SHOWN_AT_FIRST)
                    for layer in Layer
                }
                self.way = gui.add_checkbox("Its way so far", False)
            with gui.add_folder("History", expand_by_default=False):
                self.history = gui.add_html("")
            with gui.add_folder("Topics", expand_by_default=False):
                self.topics = gui.add_html("")
            if is_live:
                with gui.add_folder("What cannot be undone", expand_by_default=False):
                    self.remove = self._button("Remove robot", "Takes it out of the world", "red")
        with tabs.add_tab("View"):
            self._add_view()

    def _button(self, label: str, hint: str, color: Any = None) -> Any:
        self.hints[label] = hint
        return self._gui.add_button(label, color=color)

    def _add_view(self) -> None:
        gui = self._gui
        self.view = gui.add_button_group(
            "Camera",
            [view.value for view in View],
            hint="Plan, top and hall show all of it; the other two go with the robot",
        )
        self.whole_walls = gui.add_checkbox(
            "Whole walls", False, hint="Else they are cut at 0.5 m, so that robots are seen"
        )
        self.dark = gui.add_checkbox("Dark", False)
        with gui.add_folder("Show of all robots"):
            self.names = gui.add_checkbox("Names and states", False)
            self.plans = gui.add_checkbox(
                f"Plans of up to {MOST_PLANS} robots", False, hint="Those nearest to the middle"
            )
            self.trails = gui.add_checkbox("Trails", False)
            self.claims = gui.add_checkbox("Committed motion", False)
        self.link = self._button("Copy link", "To this camera, robot and time")
        self.measure = self._button("Measure", "Click two places on the floor, or drag")
        self.picture = self._button("Save picture", "As PNG")
        self.film = self._button(FILM, "As WebM or MP4")
        self.keys = self._button("Keys", "All keys of this page, also with ?")

    def _add_simulation(self) -> None:
        gui = self._gui
        self.pause = gui.add_button("Pause")
        self.step = gui.add_button("Step 0.1 s", disabled=True)
        self.speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1 x")

    def _add_orders(self) -> None:
        gui = self._gui
        tools = [tool.value for tool in (Tool.SELECT, *ORDERS, Tool.MOVE)]
        self.tool = gui.add_button_group(
            "Tool", tools, hint="Goal and initial pose: click the floor, or drag for a heading"
        )
        self.head = self._button("Head of its chain", "To the robot that all of them wait for")
        self.cancel = gui.add_button("Cancel goal")
        self.drive = self._button("Drive by hand", "With the keys W A S D or the arrows")
        self.pad = gui.add_html(PAD, visible=False)
        self.share = gui.add_slider(
            "Speed of driving", min=0.1, max=1.0, step=0.05, initial_value=0.5, visible=False
        )

    def keep_only(self, recorded: Collection[str]) -> None:
        """Disable what a recording has not; `recorded` are topics in a robot's namespace."""
        boxes = [*self.layers.items(), (Layer.PLAN, self.plans), (Layer.MOTION, self.claims)]
        for layer, box in boxes:
            if layer.value not in recorded:
                box.value, box.disabled = False, True
                box.hint = f"Not in this recording: {layer.value} of --record-topics"

    def confirm(self, question: str, answer: str, do: Callable[[], None]) -> None:
        """Ask before something is done that cannot be undone."""
        modal = self._gui.add_modal(question)
        with modal:
            yes = self._gui.add_button(answer, color="red")
            no = self._gui.add_button("Cancel")

        def accept(_: Any) -> None:
            modal.close()
            do()

        yes.on_click(accept)
        no.on_click(lambda _: modal.close())

    def show_driving(self, robot: str) -> None:
        """Show the pad while a robot is driven."""
        self.drive.label = f"Give {robot} back" if robot else "Drive by hand"
        self.pad.visible = self.share.visible = bool(robot)

    def _add_spawning(self) -> None:
        gui, models = self._gui, robot_names()
        with gui.add_folder("New robots", expand_by_default=False):
            first = FIRST_MODEL if FIRST_MODEL in models else models[0]
            self.model = gui.add_dropdown("Model", models, initial_value=first)
            self.spawn = self._button("Spawn at a free place", "Of the world's start area")
            self.place = self._button(BUTTONS[Tool.SPAWN], "Click the floor, or drag")

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
