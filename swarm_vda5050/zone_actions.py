"""Actions in ACTION zones, begun as a robot comes in, crosses and leaves; of version 3.0."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import msgspec
import shapely

from swarm_vda5050.actions import ActionScope, RunningAction
from swarm_vda5050.messages import ActionStatus, FleetZone, OrderAction

MOST_KEPT = 50  # actions that ended


class ActionZone(NamedTuple):
    """An ACTION zone of the enabled set."""

    zone: FleetZone
    area: shapely.Geometry


@dataclass(slots=True)
class ZoneActions:
    """Actions in zones, the latest last; each has an id that the robot gives it.

    Attributes:
        runs: Actions that run or wait, and those that ended last.
        zone_set: Id of the enabled set at the last look.
    """

    runs: list[RunningAction] = field(default_factory=list)
    zone_set: str = ""
    _crossing: dict[str, list[RunningAction]] = field(default_factory=dict)  # by zoneId
    _open: list[RunningAction] = field(default_factory=list)  # not ended, or not taken yet
    _count: int = 0

    def look(
        self,
        zones: Mapping[str, ActionZone],
        zone_set: str,
        way: shapely.Geometry,
        body: shapely.Geometry,
    ) -> None:
        """Begin and end actions as the body of the robot moves.

        Args:
            zones: Those of the enabled set, by zoneId.
            zone_set: Id of that; a robot that is in its zones as it is enabled does not come in.
            way: Places of the body since the last look, in map.
        """
        is_new = zone_set != self.zone_set
        if is_new:
            self.zone_set = zone_set
            for name in list(self._crossing):
                self._leave(name)
        for name, (zone, area) in zones.items():
            is_inside = bool(area.intersects(body))
            has_come = is_inside or (not is_new and bool(area.intersects(way)))
            if name not in self._crossing and has_come:
                self._begin(() if is_new else zone.entry_actions)
                self._crossing[name] = self._begin(zone.during_actions)
            if name in self._crossing and not is_inside:
                self._leave(name)
                self._begin(zone.exit_actions)

    def _begin(self, actions: Iterable[OrderAction]) -> list[RunningAction]:
        runs = []
        for action in actions:
            self._count += 1
            own = msgspec.structs.replace(action, action_id=f"zoneAction-{self._count}")
            run = RunningAction(own, ActionScope.ZONE)
            run.is_triggered = True
            runs.append(run)
        self.runs += runs
        self._open += runs
        ended = [run for run in self.runs if run.status.is_final]
        for run in ended[: max(0, len(self.runs) - MOST_KEPT)]:  # the oldest
            self.runs.remove(run)
        return runs

    def _leave(self, zone: str) -> None:
        for run in self._crossing.pop(zone):
            run.fail("the robot left the zone")

    def take_failed(self) -> list[RunningAction]:
        """Return the actions that have failed since the last call."""
        failed = [run for run in self._open if run.status is ActionStatus.FAILED]
        self._open = [run for run in self._open if not run.status.is_final]
        return failed

    def end(self, reason: str) -> None:
        """Let all actions fail."""
        for run in self.runs:
            run.fail(reason)

    def clear(self) -> None:
        """Forget the actions that ended."""
        self.runs = [run for run in self.runs if not run.status.is_final]
