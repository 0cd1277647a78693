"""Worlds of the grid maps and scenarios that the path-finding community compares itself on.

The formats are those of the Moving AI Lab: `.map` (type octile) and `.scen` (version 1);
https://movingai.com/benchmarks/formats.html. Row 0 is the northernmost one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Mask
from swarm_map.floor_plan import FloorPlan, rounded
from swarm_map.plan_image import WallRaster

Cell = tuple[int, int]  # row from the north, column
FREE, BLOCKED = ".GS", "@OTW"
MAX_CELLS = 4_000_000
MIN_CELL, MAX_CELL = 0.1, 10.0  # [m]
MOST_AGENTS = 100  # of a scenario


@dataclass(frozen=True, slots=True)
class Agent:
    """Where a robot starts, and where it is to go."""

    start: Cell
    goal: Cell


def load_grid_map(
    path: Path, cell: float = 1.0, scenario: Path | None = None, wall_height: float = 2.5
) -> FloorPlan:
    """Return the plan in a `.map` file, its middle at (0, 0), with a wall around it.

    Args:
        scenario: `.scen` file; robot k starts and has its place where the k-th usable line says.
    """
    if not MIN_CELL <= cell <= MAX_CELL:
        raise ConfigError(f"--cell is {cell:g}; expected {MIN_CELL:g} to {MAX_CELL:g} m")
    blocked = _blocked(path)
    height, width = blocked.shape
    left, low = -(width / 2.0 + 1.0) * cell, -(height / 2.0 + 1.0) * cell
    walls = np.pad(blocked[::-1], 1, constant_values=True)
    things = WallRaster(path, walls, cell, left, low).things(wall_height)
    sites: dict[str, Any] = {}
    if scenario is not None:
        agents = _agents(scenario, blocked)
        poses = [_poses(agent, blocked.shape, cell) for agent in agents]
        sites["spawn"] = [
            {"x_min": x, "y_min": y, "x_max": x, "y_max": y, "yaw": yaw} for (x, y, yaw), _ in poses
        ]
        sites["places"] = [list(goal) for _, goal in poses]
    return FloorPlan(path.stem, things, sites)


def _blocked(path: Path) -> Mask:
    """Return where the cells (height, width) of a map cannot be driven on."""
    lines = _lines(path, "ascii")
    head = {words[0]: words[1:] for words in (line.split() for line in lines[:4]) if words}
    if head.get("type") != ["octile"] or len(lines) < 4 or lines[3].strip() != "map":
        raise ConfigError(
            f"{path}: the first lines are {lines[:4]}; expected 'type octile', 'height N', "
            "'width N', 'map'"
        )
    height, width = (_count(head.get(key), f"{path}: {key}") for key in ("height", "width"))
    if height * width > MAX_CELLS:
        raise ConfigError(f"{path}: {width} x {height} cells; expected at most {MAX_CELLS:.0e}")
    rows = lines[4 : 4 + height]
    if len(rows) < height:
        raise ConfigError(f"{path}: {len(rows)} rows; the header says {height}")
    for number, row in enumerate(rows, 5):
        unknown = set(row) - set(FREE + BLOCKED)
        if len(row) != width or unknown:
            what = f"unknown {sorted(unknown)}" if unknown else f"{len(row)} cells, not {width}"
            raise ConfigError(f"{path}, line {number}: {what}; expected {width} of {FREE}{BLOCKED}")
    cells = np.array([list(row) for row in rows])
    blocked: Mask = ~np.isin(cells, list(FREE))
    if blocked.all():
        raise ConfigError(f"{path}: no cell is free")
    return blocked


def _agents(path: Path, blocked: Mask) -> list[Agent]:
    """Return the agents of a scenario: lines whose start and goal no earlier line uses."""
    lines = _lines(path, "utf-8")
    if not lines or lines[0].split() not in (["version", "1"], ["version", "1.0"]):
        raise ConfigError(f"{path}: expected 'version 1' in the first line")
    agents: list[Agent] = []
    starts: set[Cell] = set()
    goals: set[Cell] = set()
    for number, line in enumerate(lines[1:], 2):
        if not line.strip() or len(agents) == MOST_AGENTS:
            continue
        where = f"{path}, line {number}"
        words = line.split()
        if len(words) != 9:
            raise ConfigError(f"{where}: {len(words)} fields; expected 9")
        width, height, start_x, start_y, goal_x, goal_y = (
            _number(word, where) for word in words[2:8]
        )
        if (height, width) != blocked.shape:
            raise ConfigError(
                f"{where}: a map of {width} x {height} cells; this one has "
                f"{blocked.shape[1]} x {blocked.shape[0]}"
            )
        agent = Agent((start_y, start_x), (goal_y, goal_x))
        for cell in (agent.start, agent.goal):
            if not (cell[0] < height and cell[1] < width) or blocked[cell]:
                raise ConfigError(f"{where}: nobody can be at x {cell[1]}, y {cell[0]}")
        if agent.start not in starts and agent.goal not in goals:
            starts.add(agent.start)
            goals.add(agent.goal)
            agents.append(agent)
    if not agents:
        raise ConfigError(f"{path} names no start and goal")
    return agents


def _poses(
    agent: Agent, shape: tuple[int, ...], cell: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return start and goal in the map frame; both face the way from one to the other."""
    (x0, y0), (x1, y1) = (
        ((column + 0.5 - shape[1] / 2.0) * cell, (shape[0] / 2.0 - row - 0.5) * cell)
        for row, column in (agent.start, agent.goal)
    )
    yaw = rounded(math.atan2(y1 - y0, x1 - x0))
    return (rounded(x0), rounded(y0), yaw), (rounded(x1), rounded(y1), yaw)


def _lines(path: Path, encoding: str) -> list[str]:
    try:
        return path.read_text(encoding=encoding).splitlines()
    except (OSError, UnicodeDecodeError) as cause:
        raise ConfigError(f"cannot read {path}: {cause}") from cause


def _count(words: list[str] | None, what: str) -> int:
    if not words or len(words) != 1:
        raise ConfigError(f"{what} is missing")
    count = _number(words[0], what)
    if not count:
        raise ConfigError(f"{what} is 0")
    return count


def _number(word: str, what: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 10):
        raise ConfigError(f"{what}: '{word}'; expected a whole number, 0 or more")
    return int(word)
