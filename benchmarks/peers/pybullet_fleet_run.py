"""pybullet-fleet: differential drives, kinematic or as rigid bodies; nobody avoids anybody."""

from __future__ import annotations

from typing import Any

from pybullet_fleet import AgentSpawnParams, MultiRobotSimulationCore, Pose, SimulationParams
from pybullet_fleet.agent_manager import AgentManager
from pybullet_fleet.sim_object import ShapeParams

from benchmarks.peers.job import PERIOD, run

PHYSICS = "physics"
PHYSICS_STEPS = 10  # of a period, with rigid bodies
HEIGHT = 0.15  # [m]


class FleetPeer:
    """A simulation of pybullet-fleet; `behavior` of the job is kinematic or physics."""

    def __init__(self, job: dict[str, Any]) -> None:
        has_physics = job["behavior"] == PHYSICS
        self._steps = PHYSICS_STEPS if has_physics else 1
        self._core = MultiRobotSimulationCore(
            SimulationParams(
                target_rtf=0, gui=False, monitor=False, enable_monitor_gui=False,
                physics=has_physics, timestep=PERIOD / self._steps, log_level="error",
            )
        )  # fmt: skip
        manager = AgentManager(sim_core=self._core)
        disc = ShapeParams(shape_type="cylinder", radius=job["radius"], height=HEIGHT)
        self._agents = manager.spawn_objects_batch(
            [
                AgentSpawnParams(
                    visual_shape=disc,
                    collision_shape=disc,
                    initial_pose=Pose.from_euler(x, y, HEIGHT / 2, 0.0, 0.0, yaw),
                    mass=1.0 if has_physics else 0.0,
                    controller={
                        "type": "differential", "max_linear_vel": job["speed"],
                        "max_angular_vel": job["turn"],
                    },
                    motion_mode="differential",
                )
                for x, y, yaw in job["starts"]
            ]
        )  # fmt: skip
        self._core.initialize_simulation()

    def positions(self) -> list[list[float]]:
        """Return where the robots are."""
        return [list(agent.get_pose().position[:2]) for agent in self._agents]

    def set_goal(self, index: int, x: float, y: float) -> None:
        """Send a robot to a place."""
        self._agents[index].set_goal_pose(Pose.from_xyz(x, y, HEIGHT / 2))

    def step(self) -> None:
        """Advance by `PERIOD`."""
        for _ in range(self._steps):
            self._core.step_once()


if __name__ == "__main__":
    run(FleetPeer)
