"""Which robots a LiDAR sees too little of."""

import pytest

from swarm_describe.robots.loading import load_robot, open_robot
from swarm_sim.sensing.lidar import overlooked

BURGER, WAFFLE, TWO, FOUR = (
    "turtlebot3_burger", "turtlebot3_waffle", "linorobot2_2wd", "linorobot2_4wd",
)  # fmt: skip


def told(seer, other, margin=0.26):
    models = {other: open_robot(other).model}
    return list(overlooked([load_robot(seer)] * 2, [load_robot(other)] * 2, models, margin))


def test_a_lidar_that_looks_over_or_short_of_a_body_is_named():
    """A burger drove into a waffle that had never said anything, 138 times."""
    expected = "the LiDAR of a turtlebot3_burger, 0.18 m above the ground, does not meet a "
    assert told(BURGER, WAFFLE) == [f"{expected}{WAFFLE}"]
    (sentence,) = told(FOUR, FOUR, margin=0.2)
    assert "meets a linorobot2_4wd 0.25 m inside of its outline only" in sentence


@pytest.mark.parametrize(("seer", "other"), [(BURGER, TWO), (WAFFLE, TWO), (FOUR, TWO)])
def test_so_is_one_that_looks_between_a_body_and_its_lidar(seer, other):
    assert "does not meet" in told(seer, other)[0]


@pytest.mark.parametrize("model", [BURGER, WAFFLE, TWO, FOUR])
def test_robots_see_their_like(model):
    assert told(model, model) == []
