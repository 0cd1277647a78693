"""navground: differential drives in a hall with walls, LiDARs beside perfect neighbour states."""

from __future__ import annotations

import math
from typing import Any

from navground import core, sim

from benchmarks.peers.job import PERIOD, run

HORIZON = 5.0  # [m] within which neighbours are known


class NavgroundPeer:
    """A world of navground; `behavior` of the job is HL or ORCA."""

    def __init__(self, job: dict[str, Any]) -> None:
        self._world = sim.World()
        for outline in job["walls"]:
            for a, b in zip(outline, [*outline[1:], outline[0]], strict=True):
                self._world.add_wall(core.LineSegment(a, b))
        for x, y, radius in job["pillars"]:
            self._world.add_obstacle(core.Disc((x, y), radius))
        self._agents = []
        for x, y, yaw in job["starts"]:
            agent = self._agent(job)
            agent.position, agent.orientation = (x, y), yaw
            self._world.add_agent(agent)
            self._agents.append(agent)

    def _agent(self, job: dict[str, Any]) -> Any:
        kinematics = core.Kinematics.make_type("2WDiff")
        kinematics.max_speed = job["speed"]
        kinematics.max_angular_speed = job["turn"]
        kinematics.wheel_axis = job["wheel_separation"]
        behavior = core.Behavior.make_type(job["behavior"])
        behavior.horizon = HORIZON
        behavior.optimal_speed = job["speed"]
        behavior.safety_margin = 0.05
        known = sim.StateEstimation.make_type("Bounded")
        known.range = HORIZON
        lidar = sim.StateEstimation.make_type("Lidar")
        lidar.resolution, lidar.range = job["rays"], job["range"]
        lidar.start_angle, lidar.field_of_view = -math.pi, 2.0 * math.pi
        return sim.Agent(
            radius=job["radius"],
            behavior=behavior,
            kinematics=kinematics,
            state_estimations=[known, lidar],
            control_period=PERIOD,
        )

    def positions(self) -> list[Any]:
        """Return where the robots are."""
        return [agent.position for agent in self._agents]

    def set_goal(self, index: int, x: float, y: float) -> None:
        """Send a robot to a place."""
        self._agents[index].behavior.target = core.Target.Point((x, y), 0.1)

    def step(self) -> None:
        """Advance by `PERIOD`."""
        self._world.run(1, PERIOD)


if __name__ == "__main__":
    run(NavgroundPeer)
