"""Property: robots that want to opposite sides of a door one robot wide all get through."""

import pytest

from tests.fakes.doorway import party


@pytest.mark.parametrize("seed", range(4))
def test_opposing_robots_all_get_through_a_door(seed):
    result = party(seed, each=3, tilt=0.25 * (seed // 2)).run()
    assert result.is_flawless, result
    assert result.least_held_slack is not None


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("seed", range(100, 160))
def test_many_opposing_robots_all_get_through_a_door(seed):
    result = party(seed, each=4, tilt=0.1 * (seed % 5)).run()
    assert result.is_flawless, result
