"""Joint plans that can be driven, and those that cannot."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_central.plan_check import FaultKind, first_fault, sentence
from swarm_central.roadmap import grid_roadmap
from tests.oracles.plan_faults import faults_of_plan

# Vertices 0 1 2
#          3 4 5
ROADMAP = grid_roadmap(np.ones((2, 3), np.bool_))
NAMES = ("A", "B", "C", "D")


def fault_in(*steps, start=None, goals=None):
    """Return the fault of a plan from its own first step to its own last, if not told otherwise."""
    plan = np.array(steps, np.int32)
    return first_fault(
        plan,
        ROADMAP.costs.neighbors,
        start=np.array(start or steps[0], np.int32),
        goals=np.array(goals or steps[-1], np.int32),
        may_rotate=False,
    )


@pytest.mark.parametrize(
    "steps",
    [
        [[0]],
        [[0], [1], [1], [2]],
        [[0, 1], [1, 2]],  # one follows the other
        [[0, 1, 2], [3, 0, 1], [4, 3, 0]],
    ],
)
def test_what_robots_can_drive_passes(steps):
    assert fault_in(*steps) is None


@pytest.mark.parametrize(
    ("steps", "ends", "kind", "told"),
    [
        ([[0, 1]], {"start": [0, 2]}, "start", "B begins at (1,0); it is at (2,0)"),
        ([[0], [1]], {"goals": [2]}, "goal", "A ends at (1,0) in step 1; its goal is (2,0)"),
        (
            [[0, 5], [0, 0]],
            {},
            "jump",
            "B goes from (2,1) to (0,0) in step 1; a robot waits or goes to one of the four cells "
            "beside its own",
        ),
        ([[0, 2], [0, 2], [1, 1]], {}, "shared", "A and B are both at (1,0) in step 2"),
        ([[0, 4, 1], [1, 4, 0]], {}, "swap", "A and C change places at (0,0) and (1,0) in step 1"),
        (
            [[0, 1, 4, 3], [1, 4, 3, 0]],
            {},
            "circle",
            "A and B and C and D move on in a circle through (0,0) and (1,0) in step 1; robots "
            "with delays cannot do that at once",
        ),
        ([[0, 0]], {}, "shared", "A and B are both at (0,0) in step 0"),
    ],
)
def test_each_rule_is_told_with_robot_step_and_cell(steps, ends, kind, told):
    fault = fault_in(*steps, **ends)
    assert fault.kind == kind
    assert sentence(fault, NAMES, ROADMAP.cells) == told


def test_a_missing_way_between_neighbouring_cells_is_told_as_a_wall():
    neighbors = ROADMAP.costs.neighbors.copy()
    neighbors[neighbors == 1] = -1
    fault = first_fault(np.array([[0], [1]], np.int32), neighbors)
    assert fault is not None
    assert "a thin wall is between them" in sentence(fault, NAMES, ROADMAP.cells)


@st.composite
def plans(draw):
    """Return a plan of mostly single moves on the 2 x 3 grid, a start and goals."""
    count = draw(st.integers(1, 4))
    steps = [draw(st.permutations(range(6)))[:count]]
    for _ in range(draw(st.integers(0, 3))):
        near = [[v, *(n for n in ROADMAP.costs.neighbors[v] if n >= 0)] for v in steps[-1]]
        anywhere = draw(st.integers(0, 9)) == 0
        steps.append([draw(st.sampled_from(range(6) if anywhere else each)) for each in near])
    ends = [
        draw(st.permutations(range(6)))[:count] if draw(st.integers(0, 9)) == 0 else own
        for own in (steps[0], steps[-1])
    ]
    return np.array(steps, np.int32), np.array(ends[0], np.int32), np.array(ends[1], np.int32)


@given(plans(), st.booleans())
@settings(max_examples=400, deadline=None, derandomize=True)
def test_faults_are_those_of_the_oracle(drawn, may_rotate):
    steps, start, goals = drawn
    neighbors = ROADMAP.costs.neighbors
    step, kinds = faults_of_plan(
        steps.tolist(), neighbors.tolist(), start.tolist(), goals.tolist(), may_rotate=may_rotate
    )
    fault = first_fault(steps, neighbors, start=start, goals=goals, may_rotate=may_rotate)
    if fault is None:
        assert kinds == set()
        return
    assert fault.kind in kinds
    assert fault.step == step
    assert sentence(fault, NAMES, ROADMAP.cells)
    if fault.kind in (FaultKind.START, FaultKind.GOAL):
        return
    assert steps[fault.step, fault.robots[0]] == fault.target
