"""Near pairs and contacts of bodies in the rigid-body engine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, RobotSpec
from swarm_describe.worlds.scene import GROUND_GAP
from swarm_sim.physics.bullet.bullet_kernels import near_pairs
from swarm_sim.physics.engine import NEAR, NEAR_MISS, NearPair, Touch
from swarm_sim.physics.planar import MAX_CORNERS, bounds_of, pack_like, pad_polygon
from swarm_sim.physics.planar_kernels import Walls

EXACT_BELOW = 0.1  # [m] clearances below this come from the engine, larger ones from footprints
REACH_SLACK = 0.02  # [m] added to how far a robot may move in a control period
TOUCH_NORMAL_FORCE, TOUCH_DISTANCE, TOUCH_POSITION = 9, 8, 5  # fields of a contact point
Suspect = tuple[int, int, tuple[int, str] | None]  # robot, other robot or -1, obstacle


class Contacts:
    """Looks for contacts only between pairs that could meet within a control period.

    Attributes:
        hulls: Footprints (n, k, 2) in base_footprint.
        radii: Circumscribed radii (n,) [m].
        clearances: (n, 2) to the nearest robot, obstacle; inf beyond NEAR.
        approaches: Pairs closer than NEAR_MISS.
    """

    def __init__(self, client: int, specs: Sequence[RobotSpec], robots: Sequence[int]) -> None:
        """Prepare the arrays of the robots; `surround` has to follow."""
        self._client = client
        self._robots = list(robots)
        self.hulls = np.stack([pad_polygon(np.array(s.footprint), MAX_CORNERS) for s in specs])
        self.radii = np.array([s.circumscribed_radius for s in specs])
        self._reaches = np.array([_speed(s) for s in specs]) * CONTROL_PERIOD + REACH_SLACK
        self.approaches: list[NearPair] = []

    def surround(
        self,
        obstacles: Sequence[tuple[int, str]],
        outlines: FloatArray,
        object_reaches: FloatArray,
        walker_speeds: FloatArray,
        tiles: tuple[FloatArray, list[tuple[int, str]]],
    ) -> None:
        """Set the bodies that are not robots; `measure` has to follow.

        Args:
            obstacles: pybullet's id and name of each outline's body, then of each walker's.
            outlines: Packed polygons (m, c, 2) of fixed bodies, then of objects.
            object_reaches: [m] that each object may move in a control period.
            walker_speeds: [m/s] of each walker.
            tiles: Bounds (k, 4) of the triangles of meshes; body and name of each.
        """
        self._tiles, self._tile_owners = tiles
        self._obstacles = list(obstacles)
        self._walls, self._bounds = outlines, bounds_of(outlines)
        still = np.zeros(len(outlines) - len(object_reaches))
        self._first_object = len(still)
        self._obstacle_reaches = np.concatenate(
            [still, object_reaches, walker_speeds * CONTROL_PERIOD]
        )
        self._make_room(len(self._robots))

    def _make_room(self, count: int) -> None:
        self._robot_gaps = np.empty((count * (count - 1) // 2, 3))
        self._wall_gaps = np.empty((count * len(self._obstacles), 3))
        self.clearances: FloatArray = np.full((count, 2), np.inf)

    def add(self, spec: RobotSpec, body: int) -> None:
        """Add a robot; `measure` has to follow."""
        self._robots.append(body)
        hull = pad_polygon(np.array(spec.footprint), MAX_CORNERS)
        self.hulls = np.concatenate([self.hulls, hull[None]])
        self.radii = np.append(self.radii, spec.circumscribed_radius)
        self._reaches = np.append(self._reaches, _speed(spec) * CONTROL_PERIOD + REACH_SLACK)
        self._make_room(len(self._robots))

    def move_objects(self, outlines: FloatArray) -> None:
        """Update the objects' outlines (k, c, 2) [m]."""
        self._walls[self._first_object :] = pack_like(outlines, self._walls.shape[1])
        self._bounds[self._first_object :] = bounds_of(outlines)

    def measure(self, poses: FloatArray, walkers: FloatArray) -> None:
        """Find near pairs, and the clearance of each robot."""
        counts = near_pairs(
            poses,
            self.radii,
            self.hulls,
            Walls(self._walls, self._bounds, walkers),
            NEAR,
            self._robot_gaps,
            self._wall_gaps,
        )
        self._near_robots = self._robot_gaps[: counts[0]]
        self._near_walls = self._wall_gaps[: counts[1]]
        self.clearances[:] = np.inf
        self.approaches = []
        for i, j, gap in self._near_robots.tolist():
            a, b = int(i), int(j)
            exact = self._exact(self._robots[a], self._robots[b], gap)
            self.clearances[[a, b], 0] = np.minimum(self.clearances[[a, b], 0], exact)
            if exact < NEAR_MISS:
                self.approaches.append(NearPair(a, b, "", exact))
        self._poses = poses
        for i, k, gap in self._near_walls.tolist():
            a, (body, name) = int(i), self._obstacles[int(k)]
            exact = self._exact(self._robots[a], body, gap)
            self.clearances[a, 1] = min(self.clearances[a, 1], exact)
            if exact < NEAR_MISS:
                self.approaches.append(NearPair(a, -1, name, exact))

    def suspects(self) -> list[Suspect]:
        """Return the pairs that could touch within a control period."""
        reach = self._reaches
        pairs: list[Suspect] = [
            (int(i), int(j), None)
            for i, j, gap in self._near_robots
            if gap < reach[int(i)] + reach[int(j)]
        ]
        walls = {
            (int(i), self._obstacles[int(k)])
            for i, k, gap in self._near_walls
            if gap < reach[int(i)] + self._obstacle_reaches[int(k)]
        }
        if len(self._tiles):
            walls |= self._near_tiles()
        return pairs + [(robot, -1, obstacle) for robot, obstacle in sorted(walls)]

    def _near_tiles(self) -> set[tuple[int, tuple[int, str]]]:
        """Return the robots that could touch a triangle of a mesh, judged without its outlines."""
        x, y = self._poses[:, None, 0], self._poses[:, None, 1]
        x_min, y_min, x_max, y_max = self._tiles.T
        aside = np.maximum(np.maximum(x_min - x, x - x_max), 0.0)
        ahead = np.maximum(np.maximum(y_min - y, y - y_max), 0.0)
        reach = (self.radii + self._reaches)[:, None]
        near = np.argwhere(np.hypot(aside, ahead) < reach).tolist()
        return {(robot, self._tile_owners[tile]) for robot, tile in near}

    def touch(self, suspect: Suspect, step: int) -> Touch | None:
        """Return the contact of a pair after a physics step, None if there is none.

        Returns:
            The first contact point of the pair, None if there is none. What touches no higher than
            `GROUND_GAP` is a floor, and no contact.
        """
        robot, other, obstacle = suspect
        body = self._robots[other] if obstacle is None else obstacle[0]
        points = pybullet.getContactPoints(
            self._robots[robot], body, -1, -1, physicsClientId=self._client
        )
        for point in points or ():
            if obstacle is not None and point[TOUCH_POSITION][2] <= GROUND_GAP:
                continue  # a floor
            if point[TOUCH_NORMAL_FORCE] > 0.0 or point[TOUCH_DISTANCE] <= 0.0:
                x, y, _ = point[TOUCH_POSITION]
                return Touch(robot, other, obstacle[1] if obstacle else "", x, y, step)
        return None

    def _exact(self, a: int, b: int, estimate: float) -> float:
        """Return the engine's distance between two bodies if the estimate is small."""
        if estimate >= EXACT_BELOW:
            return estimate
        points = pybullet.getClosestPoints(
            a, b, estimate + 0.1, -1, -1, physicsClientId=self._client
        )
        return max(0.0, min((point[TOUCH_DISTANCE] for point in points), default=estimate))


def _speed(spec: RobotSpec) -> float:
    """Return the most [m/s] at which a point of a robot moves."""
    return spec.max_vel_x + spec.max_vel_y + spec.max_vel_theta * spec.circumscribed_radius
