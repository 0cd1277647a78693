"""Walkers and vehicles on scripted paths: their places, and contacts with robots."""

from __future__ import annotations

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Box, Part, transform_from_xyz_rpy
from swarm_describe.worlds.actors import VehicleSpec, WalkerSpec
from swarm_describe.worlds.scene import Body
from swarm_sim.physics.scripted_paths import ScriptedPaths
from swarm_sim.physics.vehicle_kernels import drive, heading_at
from swarm_sim.physics.walker_kernels import RobotStates, walk

GROUND_GAP = 0.02  # [m] under a vehicle


class Walkers(ScriptedPaths[WalkerSpec]):
    """All walkers of a world.

    Attributes:
        discs: (m, 3) x, y, radius [m] in map.
        speeds: (m,) [m/s] of each.
    """

    words = (71, 72)
    search_step = 0.1

    def _set_up(self) -> None:
        specs = self.specs
        self.names = [spec.name for spec in specs]
        self.speeds = np.array([spec.speed for spec in specs])
        self._traits = np.array(
            [[s.speed, s.radius, s.step_length, s.patience] for s in specs]
        ).reshape(-1, 4)
        self.discs: FloatArray = np.column_stack((self._places, self._traits[:, 1]))

    def _advance(self, robots: RobotStates, period: float, step: int) -> bool:
        places = self._places, self._traits
        touched = walk(self._state, *places, self._loops, robots, self._touches, period, step)
        self.discs[:, :2] = self._places
        return bool(touched)


class Vehicles(ScriptedPaths[VehicleSpec]):
    """All vehicles of a world.

    Attributes:
        poses: (m, 3) x, y, yaw in map.
    """

    words = (74, 75)
    search_step = 0.2

    def _set_up(self) -> None:
        specs = self.specs
        self._traits = np.array(
            [[s.speed, s.turn_speed, s.step_length, s.patience, s.length, s.width] for s in specs]
        ).reshape(-1, 6)
        yaws = [
            heading_at(self._paths[k, :count], self._arcs[k, :count], self._state[k, 0], 1.0)
            for k, count in enumerate(self._counts)
        ]
        self.poses: FloatArray = np.column_stack((self._places, np.array(yaws)))

    def _advance(self, robots: RobotStates, period: float, step: int) -> bool:
        places = self.poses, self._traits
        return bool(drive(self._state, *places, self._loops, robots, self._touches, period, step))

    def _place(self, index: int) -> tuple[float, float]:
        x, y, _ = self.poses[index].tolist()
        return x, y

    def bodies(self) -> list[Body]:
        """Return the vehicles as bodies where they are now."""
        return [
            Body(
                name=spec.name,
                world_from_body=transform_from_xyz_rpy(pose[0], pose[1], 0.0, 0.0, 0.0, pose[2]),
                parts=(
                    Part(
                        Box((spec.length, spec.width, spec.height - GROUND_GAP)),
                        transform_from_xyz_rpy(
                            0.0, 0.0, (spec.height + GROUND_GAP) / 2.0, 0.0, 0.0, 0.0
                        ),
                    ),
                ),
                is_static=False,
            )
            for spec, pose in zip(self.specs, self.poses.tolist(), strict=True)
        ]
