"""The camera that goes with a robot, on a page that reports late."""

import contextlib
from collections import deque
from typing import Any

import numpy as np
import pytest

from swarm_view.chase import CLOSE_UP, Chase

FRAME = 0.04  # [s]


class Camera:
    """What viser's handle knows: what was set, until an older report of the page comes in."""

    def __init__(self, late: int) -> None:
        """Show something else; reports take `late` frames."""
        self.shown = np.zeros(3), np.array([0.0, -20.0, 30.0])
        self._look_at, self._position = self.shown
        self._reports: deque[Any] = deque([self.shown] * late)

    @property
    def look_at(self) -> np.ndarray:
        return self._look_at

    @look_at.setter
    def look_at(self, value: np.ndarray) -> None:
        self._look_at = value
        self.shown = value, self.shown[1]

    @property
    def position(self) -> np.ndarray:
        return self._position

    @position.setter
    def position(self, value: np.ndarray) -> None:
        self._look_at = self._look_at + value - self._position
        self._position = value
        self.shown = self._look_at, value

    def frame(self, turn: float) -> None:
        """Let the reader turn the page's camera, and an old report come in."""
        look_at, position = self.shown
        cos, sin = np.cos(turn), np.sin(turn)
        matrix = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        self.shown = look_at, look_at + matrix @ (position - look_at)
        self._reports.append(self.shown)
        self._look_at, self._position = self._reports.popleft()


class Client:
    """A page."""

    def __init__(self, late: int) -> None:
        """Report `late` frames late."""
        self.camera = Camera(late)

    def atomic(self) -> contextlib.AbstractContextManager[None]:
        """Group messages."""
        return contextlib.nullcontext()


@pytest.mark.parametrize("late", [0, 1, 5, 50])
def test_a_robot_that_has_driven_is_in_the_middle(late: int) -> None:
    client = Client(late)
    chase, drawn = Chase(client), []
    for frame in range(1000):
        x = 0.3 + 0.26 * FRAME * min(frame, 800)
        chase.follow(np.array([x, 1.0, 0.0]), frame * FRAME)
        drawn.append((client.camera.shown, x))
        client.camera.frame(0.0)
    (look_at, position), x = client.camera.shown, drawn[-1][1]
    assert np.abs(look_at - (x, 1.0, 0.0)).max() < 1e-2
    assert position - look_at == pytest.approx(CLOSE_UP)
    off = [abs(shown[0][0] - x) for shown, x in drawn[100:]]
    assert max(off) < 0.03


@pytest.mark.parametrize("late", [0, 2, 5])
def test_a_reader_turns_the_view_of_a_robot_that_drives(late: int) -> None:
    client = Client(late)
    chase, step = Chase(client), 0.26 * FRAME
    for frame in range(1000):
        chase.follow(np.array([step * frame, 0.0, 0.0]), frame * FRAME)
        client.camera.frame(0.02 if 300 <= frame < 350 else 0.0)
    look_at, position = client.camera.shown
    assert look_at[0] == pytest.approx(999 * step, abs=1e-2)
    turned = position - look_at
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(CLOSE_UP), abs=1e-3)
    angle = np.arctan2(turned[1], turned[0]) - np.arctan2(CLOSE_UP[1], CLOSE_UP[0])
    assert angle == pytest.approx(1.0, abs=0.02 * (late + 1))
