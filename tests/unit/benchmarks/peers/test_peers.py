"""Environments of others beside ours: rounds in turns, and what does not run is named."""

import sys

import pytest

from benchmarks.peers.command import COLUMNS, measure_peers
from swarm_common.model.errors import SwarmError


def test_ours_is_measured_beside_whom_one_asks_for():
    (row,) = measure_peers(["ours"], sys.executable, 1, 0.1)
    assert row.ratios == [1.0]
    assert row.rates[0] > 100.0
    assert [cell(row) for cell in COLUMNS.values()][0::3] == ["ours", "1"]


@pytest.mark.parametrize(
    ("names", "python", "message"),
    [
        (["gazebo"], sys.executable, "unknown simulator 'gazebo'"),
        (["VMAS"], "no-python", "--python is no-python, which does not start"),
        (
            ["VMAS"],
            sys.executable,
            "VMAS does not run with .*No module named '(torch|vmas)'; install it",
        ),
    ],
)
def test_what_does_not_run_is_named(names, python, message):
    with pytest.raises(SwarmError, match=message):
        measure_peers(names, python, 1, 0.1)
