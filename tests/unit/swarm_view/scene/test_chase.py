"""The camera that goes with a robot, on a page that reports late."""

from collections import deque
from typing import Any

import numpy as np
import pytest

from swarm_view.scene.chase import CLOSE_UP, Chase

FRAME = 0.04  # [s]


class Camera:
    """What a page reports of its camera, some frames late."""

    def __init__(self, late):
        """Show something else; reports take `late` frames."""
        self.shown = np.zeros(3), np.array([0.0, -20.0, 30.0])
        self.look_at, self.position = self.shown
        self._reports: deque[Any] = deque([self.shown] * late)

    def look(self, target, position):
        """Do as told; nothing is known of it before it is reported."""
        self.shown = target, position

    def frame(self, turn):
        """Let the reader turn the page's camera, and an old report come in."""
        look_at, position = self.shown
        cos, sin = np.cos(turn), np.sin(turn)
        matrix = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        self.shown = look_at, look_at + matrix @ (position - look_at)
        self._reports.append(self.shown)
        self.look_at, self.position = self._reports.popleft()


@pytest.mark.parametrize("late", [0, 1, 5, 50])
def test_a_robot_that_has_driven_is_in_the_middle(late):
    camera = Camera(late)
    chase, drawn = Chase(camera, camera.look), []
    for frame in range(1000):
        x = 0.3 + 0.26 * FRAME * min(frame, 800)
        chase.follow(np.array([x, 1.0, 0.0]), frame * FRAME)
        drawn.append((camera.shown, x))
        camera.frame(0.0)
    (look_at, position), x = camera.shown, drawn[-1][1]
    assert np.abs(look_at - (x, 1.0, 0.0)).max() < 1e-2
    assert position - look_at == pytest.approx(CLOSE_UP)
    off = [abs(shown[0][0] - x) for shown, x in drawn[100:]]
    assert max(off) < 0.03


def test_a_page_that_loads_slowly_is_not_its_reader():
    camera = Camera(2)
    chase, first = Chase(camera, camera.look), (np.array([1.0, 2.0, 0.0]), np.array([1, -7, 16.0]))
    chase.expect(*first)
    for frame in range(1000):
        chase.follow(np.array([0.26 * FRAME * frame, 1.0, 0.0]), frame * FRAME)
        if frame == 400:
            camera.shown = first
        camera.frame(0.0)
    look_at, position = camera.shown
    assert position - look_at == pytest.approx(CLOSE_UP)


@pytest.mark.parametrize("late", [0, 2, 5])
def test_a_reader_turns_the_view_of_a_robot_that_drives(late):
    camera = Camera(late)
    chase, step = Chase(camera, camera.look), 0.26 * FRAME
    for frame in range(1000):
        chase.follow(np.array([step * frame, 0.0, 0.0]), frame * FRAME)
        camera.frame(0.02 if 300 <= frame < 350 else 0.0)
    look_at, position = camera.shown
    assert look_at[0] == pytest.approx(999 * step, abs=1e-2)
    turned = position - look_at
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(CLOSE_UP), abs=1e-3)
    angle = np.arctan2(turned[1], turned[0]) - np.arctan2(CLOSE_UP[1], CLOSE_UP[0])
    assert angle == pytest.approx(1.0, abs=0.02 * (late + 1))
