"""Backend that runs a swarm, as `Swarm` and `Robot` see it; `bench` and `graph` are two of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from swarm_common.model.breaches import Collision
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Pose, RobotSpec, Scan
from swarm_common.model.sites import Sites
from swarm_workbench.goal import Goal
from swarm_workbench.history import RunTables
from swarm_workbench.report import Report
from swarm_workbench.trajectories import Trajectories


class Backend(Protocol):
    """A swarm whose time passes in `advance` only; robots are told apart by their index."""

    names: Sequence[str]
    specs: Sequence[RobotSpec]
    grid: Grid
    sites: Sites
    folder: Path | None
    url: str  # of the viewer; empty without one
    domain: int | None  # ROS domain; None without ROS
    history: RunTables

    @property
    def tick(self) -> int:
        """Control ticks since the start."""

    def advance(self, ticks: int) -> None:
        """Let time pass.

        Raises:
            SwarmError: If the swarm has ended.
        """

    def true_poses(self) -> FloatArray:
        """Return x, y [m], yaw [rad] in map of each robot (n, 3)."""

    def estimated_poses(self) -> FloatArray:
        """Return likewise what the robots believe."""

    def scan(self, robot: int) -> Scan | None:
        """Return a robot's latest scan; None before the first, or without a LiDAR."""

    def status(self, robot: int) -> Any:
        """Return a robot's status, with the members of swarm_interfaces/RobotStatus."""

    def drive(self, robot: int, goal: Goal, pose: Pose) -> None:
        """Send a robot to a pose in map."""

    def send(self, robot: int, goal: Goal, fields: Mapping[str, Any] | Any) -> None:
        """Send a goal of `goal.action`: a message, or the fields of one."""

    def cancel(self, robot: int, goal: Goal) -> None:
        """Cancel a robot's goal."""

    def fail(self, robot: int) -> None:
        """Let a robot's navigator die for good."""

    def report(self) -> Report:
        """Return the figures so far."""

    def collisions(self) -> Sequence[Collision]:
        """Return the contact episodes that are known; processes tell them when they have ended."""

    def trajectories(self) -> Trajectories:
        """Return where every robot was at each tick so far."""

    def close(self) -> None:
        """End everything; once is enough, twice is harmless."""
