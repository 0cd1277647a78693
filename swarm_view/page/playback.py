"""The controls of a recording on a page: play, speed and where in time it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from swarm_common.model.records import CONTROL_PERIOD
from swarm_view.page.tool import Post
from swarm_view.state.topics import robots_in

if TYPE_CHECKING:
    from swarm_recording.bag_feed import BagFeed  # mcap is slow to import

SPEEDS = {"0.25 x": 0.25, "0.5 x": 0.5, "1 x": 1.0, "2 x": 2.0, "5 x": 5.0, "20 x": 20.0}


class Playback:
    """Widgets that all pages share; `update` and what `post` brings run on one thread."""

    def __init__(
        self, gui: Any, recording: BagFeed, on_jump: Callable[[], None], post: Post
    ) -> None:
        """Build the widgets; `post` brings a call to the thread that draws."""
        self._recording = recording
        self._on_jump = on_jump
        start, end = recording.span
        with gui.add_folder("Playback"):
            self._play = gui.add_button("Pause" if recording.is_playing else "Play")
            # of the choices, the one that is nearest to its speed
            gaps = {name: abs(math.log(speed / recording.speed)) for name, speed in SPEEDS.items()}
            nearest = min(SPEEDS, key=gaps.__getitem__)
            self._speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value=nearest)
            self._time = gui.add_slider(
                "Time [s]", min=start, max=max(end, start + 0.1), step=0.1, initial_value=start
            )
        self._play.on_click(lambda _: post(self.toggle))

        def on_change(widget: Any, do: Callable[[], None]) -> None:
            widget.on_update(lambda event: post(do) if event.client else None)

        def set_speed() -> None:
            recording.speed = SPEEDS[self._speed.value]

        on_change(self._speed, set_speed)
        on_change(self._time, lambda: self.jump(self._time.value))

    def update(self) -> None:
        """Show the state of the playback."""
        label = "Pause" if self._recording.is_playing else "Play"
        if self._play.label != label:
            self._play.label = label
        now = round(self._recording.now, 1)
        if abs(self._time.value - now) >= 0.1:
            self._time.value = now

    @property
    def robot_topics(self) -> set[str]:
        """Topics of robots that the recording has."""
        names = robots_in(self._recording.topics())
        return {name for name in self._recording.topics() if name.split("/")[1] in names}

    @property
    def time(self) -> float:
        """[s] that is shown."""
        return self._recording.now

    @property
    def is_playing(self) -> bool:
        """Whether time goes on."""
        return self._recording.is_playing

    def step(self, ticks: int) -> None:
        """Go some ticks on, or back, and stand still there."""
        self._recording.pause()
        self.jump(self._recording.now + ticks * CONTROL_PERIOD)

    def toggle(self) -> None:
        """Play or pause."""
        recording = self._recording
        if recording.is_playing:
            recording.pause()
        else:
            if recording.now >= recording.span[1]:
                self._on_jump()
            recording.play()
        self.update()

    def jump(self, time: float) -> None:
        """Go to a time [s]."""
        self._recording.seek(time)
        self._on_jump()
        self.update()
