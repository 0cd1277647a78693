"""Property: robots that want to opposite sides of a door one robot wide all get through."""

from __future__ import annotations

import pytest

from tests.fakes.doorway import party

HELD_SLACK = -0.06  # [m] that held tubes keep, less both radii; waffles touch at -0.09


@pytest.mark.parametrize("seed", range(4))
def test_opposing_robots_all_get_through_a_door(seed: int) -> None:
    result = party(seed, each=3, tilt=0.25 * (seed // 2)).run()
    assert result.is_flawless, result
    assert result.min_held_slack is not None
    assert result.min_held_slack > HELD_SLACK


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("seed", range(100, 160))
def test_many_opposing_robots_all_get_through_a_door(seed: int) -> None:
    result = party(seed, each=4, tilt=0.1 * (seed % 5)).run()
    assert result.is_flawless, result
