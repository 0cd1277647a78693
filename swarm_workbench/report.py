"""Figures of a run, the same on the bench and of processes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from swarm_workbench.tables import table


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotFigures:
    """One robot's share."""

    robot: str
    state: str  # as in its status, like driving
    goals_reached: int
    goals_failed: int
    wait_time: float  # [s] of standing because of other robots
    hold_time: float  # [s] on the holding circuit
    battery: float  # charge by capacity; NaN without one


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """A run so far."""

    sim_time: float  # [s]
    robot_robot: int  # contact episodes between robots
    robot_world: int  # contact episodes with walls, obstacles and people
    near_misses: int  # episodes closer than 0.03 m without contact
    min_clearance: float  # [m] of any robot from anything; inf if nothing was near
    robots: Sequence[RobotFigures]  # one entry per robot, in order
    # content of report.json after the end of processes; empty on the bench
    full: Mapping[str, Any]

    @property
    def goals_reached(self) -> int:
        """Goals that robots reached."""
        return sum(robot.goals_reached for robot in self.robots)

    @property
    def goals_failed(self) -> int:
        """Goals that robots gave up."""
        return sum(robot.goals_failed for robot in self.robots)

    @property
    def collisions(self) -> int:
        """Contact episodes of robots with anything."""
        return self.robot_robot + self.robot_world

    def table(self) -> Any:
        """Return a row per robot."""
        names = [item.name for item in fields(RobotFigures)]
        return table({name: [getattr(robot, name) for robot in self.robots] for name in names})
