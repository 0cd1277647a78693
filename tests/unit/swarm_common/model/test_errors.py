"""Names that are proposed for a misspelt one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.model.errors import close_names, edit_distance

ROBOTS = ["turtlebot3_burger", "turtlebot3_waffle", "carrier", "cart"]


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("wafle", ["turtlebot3_waffle"]),
        ("Burgr", ["turtlebot3_burger"]),
        ("turtlebot3_wafle", ["turtlebot3_waffle"]),
        ("card", ["cart"]),
        ("excavator", []),
        ("", []),
    ],
)
def test_only_the_nearest_names_are_proposed(name, meant):
    assert close_names(name, ROBOTS) == meant


@given(st.text("abc", max_size=6), st.text("abc", max_size=6))
def test_the_edit_distance_is_symmetric_and_bounded(one, other):
    distance = edit_distance(one, other)
    assert distance == edit_distance(other, one)
    assert (distance == 0) == (one == other)
    assert abs(len(one) - len(other)) <= distance <= max(len(one), len(other))
