"""A job for a peer, the loop around it, and what is counted from outside, the same for all."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

PERIOD = 0.1  # [s] of simulated time between two looks
WARM_TICKS = 10  # counted as start-up
REACHED = 0.25  # [m] from a goal
MEGABYTE = 1e6


class Peer(Protocol):
    """A simulator with its robots in the hall."""

    def positions(self) -> Sequence[Sequence[float]]:
        """Return (n, 2) where the robots are [m]."""

    def set_goal(self, index: int, x: float, y: float) -> None:
        """Send a robot to a place [m]."""

    def step(self) -> None:
        """Advance by `PERIOD`."""


class Referee:
    """Hands out goals and counts, from positions alone, goals reached and robots that overlap."""

    def __init__(self, job: dict[str, Any]) -> None:
        self._goals = [list(goals) for goals in job["goals"]]
        self._diameter = 2.0 * job["radius"]
        self._touching: set[tuple[int, int]] = set()
        self.reached = 0
        self.overlaps = 0  # episodes of a pair

    @property
    def is_over(self) -> bool:
        """Whether no goals are left."""
        return not any(self._goals)

    def check(self, positions: np.ndarray) -> list[tuple[int, list[float]]]:
        """Count goals reached and overlaps; return which robots have a new goal."""
        new = []
        for index, (goals, (x, y)) in enumerate(zip(self._goals, positions.tolist(), strict=True)):
            if goals and math.hypot(goals[0][0] - x, goals[0][1] - y) <= REACHED:
                goals.pop(0)
                self.reached += 1
                if goals:
                    new.append((index, goals[0]))
        gaps = np.linalg.norm(positions[:, None] - positions[None], axis=2)
        touching = {(int(a), int(b)) for a, b in np.argwhere(np.triu(gaps < self._diameter, 1))}
        self.overlaps += len(touching - self._touching)
        self._touching = touching
        return new


def run(make: Callable[[dict[str, Any]], Peer]) -> None:
    """Run the job in the first argument with a peer, and print what it cost as JSON."""
    begun = _start_of_process()
    job = json.loads(sys.argv[1])
    sys.stdout.flush()
    output, sys.stdout = sys.stdout, sys.stderr  # peers print
    peer, referee = make(job), Referee(job)
    for index, goals in enumerate(job["goals"]):
        peer.set_goal(index, *goals[0])
    for _ in range(WARM_TICKS):
        peer.step()
    start_up = time.time() - begun
    wall = cpu = 0.0
    ticks, last = 0, round(job["seconds"] / PERIOD) - WARM_TICKS
    while ticks < last and wall < job["wall_limit"] and not referee.is_over:
        started, cpu_started = time.perf_counter(), time.process_time()
        peer.step()
        wall += time.perf_counter() - started
        cpu += time.process_time() - cpu_started
        ticks += 1
        for index, (x, y) in referee.check(np.asarray(peer.positions(), np.float64)):
            peer.set_goal(index, x, y)
    result = {
        "start_up": start_up,
        "sim_time": ticks * PERIOD,
        "wall_time": wall,
        "cpu": {"world": cpu},
        "rss_mb": _resident_mb(),
        "collisions": referee.overlaps,
        "goals_reached": referee.reached,
    }
    output.write("\n" + json.dumps(result) + "\n")
    output.flush()


def _start_of_process() -> float:
    """Return when this process began, in the time of `time.time`."""
    with open("/proc/self/stat", encoding="ascii") as file:
        ticks = float(file.read().rpartition(")")[2].split()[19])
    with open("/proc/uptime", encoding="ascii") as file:
        up = float(file.read().split()[0])
    return time.time() - up + ticks / os.sysconf("SC_CLK_TCK")


def _resident_mb() -> float:
    """Return the resident memory of this process [MB]."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / MEGABYTE
