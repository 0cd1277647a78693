"""What the keys of swarm-teleop mean."""

import pytest

from swarm_common.model.records import Twist
from swarm_run.robots.teleop_keys import HOLD, LEAST, MOST, Keys

FULL = Twist(0.26, 0.0, 1.82)


@pytest.mark.parametrize(
    ("typed", "vx", "wz"),
    [
        ("w", 0.13, 0.0),
        ("s", -0.13, 0.0),
        ("a", 0.0, 0.91),
        ("\x1b[C", 0.0, -0.91),
        ("ws", -0.13, 0),
    ],
)
def test_a_key_moves_the_robot_at_half_its_speed(typed, vx, wz):
    keys = Keys(FULL)
    keys.press(typed, 10.0)
    wish = keys.wish(10.1)
    assert (wish.vx, wish.wz) == pytest.approx((vx, wz))


@pytest.mark.parametrize("after", ["", " ", "x", "q"])
def test_without_a_key_the_robot_stops(after):
    keys = Keys(FULL)
    keys.press("w" + after, 10.0)
    later = 10.0 + HOLD if not after else 10.1
    assert keys.wish(later) == Twist()
    assert keys.is_over == (after == "q")


def test_the_speed_has_bounds():
    keys = Keys(FULL)
    keys.press("+" * 20 + "w", 0.0)
    assert keys.share == MOST
    assert keys.wish(0.0) == Twist(0.26, 0.0, 0.0)
    keys.press("-" * 40, 0.0)
    assert keys.share == LEAST
