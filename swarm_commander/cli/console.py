"""Lines that `swarm-commander` prints about a robot on its way."""

from __future__ import annotations

from dataclasses import dataclass

PERIOD = 2.0  # [s] of simulated time between two lines that say the same


@dataclass(frozen=True, slots=True)
class Moment:
    """A robot's status in its operator's words."""

    sim_time: float  # [s]
    state: str  # as in RobotStatus
    detail: str  # why
    station: str  # held or wanted
    place: int  # in the order of request; 0 for none
    distance: float  # [m] still to go
    time_left: float  # [s] estimated until arrival


class StatusConsole:
    """Decides which statuses of one robot are worth a line."""

    def __init__(self, robot: str, period: float = PERIOD) -> None:
        self._robot = robot
        self._period = period
        self._said = ""
        self._due = 0.0

    def line(self, goal: str, moment: Moment) -> str | None:
        """Return what to print now, if anything.

        Args:
            goal: Like ``3/8 loader_2``.
        """
        what = f"{goal}{moment.state}{moment.station}{moment.place}"
        if what == self._said and moment.sim_time < self._due:
            return None
        self._said = what
        self._due = moment.sim_time + self._period
        return f"{self._robot}  {goal:<16} {describe(moment)}"


def describe(moment: Moment) -> str:
    """Return a robot's status in words."""
    way = f"{moment.distance:.2f} m, {moment.time_left:.0f} s to go"
    if moment.state == "holding":
        place = f", place {moment.place}" if moment.place else ""
        words = f"holding for {moment.station or 'its goal'}{place}"
    else:
        words = moment.state
    detail = f" ({moment.detail})" if moment.detail else ""
    return f"{words}{detail}: {way}"
