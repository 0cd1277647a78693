"""Malformed inputs over every topic, service, action and parameter of a running swarm of three.

`pytest -m long tests/faults/test_fuzz_live.py` throws 100,000 of them; by hand, with any seed:
`python -m tests.fuzz_live --count 100000 --seed 0`.
"""

from pathlib import Path

import pytest

from tests.fuzz_live import fuzz

BUSY = 10.0  # [s] of wall time that a tick may take where other tests run beside this one

pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")


def test_nothing_that_is_malformed_ends_a_process(tmp_path: Path) -> None:
    outcome = fuzz(tmp_path, 2000, seed=0, tick_limit=BUSY)
    assert not outcome.problems, "\n".join(outcome.problems)
    assert len(outcome.sent) > 100  # targets


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("seed", [0])
def test_a_hundred_thousand_times(tmp_path: Path, seed: int) -> None:
    outcome = fuzz(tmp_path, 100_000, seed)
    assert not outcome.problems, "\n".join(outcome.problems)
