"""History of the robots of a run, from their statuses as they come."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from swarm_common.model.breaches import Collision
from swarm_common.model.run_words import stopped_by
from swarm_workbench.tables import table

Row = tuple[float, str, str, str]


class RunTables:
    """Tables of states, waits and events; each has the time [s] in `t` and the `robot`."""

    def __init__(self, names: Sequence[str]) -> None:
        """Begin before the first status."""
        self._time = 0.0  # [s] of the latest status
        self._states: list[Row] = []
        self._waits: list[tuple[float, str, str, float]] = []
        self._ends: list[Row] = []
        self._latest = dict.fromkeys(names, ("", ""))
        self._counts = dict.fromkeys(names, (0, 0))
        self._waiting: dict[str, tuple[float, str]] = {}  # since when [s], and for whom

    def note(self, robot: str, status: Any, time: float) -> None:
        """Record what a status says that is new.

        Args:
            status: With the members of swarm_interfaces/RobotStatus.
            time: [s] of simulated time.
        """
        self._time = max(self._time, time)
        state, detail = status.state, status.detail
        if self._latest[robot] != (state, detail):
            self._latest[robot] = state, detail
            self._states.append((time, robot, state, detail))
        other = stopped_by(state, detail)
        since, before = self._waiting.get(robot, (time, ""))
        if other != before:
            if before:
                self._waits.append((since, robot, before, time - since))
            self._waiting[robot] = time, other
        counts = status.goals_reached, status.goals_failed
        for kind, now, then in zip(("reached", "failed"), counts, self._counts[robot], strict=True):
            if now > then:
                self._ends.append((time, robot, kind, detail if kind == "failed" else ""))
        self._counts[robot] = counts

    def states(self) -> Any:
        """Return a row for each change: t, robot, state, detail."""
        return _table(("t", "robot", "state", "detail"), self._states)

    def waits(self) -> Any:
        """Return a row for each wait: t, robot, for which other robot, duration [s] so far."""
        lasting = [
            (since, robot, other, self._time - since)
            for robot, (since, other) in list(self._waiting.items())
            if other
        ]
        return _table(("t", "robot", "other", "duration"), sorted(self._waits + lasting))

    def events(self, collisions: Iterable[Collision]) -> Any:
        """Return a row for each goal that ended and each contact: t, robot, event, detail."""
        contacts = [
            (each.sim_time, robot, "contact", each.obstacle or other)
            for each in collisions
            for robot, other in zip(each.robots, (*each.robots[1:], each.robots[0]), strict=True)
        ]
        return _table(("t", "robot", "event", "detail"), sorted(self._ends + contacts))


def _table(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> Any:
    columns = zip(*rows, strict=True) if rows else [()] * len(names)
    return table(dict(zip(names, map(list, columns), strict=True)))
