"""Graph search against Dijkstra over an explicit table of edges."""

import heapq

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_nav.planning import search_kernels as kernels
from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.planning.search import SearchSpace
from tests.oracles import search as oracle

STEP = 0.1


class Maze:
    """A random lattice with walls, lanes and other robots."""

    def __init__(self, seed, height=12, width=14):
        rng = np.random.default_rng(seed)
        shape = (height, width)
        self.base = (1.0 + rng.random(shape)).astype(np.float32)
        self.base[rng.random(shape) < 0.25] = kernels.WALL
        self.lane = (3.0 * rng.random(shape)).astype(np.float32)
        angle = rng.uniform(0.0, 2.0 * np.pi, shape)
        self.heading = np.stack((np.cos(angle), np.sin(angle)), axis=-1).astype(np.float32)
        self.extra = (30.0 * (rng.random(shape) < 0.1)).astype(np.float32)
        self.extra[rng.random(shape) < 0.05] = kernels.WALL
        free = np.flatnonzero((self.base < kernels.WALL) & (self.extra < kernels.WALL))
        self.start, self.goal = (int(node) for node in rng.choice(free, 2, replace=False))
        self.width = width
        self.space = SearchSpace(self.base, self.lane, self.heading, STEP)

    def edges(self, with_others=True):
        extra = self.extra if with_others else np.zeros_like(self.extra)
        return oracle.edges(self.base, self.lane, self.heading, extra, STEP)

    def cost_to_go(self):
        return self.space.cost_to_go(self.goal)

    def astar(self):
        nodes, expansions = self.space.cheapest(
            self.start, self.goal, self.extra, self.cost_to_go()
        )
        return nodes.tolist(), expansions


@pytest.mark.parametrize("seed", range(25))
def test_astar_finds_the_cheapest_path(seed):
    maze = Maze(seed)
    best = oracle.distances(maze.edges(), maze.start)
    path, _ = maze.astar()
    if maze.goal not in best:
        assert path == []
        return
    assert (path[0], path[-1]) == (maze.start, maze.goal)
    cost = oracle.path_cost(maze.edges(), path)
    assert cost == pytest.approx(best[maze.goal], rel=1e-5)


@pytest.mark.parametrize("seed", range(10))
def test_the_cost_to_go_is_exact_and_the_heuristic_consistent(seed):
    maze = Maze(seed)
    table = maze.edges(with_others=False)
    cost = maze.cost_to_go().ravel()
    for node in range(0, maze.base.size, 7):
        if maze.base.ravel()[node] >= kernels.WALL:
            continue
        expected = oracle.distances(table, node).get(maze.goal, np.inf)
        assert cost[node] == pytest.approx(expected, rel=1e-5)
    maze = Maze(seed)
    cost = maze.cost_to_go().ravel().astype(np.float64)
    is_open = maze.base.ravel() < kernels.WALL
    for node, moves in maze.edges().items():
        for other, price in moves:
            if is_open[node] and np.isfinite(cost[other]):
                assert cost[node] <= price + cost[other] + 1e-4


def test_without_other_robots_only_the_path_is_expanded():
    maze = Maze(4, 40, 40)
    maze.extra[:] = 0.0
    path, expansions = maze.astar()
    assert path
    assert expansions <= 3 * len(path)


def test_moves_do_not_cut_corners_of_walls():
    base = np.ones((5, 5), np.float32)
    base[2, 2] = kernels.WALL
    for row, column in np.ndindex(5, 5):
        for dr, dc in kernels.MOVES:
            i, j = row + dr, column + dc
            inside = 0 <= i < 5 and 0 <= j < 5
            swept = [*oracle.between(row, column, dr, dc), (i, j)]
            expected = inside and all(base[cell] < kernels.WALL for cell in swept)
            assert kernels.passable(base, row, column, dr, dc) == expected
    moves = np.empty((5, 5), np.uint32)
    kernels.open_moves(base, moves)
    for row, column in np.ndindex(5, 5):
        bits = [kernels.passable(base, row, column, dr, dc) for dr, dc in kernels.MOVES]
        assert moves[row, column] == sum(1 << m for m in range(16) if bits[m])


@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_open_node_is_within_two_cells(seed):
    maze = Maze(seed)
    rng = np.random.default_rng(seed)
    height, width = maze.base.shape
    for x, y in rng.uniform((-0.3, -0.3), (width * STEP + 0.3, height * STEP + 0.3), (50, 2)):
        gaps = {}
        row, column = np.floor(y / STEP), np.floor(x / STEP)
        for i, j in np.argwhere(maze.base < kernels.WALL):
            if abs(i - row) <= 2 and abs(j - column) <= 2:
                closed = 1.0 if maze.extra[i, j] >= kernels.WALL else 0.0
                centre = ((j + 0.5) * STEP, (i + 0.5) * STEP)
                gaps[i * width + j] = closed + np.hypot(centre[0] - x, centre[1] - y)
        node = kernels.nearest_open(maze.base, maze.extra, Frame(0.0, 0.0, STEP), x, y)
        expected = min(gaps.values(), default=None)
        assert gaps.get(node) == (None if expected is None else pytest.approx(expected))


@pytest.mark.parametrize("seed", range(10))
def test_the_nearest_place_is_the_cheapest_to_reach(seed):
    maze = Maze(seed)
    places = (np.random.default_rng(seed).random(maze.base.shape) < 0.1).astype(np.uint8)
    maze.astar()  # leaves traces in the work arrays
    path = maze.space.nearest(maze.start, maze.extra, places, 8.0).tolist()
    flat = np.where(maze.base < kernels.WALL, np.float32(1.0), kernels.WALL)
    table = oracle.edges(flat, 0 * maze.lane, maze.heading, maze.extra, STEP)
    reached = oracle.distances(table, maze.start)
    best = min((reached[n] for n in np.flatnonzero(places) if n in reached), default=np.inf)
    if best > 8.0:
        assert path == []
        return
    assert places.ravel()[path[-1]] == 1
    assert oracle.path_cost(table, path) == pytest.approx(best, rel=1e-5)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.one_of(st.floats(0.0, 100.0), st.none()), max_size=60))
def test_the_heap_gives_back_the_smallest_key_first(actions):
    keys, nodes, size = np.empty(64), np.empty(64, np.int64), 0
    twin: list[float] = []
    for number, key in enumerate(actions):
        if key is not None:
            size = kernels.heap_push(keys, nodes, size, key, number)
            heapq.heappush(twin, key)
        elif twin:
            assert keys[0] == heapq.heappop(twin)
            size = kernels.heap_pop(keys, nodes, size)
        assert size == len(twin)


def test_a_trace_runs_from_the_root_to_the_goal():
    parent = np.array((-1, 0, 1, 2), np.int64)
    path = np.empty(4, np.int64)
    assert kernels.trace_back(parent, 3, path) == 4
    assert path.tolist() == [0, 1, 2, 3]
