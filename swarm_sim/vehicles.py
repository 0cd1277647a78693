"""Forklifts and the like on scripted paths: where they are, and whom they run into."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from swarm_common.errors import ConfigError
from swarm_common.records import Pose, RobotSpec
from swarm_sim.actors import VehicleSpec
from swarm_sim.engine import FloatArray, Touch
from swarm_sim.randomness import hash_words, uniform
from swarm_sim.scene import Body, Box, Part, transform_from_xyz_rpy
from swarm_sim.vehicle_kernels import drive, heading_at

PAUSES = 64  # drawn for each vehicle; then they begin again
START_GAP = 0.4  # [m] from any robot's circle at the start
SEARCH_STEP = 0.2  # [m] along the path when looking for such a place
GROUND_GAP = 0.02  # [m] under a vehicle
START_WORD, PAUSE_WORD = 74, 75  # what a random number is for


class Vehicles:
    """All vehicles of a world.

    Attributes:
        specs: One per vehicle.
        poses: (m, 3) x, y, yaw in map.
    """

    def __init__(
        self,
        specs: Sequence[VehicleSpec],
        robots: Sequence[RobotSpec],
        poses_map: Sequence[Pose],
        seed: int,
    ) -> None:
        """Place the vehicles on their paths, away from the robots.

        Args:
            specs: One per vehicle.
            robots: Models of the robots.
            poses_map: Where these start.
            seed: Of starts that are not given, and of pauses.

        Raises:
            ConfigError: If a vehicle has no place on its path that is free of robots.
        """
        self.specs = tuple(specs)
        count = len(specs)
        corners = max([len(spec.path) for spec in specs], default=1) + 1
        self._paths = np.zeros((count, corners, 2))
        self._arcs = np.zeros((count, corners))
        self._counts = np.array([len(spec.path) + 1 for spec in specs], np.int64)
        self._traits = np.array(
            [[s.speed, s.turn_speed, s.step_length, s.patience, s.length, s.width] for s in specs]
        ).reshape(-1, 6)
        self._pauses = np.zeros((count, PAUSES))
        self._state = np.zeros((count, 5))
        self._state[:, 1] = 1.0
        self.poses: FloatArray = np.zeros((count, 3))
        self._radii = np.array([robot.circumscribed_radius for robot in robots])
        circles = np.array([(p.x, p.y) for p in poses_map]).reshape(-1, 2)
        self._touches = np.full((len(robots), count), -1, np.int64)
        for index, spec in enumerate(specs):
            self._lay_out(index, spec, circles, seed)

    def __len__(self) -> int:
        """Return the number of vehicles."""
        return len(self.specs)

    def add_robot(self, spec: RobotSpec) -> None:
        """Look out for another robot, too."""
        self._radii = np.append(self._radii, spec.circumscribed_radius)
        self._touches = np.full((len(self._radii), len(self.specs)), -1, np.int64)

    def begin(self) -> None:
        """Begin a control period."""
        self._touches[:] = -1

    def step(
        self, poses: FloatArray, speeds: FloatArray, hulls: FloatArray, period: float, step: int
    ) -> bool:
        """Drive for one physics step; return whether a vehicle ran into a robot.

        Args:
            poses: True poses (n, 3) of the robots.
            speeds: Forward speeds (n,) [m/s].
            hulls: Footprints (n, k, 2) in base_footprint.
            period: [s] of the step.
            step: Its number within the control period.
        """
        if not len(self.specs) or not len(hulls):
            return False
        touched = drive(
            self._state,
            self.poses,
            self._traits,
            (self._paths, self._arcs, self._counts, self._pauses),
            (np.ascontiguousarray(poses), np.ascontiguousarray(speeds), hulls, self._radii),
            self._touches,
            period,
            step,
        )
        return bool(touched)

    def touches(self) -> list[Touch]:
        """Return whom the vehicles ran into in this control period."""
        return [
            Touch(
                int(i),
                -1,
                self.specs[v].name,
                float(self.poses[v, 0]),
                float(self.poses[v, 1]),
                int(self._touches[i, v]),
            )
            for i, v in np.argwhere(self._touches >= 0)
        ]

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

    def _lay_out(self, index: int, spec: VehicleSpec, places: FloatArray, seed: int) -> None:
        closed = np.array([*spec.path, spec.path[0]])
        self._paths[index, : len(closed)] = closed
        arcs = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
        self._arcs[index, : len(arcs)] = arcs
        words = hash_words(seed, PAUSE_WORD, index, np.arange(PAUSES))
        self._pauses[index] = spec.pause * (0.5 + uniform(words))
        draw = float(uniform(hash_words(seed, START_WORD, index)))
        start = draw * arcs[-1] if spec.start is None else spec.start
        for offset in np.arange(0.0, arcs[-1], SEARCH_STEP):
            arc = float((start + offset) % arcs[-1])
            x, y = (float(np.interp(arc, arcs, closed[:, axis])) for axis in range(2))
            gaps = np.hypot(places[:, 0] - x, places[:, 1] - y) - self._radii
            if gaps.min(initial=math.inf) >= spec.radius + START_GAP:
                self._state[index, 0] = arc
                self.poses[index] = x, y, heading_at(closed, arcs, arc, 1.0)
                return
        raise ConfigError(f"{spec.name}: robots stand all along its path; move its path or them")
