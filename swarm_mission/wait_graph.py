"""Which robot waits for which, as the robots report, and circles of waiting that last."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

LASTING = 5.0  # [s] of simulated time from which a circle counts: shorter ones are mere encounters
MOST_TOLD = 20  # circles that are listed one by one, the longest ones


@dataclass(slots=True)
class WaitGraph:
    """Edges from each robot to the robot that it waits for, at most one from each."""

    # at present, by the name of the robot that waits
    edges: dict[str, str] = field(default_factory=dict)
    # circles that are over: (robots, since [s], duration [s])
    lasting: list[tuple[tuple[str, ...], float, float]] = field(default_factory=list)
    _since: dict[tuple[str, ...], float] = field(default_factory=dict)

    def note(self, robot: str, other: str, sim_time: float) -> None:
        """Record for whom a robot says that it waits.

        Args:
            other: Name of the robot that it waits for; empty if it waits for nobody.
            sim_time: Simulated time [s].
        """
        if self.edges.get(robot, "") == other:
            return
        for circle in [circle for circle in self._since if robot in circle]:
            self._end(circle, sim_time)
        if not other:
            self.edges.pop(robot, None)
            return
        self.edges[robot] = other
        circle = self._circle_through(robot)
        if circle:
            self._since[circle] = sim_time

    def as_json(self, sim_time: float) -> dict[str, Any]:
        """Return what `report.json` says; circles that last still are ended.

        Args:
            sim_time: Simulated time [s] of the end.
        """
        for circle in list(self._since):
            self._end(circle, sim_time)
        longest = sorted(self.lasting, key=lambda item: -item[2])
        return {
            "lasting_circles": len(self.lasting),
            "longest_circle": round(longest[0][2], 1) if longest else 0.0,
            "circles": [
                {"robots": list(robots), "since": round(since, 1), "duration": round(time, 1)}
                for robots, since, time in longest[:MOST_TOLD]
            ],
            "at_the_end": dict(sorted(self.edges.items())),
        }

    def _end(self, circle: tuple[str, ...], sim_time: float) -> None:
        since = self._since.pop(circle)
        if sim_time - since >= LASTING:
            self.lasting.append((circle, since, sim_time - since))

    def _circle_through(self, robot: str) -> tuple[str, ...]:
        """Return the circle that contains a robot, starting with it; empty if there is none."""
        way = [robot]
        while (following := self.edges.get(way[-1], "")) not in way:
            if not following:
                return ()
            way.append(following)
        return tuple(way) if following == robot else ()
