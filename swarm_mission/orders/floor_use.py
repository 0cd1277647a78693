"""How the floor and the robots' time are used: sampled twice a second from places and states."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec

from swarm_common.model.records import CONTROL_PERIOD
from swarm_mission.orders.order_book import HOUR, RobotShares

SAMPLE_TICKS = 5  # of 0.1 s between two samples of a robot
CELL = 1.0  # [m] of the floor
STANDING = 0.02  # [m/s] below which a robot stands
LONGEST_GAP = 50  # ticks without a sample that still count to the state before


@dataclass(slots=True)
class _Sample:
    tick: int
    x: float
    y: float
    share: str
    cell: tuple[int, int]


@dataclass(slots=True)
class FloorUse:
    """Adds up samples of robots."""

    # times by robot
    robots: defaultdict[str, RobotShares] = field(default_factory=lambda: defaultdict(RobotShares))
    first: int | None = None  # tick of the first sample; None before it
    last: int = 0  # tick of the latest
    _latest: dict[str, _Sample] = field(default_factory=dict)
    _entries: defaultdict[tuple[int, int], int] = field(default_factory=lambda: defaultdict(int))
    _times: defaultdict[tuple[int, int], float] = field(default_factory=lambda: defaultdict(float))

    def note(self, tick: int, robot: str, x: float, y: float, share: str) -> None:
        """Record a sample.

        Args:
            x: [m] in map.
            y: [m] in map.
            share: Field of `RobotShares` that the robot's time counts to from now on; driving
                robots that stand still count as waiting.
        """
        cell = math.floor(x / CELL), math.floor(y / CELL)
        before = self._latest.get(robot)
        if before is not None and tick - before.tick < SAMPLE_TICKS:
            return
        if before is not None:
            ticks = min(tick - before.tick, LONGEST_GAP)
            self._count(
                robot, before, ticks * CONTROL_PERIOD, math.hypot(x - before.x, y - before.y)
            )
        if before is None or before.cell != cell:
            self._entries[cell] += 1
        self._latest[robot] = _Sample(tick, x, y, share, cell)
        self.first = tick if self.first is None else self.first
        self.last = max(self.last, tick)

    def _count(self, robot: str, before: _Sample, seconds: float, way: float) -> None:
        self._times[before.cell] += seconds
        shares = self.robots[robot]
        is_standing = before.share.startswith("driving") and way < STANDING * seconds
        name = "waiting" if is_standing else before.share
        setattr(shares, name, getattr(shares, name) + seconds)

    def as_json(self) -> dict[str, Any]:
        """Return the robots' times [s], and flow [1/h] and density [robots/m²] of the floor."""
        length = max((self.last - (self.first or 0)) * CONTROL_PERIOD, CONTROL_PERIOD)
        cells = sorted(self._entries)
        return {
            "robots": {
                name: {key: round(value, 1) for key, value in msgspec.structs.asdict(r).items()}
                for name, r in sorted(self.robots.items())
            },
            "floor": {
                "cell": CELL,
                "cells": [
                    {
                        "x": (cell[0] + 0.5) * CELL,
                        "y": (cell[1] + 0.5) * CELL,
                        "flow": round(self._entries[cell] * HOUR / length, 1),
                        "density": round(self._times[cell] / length / CELL**2, 4),
                    }
                    for cell in cells
                ],
            },
        }


def joined(figures: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the figures of all robots from those of shares of them, as of `FloorUse.as_json`."""
    robots: dict[str, Any] = {}
    cells: dict[tuple[float, float], dict[str, float]] = {}
    for each in figures:
        robots |= each["robots"]
        for cell in each["floor"]["cells"]:
            place = cell["x"], cell["y"]
            before = cells.get(place, {"flow": 0.0, "density": 0.0})
            sums = {name: round(value + cell[name], 4) for name, value in before.items()}
            cells[place] = {"x": place[0], "y": place[1], **sums}
    floor = {"cell": CELL, "cells": [cells[place] for place in sorted(cells)]}
    return {"robots": dict(sorted(robots.items())), "floor": floor}
