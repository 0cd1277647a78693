"""One robot of a swarm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from swarm_common.model.records import Pose, Scan
from swarm_workbench.backend import Backend
from swarm_workbench.goal import Goal
from swarm_workbench.place import Place, Places

NAVIGATE = "navigate_to_pose"


class Robot:
    """One robot: what it senses and believes, and goals for it.

    Attributes:
        name: Its name, and its namespace in ROS.
    """

    def __init__(
        self,
        name: str,
        index: int,
        backend: Callable[[], Backend],
        places: Callable[[], Places],
        run: Callable[[], int],
    ) -> None:
        self.name = name
        self._index = index
        self._backend = backend
        self._places = places
        self._run = run

    @property
    def pose(self) -> Pose:
        """Where the robot believes to be, in map."""
        return Pose(*self._backend().estimated_poses()[self._index].tolist())

    @property
    def true_pose(self) -> Pose:
        """Where it is, in map; no robot knows that."""
        return Pose(*self._backend().true_poses()[self._index].tolist())

    @property
    def scan(self) -> Scan | None:
        """Its latest scan; None before the first, or without a LiDAR."""
        return self._backend().scan(self._index)

    @property
    def status(self) -> Any:
        """Its status, with the members of swarm_interfaces/RobotStatus."""
        return self._backend().status(self._index)

    @property
    def state(self) -> str:
        """State, like driving, waiting or idle."""
        return str(self.status.state)

    def go_to(self, place: Place) -> Goal:
        """Send it somewhere; the goal before is canceled.

        Args:
            place: Name of a station, (x, y) or (x, y, yaw) in map, or a `Pixel` of the map.

        Raises:
            SwarmError: If there is no such place, it is in a wall, or the swarm is gone.
        """
        backend = self._backend()
        radius = backend.specs[self._index].inscribed_radius
        pose = self._places().pose(place, radius)
        goal = Goal(self.name, NAVIGATE, pose, backend.tick, self._run, self._cancel)
        backend.drive(self._index, goal, pose)
        return goal

    def send(self, action: str, fields: Mapping[str, Any] | Any) -> Goal:
        """Send a goal of any of Nav2's actions; the bench knows a few of them.

        Args:
            action: Its name, like `spin`.
            fields: Fields, like `{"target_yaw": 1.57}`, or the goal message.

        Raises:
            SwarmError: If there is no such action or field, or the swarm is gone.
        """
        backend = self._backend()
        goal = Goal(self.name, action, None, backend.tick, self._run, self._cancel)
        backend.send(self._index, goal, fields)
        return goal

    def fail(self) -> None:
        """Let its navigator die, on the bench: it stands, and says nothing any more."""
        self._backend().fail(self._index)

    def _cancel(self, goal: Goal) -> None:
        self._backend().cancel(self._index, goal)

    def __repr__(self) -> str:
        return f"<Robot {self.name}>"
