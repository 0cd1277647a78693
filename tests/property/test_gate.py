"""Property: a gate before a narrow region bounds who is inside, and keeps nobody out for good."""

from __future__ import annotations

import pytest

from tests.fakes.aisle import HOMES, Census, party


@pytest.mark.parametrize("seed", [0, 1])
def test_everybody_gets_through_a_gate_that_is_contested(seed: int) -> None:
    census = Census()
    result = party(seed).run(census.watch())
    assert max(census.waited.values()) > 100  # ticks: it was contested
    assert census.entered == set(range(len(HOMES)))
    assert result.is_flawless, result
    assert 0.1 * max(census.waited.values()) < 0.7 * 600.0
