"""Random instances that pymapf and we solve: `python -m tests.oracles.pymapf_instances 500`."""

import sys
import warnings

import numpy as np
import pytest

from swarm_central.lacam import Lacam, lower_bound
from swarm_central.plan_check import first_fault
from swarm_central.roadmap import grid_roadmap

MOST = 100_000  # expansions


def instance(rng, size, robots, walls):
    """Return a roadmap of the largest part of a random grid, starts and goals, and its cells."""
    while True:
        passable = rng.random((size, size)) >= walls
        roadmap = grid_roadmap(passable)
        if len(roadmap.points) < robots + 1:
            continue
        start = rng.permutation(len(roadmap.points))[:robots].astype(np.int32)
        goals = rng.permutation(len(roadmap.points))[:robots].astype(np.int32)
        if (lower_bound(roadmap, start, goals) < 1e6).all():
            return passable, roadmap, start, goals


def pymapf_solves(name, limits, passable, roadmap, start, goals):
    """Whether a solver of pymapf finds a plan."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pymapf = pytest.importorskip("pymapf")
    grid = pymapf.GridMap((~passable).astype(int).tolist())

    def cell(vertex):
        column, row = roadmap.cells[vertex].tolist()
        return row, column

    agents = [
        pymapf.Agent(str(i), cell(s), cell(g))
        for i, (s, g) in enumerate(zip(start, goals, strict=True))
    ]
    return pymapf.get_solver(name, **limits).solve(pymapf.MAPFProblem(grid, agents)) is not None


def compare(count, seed, most=MOST, names=("lacam",)):
    """Return how many of some instances we solve, validly, and how many each solver of pymapf.

    Args:
        most: Expansions of LaCAM*, ours and theirs.
    """
    limits = {"lacam": {"max_expansions": most}, "pibt": {"max_timestep": 100}}
    rng = np.random.default_rng(seed)
    solved = dict.fromkeys(("ours", *names), 0)
    missed = 0  # that a solver of pymapf solves, but not we
    for _ in range(count):
        passable, roadmap, start, goals = instance(rng, 6, int(rng.integers(2, 9)), 0.2)
        plan = Lacam(roadmap, start, goals).solve(most)
        if plan is not None:
            assert first_fault(plan.steps, roadmap.costs.neighbors, may_rotate=True) is None
            assert (plan.steps[0] == start).all()
            assert (plan.steps[-1] == goals).all()
            solved["ours"] += 1
        found = [
            pymapf_solves(name, limits[name], passable, roadmap, start, goals) for name in names
        ]
        for name, is_solved in zip(names, found, strict=True):
            solved[name] += is_solved
        missed += plan is None and any(found)
    return solved, missed


if __name__ == "__main__":
    print(compare(int(sys.argv[1]), 5, 20_000, ("lacam", "pibt")))  # noqa: T201
