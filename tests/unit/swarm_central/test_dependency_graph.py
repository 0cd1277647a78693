"""Plans are executed to their end, whatever the robots' delays."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_central.dependency_graph import DependencyGraph
from swarm_central.pibt_kernels import Wishes, roll_out
from swarm_central.roadmap import grid_roadmap


def random_plan(seed, robots):
    rng = np.random.default_rng(seed)
    roadmap = grid_roadmap(np.ones((5, 5), np.bool_))
    start, goals = (rng.permutation(25)[:robots].astype(np.int32) for _ in range(2))
    none = np.zeros(25, np.bool_)
    fields = np.stack([roadmap.costs_to(np.array([goal]), none) for goal in goals])
    noise = rng.random((robots, 5), np.float32) * np.float32(0.01)
    wishes = Wishes(fields.astype(np.float32), np.arange(robots, dtype=np.int32), none, noise)
    return roll_out(
        np.arange(robots), start, np.zeros(robots, np.int32), np.zeros(robots, np.bool_),
        np.full(robots, -1, np.int32), roadmap.costs, wishes, 12,
    )  # fmt: skip


@settings(deadline=None, max_examples=150)
@given(st.integers(0, 10_000), st.integers(2, 20), st.randoms(use_true_random=False))
def test_any_order_of_execution_ends_and_no_vertex_is_shared(seed, robots, random):
    plan = random_plan(seed, robots)
    graph = DependencyGraph(plan)
    at = plan[0].tolist()
    visits = {vertex: [robot] for robot, vertex in enumerate(at)}
    while not graph.is_done:
        ready = [robot for robot in range(robots) if graph.next_target(robot) >= 0]
        assert ready, "deadlock"
        robot = random.choice(ready)
        target = graph.next_target(robot)
        assert target not in at
        graph.begin(robot)
        at[robot] = target
        visits.setdefault(target, []).append(robot)
    assert at == plan[-1].tolist()
    for vertex, robots_there in visits.items():
        assert in_turn(robots_there) == planned_visits(plan, vertex)


def planned_visits(plan, vertex):
    return in_turn(int(robot) for row in plan for robot in np.flatnonzero(row == vertex))


def in_turn(robots):
    return [robot for robot, _ in itertools.groupby(robots)]
