"""PIBT and LaCAM* against pymapf and against exhaustive search."""

import numpy as np
import pytest

from swarm_central.lacam import Lacam, lower_bound
from swarm_central.pibt_kernels import Wishes, roll_out
from swarm_central.plan_check import first_fault
from tests.oracles.joint_plans import best_cost
from tests.oracles.pymapf_instances import compare, instance


@pytest.mark.parametrize("may_rotate", [True, False])
def test_plans_are_valid_on_250_random_instances_each(may_rotate):
    rng = np.random.default_rng(7 + may_rotate)
    solved = 0
    for _ in range(250):
        _, roadmap, start, goals = instance(rng, 8, int(rng.integers(2, 12)), 0.2)
        plan = Lacam(roadmap, start, goals, may_rotate=may_rotate).solve(3000)
        if plan is None:
            continue
        solved += 1
        assert first_fault(plan.steps, roadmap.costs.neighbors, may_rotate=may_rotate) is None
        assert (plan.steps[0] == start).all()
        assert (plan.steps[-1] == goals).all()
        assert plan.cost >= lower_bound(roadmap, start, goals).sum()
    assert solved >= 225


def test_pibt_steps_are_valid_and_without_circles_on_500_random_instances():
    rng = np.random.default_rng(3)
    for _ in range(500):
        _, roadmap, start, goals = instance(rng, 6, int(rng.integers(2, 20)), 0.1)
        count, vertices = len(start), len(roadmap.points)
        none = np.zeros(vertices, np.bool_)
        fields = np.stack([roadmap.costs_to(np.array([goal]), none) for goal in goals])
        noise = rng.random((count, 5), np.float32) * np.float32(0.01)
        wishes = Wishes(fields.astype(np.float32), np.arange(count, dtype=np.int32), none, noise)
        plan = roll_out(
            np.arange(count), start, np.zeros(count, np.int32), np.zeros(count, np.bool_),
            np.full(count, -1, np.int32), roadmap.costs, wishes, 8,
        )  # fmt: skip
        assert first_fault(plan, roadmap.costs.neighbors, may_rotate=False) is None


def test_the_best_plan_costs_what_exhaustive_search_finds():
    rng = np.random.default_rng(1)
    for _ in range(25):
        _, roadmap, start, goals = instance(rng, 3, 3, 0.2)
        best = best_cost(roadmap.costs.neighbors.tolist(), start.tolist(), goals.tolist())
        plan = Lacam(roadmap, start, goals).solve(200_000, anytime=True)
        if best is None:
            assert plan is None
        else:
            assert plan.is_best
            assert plan.cost == best


def test_what_pymapf_solves_is_solved():
    solved, missed = compare(20, 5)
    assert missed == 0
    assert solved["ours"] >= solved["lacam"] > 10
