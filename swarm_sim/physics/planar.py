"""Kinematic twin of the physics engine: fast, for thousands of traffic runs.

Robots are convex polygons that follow their speed commands within the acceleration limits.
A robot stops before it would touch something, and that counts as a contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarm_common.model.beacon import FOOTPRINT_POINTS
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, RobotSpec
from swarm_common.model.shapes import Transform
from swarm_describe.robots.description import RobotModel
from swarm_describe.worlds.scene import Body
from swarm_sim.physics.actors import Walkers
from swarm_sim.physics.drive import Wheels
from swarm_sim.physics.engine import NEAR, NEAR_MISS, NearPair, Touch
from swarm_sim.physics.objects import Objects
from swarm_sim.physics.planar_kernels import PlainWalls, clearances, move, move_on
from swarm_sim.scene.section import Section

MAX_CORNERS = FOOTPRINT_POINTS
CLOSE_PAIRS = 8  # per robot, that are listed at most


class PlanarEngine:
    """Kinematic robots among fixed polygons and walkers; see `engine.Engine` for the attributes."""

    def __init__(
        self,
        section: Section,
        specs: Sequence[RobotSpec],
        poses: Sequence[Pose],
        physics_period: float,
        walkers: Walkers,
        objects: Objects,
    ) -> None:
        """Place the robots.

        Args:
            objects: Vehicles, and things that could be pushed, which stay where they are here.
        """
        count = len(specs)
        self._wheels = [Wheels(spec) for spec in specs]
        self._steps = round(CONTROL_PERIOD / physics_period)
        self._period = CONTROL_PERIOD / self._steps
        self._section, self._objects = section, objects
        self._walkers = walkers
        self._hulls = np.stack([pad_polygon(np.array(s.footprint), MAX_CORNERS) for s in specs])
        self._limits = np.array(
            [[s.acc_lim_x, s.acc_lim_theta, s.circumscribed_radius, s.acc_lim_y] for s in specs]
        )
        self._state = np.zeros((count, 6))
        self._state[:, :3] = [(pose.x, pose.y, pose.yaw) for pose in poses]
        self._robot_touches = np.zeros((count, count), np.int64)
        self._walker_touches = np.zeros((count, len(walkers)), np.int64)
        self._look_around()
        self.poses: FloatArray = self._state[:, :3]
        self.twists: FloatArray = self._state[:, 3:]
        self.travels: FloatArray = np.zeros((count, 2))
        self.yaws_gyro: FloatArray = np.zeros(count)
        self.clearances: FloatArray = np.full((count, 2), np.inf)
        self.approaches: list[NearPair] = []
        self._close = np.empty((CLOSE_PAIRS * count, 4))
        self._measure()

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over what was copied; poses and twists are views of it again."""
        self.__dict__.update(state)
        self.poses, self.twists = self._state[:, :3], self._state[:, 3:]

    def advance(self, targets: FloatArray) -> list[Touch]:
        """Run one control period towards target speeds."""
        self._robot_touches[:] = -1
        self._wall_touches[:] = -1
        self._walker_touches[:] = -1
        self._walkers.begin()
        self._objects.vehicles.begin()
        paths = np.zeros((len(self._state), 3))
        notes = (self._robot_touches, self._wall_touches, self._walker_touches, paths)
        robots = (self._state, targets, self._limits, self._hulls, self._obstacles, notes)
        if len(self._walkers) == 0 and len(self._objects) == 0:
            touched = move_on(*robots, self._period, self._steps)
        else:
            touched = False
            for step in range(self._steps):
                touched |= move(*robots, self._period, step)
                sight = (self.poses, self._state[:, 3], self._hulls, self._period, step)
                touched |= self._walkers.step(*sight)
                touched |= self._objects.vehicles.step(*sight)
            self._move_objects()
        self.travels += paths[:, ::2]
        self.yaws_gyro += paths[:, 1]
        self._measure()
        return self._touches() if touched else []

    def add(self, spec: RobotSpec, model: RobotModel | None, pose: FloatArray) -> None:
        """Add a robot, which stands at a pose (3,)."""
        count = len(self._state) + 1
        self._wheels.append(Wheels(spec))
        hull = pad_polygon(np.array(spec.footprint), MAX_CORNERS)
        self._hulls = np.concatenate([self._hulls, hull[None]])
        limits = [spec.acc_lim_x, spec.acc_lim_theta, spec.circumscribed_radius, spec.acc_lim_y]
        self._limits = np.vstack([self._limits, limits])
        self._state = np.vstack([self._state, [*pose, 0.0, 0.0, 0.0]])
        self._robot_touches = np.zeros((count, count), np.int64)
        self._wall_touches = np.zeros((count, len(self._walls)), np.int64)
        self._walker_touches = np.zeros((count, len(self._walkers)), np.int64)
        self.poses, self.twists = self._state[:, :3], self._state[:, 3:]
        self.travels = np.vstack([self.travels, np.zeros(2)])
        self.yaws_gyro = np.append(self.yaws_gyro, 0.0)
        self.clearances = np.full((count, 2), np.inf)
        self._close = np.empty((CLOSE_PAIRS * count, 4))
        self._measure()

    def place(self, robot: int, pose: FloatArray) -> None:
        """Put a robot elsewhere, where it stands; wheels and gyro do not notice."""
        self._state[robot] = [*pose, 0.0, 0.0, 0.0]
        self._measure()

    def restart(self, robot: int) -> None:
        """Restart the readings of a robot's wheels and gyro at 0."""
        self.travels[robot], self.yaws_gyro[robot] = 0.0, 0.0

    def place_object(self, index: int, place: Transform) -> None:
        """Put something elsewhere."""
        self._objects.place(index, place)
        self._move_objects()
        self._measure()

    def add_object(self, body: Body) -> None:
        """Add a thing behind all that can be pushed."""
        self._objects.add(body)
        self._look_around()
        self._measure()

    def remove_object(self, index: int) -> None:
        """Remove a thing; those behind it move up."""
        self._objects.remove(index)
        self._look_around()
        self._measure()

    def joint_state(self, robot: int) -> tuple[list[str], list[float], list[float]]:
        """Return the state of the wheel joints, as rolling without slip would turn them."""
        wheels = self._wheels[robot]
        travel, slide = self.travels[robot].tolist()
        positions = wheels.rates(travel, float(self.yaws_gyro[robot]), slide)
        return list(wheels.names), positions.tolist(), wheels.rates(*self.twists[robot]).tolist()

    def close(self) -> None:
        """Release nothing: everything is in Python."""

    def _look_around(self) -> None:
        """Collect what there is beside robots and walkers."""
        self._names = (*self._section.names, *self._objects.names)
        self._walls = pack_polygons(self._section.outlines())
        if len(self._objects):
            self._walls = pack_polygons([*self._walls, *self._objects.outlines()])
        self._bounds = bounds_of(self._walls)
        self._wall_touches = np.zeros((len(self._state), len(self._walls)), np.int64)

    def _move_objects(self) -> None:
        """Update the vehicles' outlines; robots meet them there in the next period."""
        if not len(self._objects):
            return
        outlines = self._objects.outlines()
        self._walls[-len(outlines) :] = pack_like(outlines, self._walls.shape[1])
        self._bounds[-len(outlines) :] = bounds_of(outlines)

    def _measure(self) -> None:
        count = clearances(
            self._state,
            self._limits,
            self._hulls,
            self._obstacles,
            NEAR,
            NEAR_MISS,
            self.clearances,
            self._close,
        )
        self.approaches = [self._approach(*row) for row in self._close[:count].tolist()]

    def _approach(self, robot: float, kind: float, index: float, gap: float) -> NearPair:
        if kind == 0:
            return NearPair(int(robot), int(index), "", gap)
        names = self._names if kind == 1 else self._walkers.names
        return NearPair(int(robot), -1, names[int(index)], gap)

    @property
    def _obstacles(self) -> PlainWalls:
        return self._walls, self._bounds, self._walkers.discs

    def _touches(self) -> list[Touch]:
        touches = [
            Touch(int(i), int(j), "", *self._middle(i, j), int(self._robot_touches[i, j]))
            for i, j in np.argwhere(self._robot_touches >= 0)
        ]
        touches += [
            Touch(int(i), -1, self._names[k], *self._middle(i, i), int(self._wall_touches[i, k]))
            for i, k in np.argwhere(self._wall_touches >= 0)
        ]
        touches += [
            Touch(
                int(i),
                -1,
                self._walkers.names[w],
                *self._middle(i, i),
                int(self._walker_touches[i, w]),
            )
            for i, w in np.argwhere(self._walker_touches >= 0)
        ]
        touches += self._walkers.touches()
        touches += self._objects.vehicles.touches()
        return sorted(touches, key=lambda touch: (touch.step, touch.robot, touch.other))

    def _middle(self, i: int, j: int) -> tuple[float, float]:
        x, y = (self._state[i, :2] + self._state[j, :2]) / 2.0
        return float(x), float(y)


def pad_polygon(polygon: FloatArray, corners: int) -> FloatArray:
    """Return a polygon with its last corner repeated up to a number of corners."""
    return np.vstack([polygon, np.repeat(polygon[-1:], corners - len(polygon), axis=0)])


def pack_polygons(polygons: Sequence[FloatArray]) -> FloatArray:
    """Return polygons as one array (m, k, 2); those with fewer corners repeat their last one."""
    corners = max([len(polygon) for polygon in polygons], default=3)
    if not polygons:
        return np.zeros((0, corners, 2))
    return np.stack([pad_polygon(polygon, corners) for polygon in polygons])


def pack_like(polygons: FloatArray, corners: int) -> FloatArray:
    """Return packed polygons (m, k, 2) with more corners, the last ones repeated."""
    missing = corners - polygons.shape[1]
    return np.concatenate([polygons, np.repeat(polygons[:, -1:], missing, axis=1)], axis=1)


def bounds_of(polygons: FloatArray) -> FloatArray:
    """Return the bounding boxes (m, 4) of packed polygons: x_min, y_min, x_max, y_max."""
    if not len(polygons):
        return np.zeros((0, 4))
    return np.hstack([polygons.min(axis=1), polygons.max(axis=1)])
