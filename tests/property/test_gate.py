"""Property: a gate before a narrow region bounds who is inside, and keeps nobody out for good."""

import pytest

from tests.fakes.aisle import HOMES, Census, party

CONTEST = 120.0  # [s] that the robots wait at least, all together


@pytest.mark.parametrize("seed", [0, 1])
def test_everybody_gets_through_a_gate_that_is_contested(seed):
    census = Census()
    narrow = {"holding__region_density": 0.05, "holding__approach_slots": 1}
    result = party(seed, **narrow).run(census.watch())
    assert 0.1 * sum(census.waited.values()) > CONTEST
    assert census.entered == set(range(len(HOMES)))
    assert result.is_flawless, result
    assert 0.1 * max(census.waited.values()) < 0.7 * 600.0
