"""Options of a centre."""

import sys

import pytest

from swarm_bench.suite.selection import select
from swarm_common.model.errors import SwarmError


@pytest.mark.parametrize(
    ("method", "settings", "solver", "told"),
    [
        (
            "ours",
            ["central.planner=lacam"],
            "",
            "needs --method central-mapf or central-reservation or central-with-fallback, not ours",
        ),
        ("central-mapf", ["central.planner=cbs"], "", "planner"),
        ("central-mapf", ["central.plans=3"], "", "plans"),
        ("central-mapf", ["central.horizon=many"], "", "horizon"),
        ("central-mapf", ["central.horizon=0"], "", "expected an integer, 1 or more"),
        ("central-mapf", ["central.horizon"], "", "expected NAME=VALUE"),
        ("central-mapf", [], "/none", "there is no such program"),
        ("central-mapf", [], __file__, "not executable; chmod +x"),
        ("central-mapf", ["central.planner=lacam"], sys.executable, "only one of them can plan"),
        ("central-mapf", ["central.solver=/none"], "", "there is no such program"),
        ("central-mapf", ["central.solver_time=0"], "", "more than 0 and at most 600"),
        ("central-mapf", ["central.solver_time=nan"], "", "solver_time is nan"),
    ],
)
def test_what_is_wrong_is_said(method, settings, solver, told):
    with pytest.raises(SwarmError) as caught:
        select("doorway", [4], [0], method=method, settings=settings, central_solver=solver)
    assert told in str(caught.value)
