"""The controls of a recording on a page: play, speed and where in time it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from swarm_common.model.records import CONTROL_PERIOD

if TYPE_CHECKING:
    from swarm_recording.bag_feed import BagFeed  # mcap is slow to import

SPEEDS = {"0.25 x": 0.25, "0.5 x": 0.5, "1 x": 1.0, "2 x": 2.0, "5 x": 5.0, "20 x": 20.0}


class Playback:
    """Widgets that all pages share; `update` and what `post` brings run on one thread."""

    def __init__(
        self,
        gui: Any,
        recording: BagFeed,
        on_jump: Callable[[], None],
        post: Callable[[Callable[[], None]], None],
    ) -> None:
        """Build the widgets; `post` brings a call to the thread that draws."""
        self._recording = recording
        self._on_jump = on_jump
        start, end = recording.span
        with gui.add_folder("Playback"):
            self._play = gui.add_button("Pause" if recording.is_playing else "Play")
            self._speed = gui.add_dropdown(
                "Speed", tuple(SPEEDS), initial_value=_name_of(recording.speed)
            )
            self._time = gui.add_slider(
                "Time [s]", min=start, max=max(end, start + 0.1), step=0.1, initial_value=start
            )
        self._play.on_click(lambda _: post(self.toggle))
        self._speed.on_update(
            lambda event: (
                post(lambda: self._set_speed(SPEEDS[self._speed.value])) if event.client else None
            )
        )
        self._time.on_update(
            lambda event: post(lambda: self.jump(self._time.value)) if event.client else None
        )

    def update(self) -> None:
        """Show the state of the playback."""
        label = "Pause" if self._recording.is_playing else "Play"
        if self._play.label != label:
            self._play.label = label
        now = round(self._recording.now, 1)
        if abs(self._time.value - now) >= 0.1:
            self._time.value = now

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

    def _set_speed(self, speed: float) -> None:
        self._recording.speed = speed

    def jump(self, time: float) -> None:
        """Go to a time [s]."""
        self._recording.seek(time)
        self._on_jump()
        self.update()


def _name_of(speed: float) -> str:
    """Return the choice that is nearest to a speed."""
    return min(SPEEDS, key=lambda name: abs(math.log(SPEEDS[name] / speed)))
