"""Observation of a policy, in an environment and on a robot: the same numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import FloatArray, RobotSpec, Twist
from swarm_common.model.schema import Count, Schema, check_fields
from swarm_workbench import observation_kernels

REACHED = 0.25  # [m] from the goal
NEIGHBOUR = 6  # there (0 or 1), x, y [m], yaw [rad] in base_footprint, vx [m/s], wz [rad/s]
RADIO_RANGE = 8.0  # [m] up to which a neighbour's beacon counts
PIXELS, PIXEL = 32, 0.5  # of an image of the neighbours: number along an edge, and [m] of each
FLAT = "observation"  # the input of a policy that takes all in one row
Part = Literal["scan", "goal", "way", "twist", "neighbours", "precedence"]
PARTS: tuple[Part, ...] = get_args(Part)
Rows = NDArray[np.float32]
Observation = dict[str, Rows]


class PolicyConfig(Schema):
    """What a policy sees, and how long its action holds.

    Parts of an observation, for normalised ones in brackets:

    | part | shape | what |
    |---|---|---|
    | `scan` | (rays,) or (stack, rays), the newest last | [m] up to the LiDAR's range [0 to 1] |
    | `goal` | (2,) | x, y [m] in base_footprint [(3,): d / (1 + d), cosine and sine of the bearing] |
    | `way` | (2,) | where the shortest way leads in 0.7 m, x, y in base_footprint [a unit vector] |
    | `twist` | (3,) | vx, wz, vy [shares of the most] |
    | `neighbours` | (k, 6), the nearest first | 1, x, y, yaw in base_footprint, vx, wz [shares of 8 m, pi and the most], or zeros |
    | the same as an image | (3, 32, 32), ahead is up | 1, and its vx, vy in base_footprint, on pixels of 0.5 m |
    | `precedence` | (k,), the nearest first | 1 where the neighbour has a higher number, -1 where it has a lower one, or 0 |

    Attributes:
        observation: Parts by name, or all in one row.
        normalise: Whether observations and actions are from -1 to 1.
        parts: Names of the parts that it sees, each once.
        rays: Sectors of the scan, each with its least range; None for all rays.
        stack: Number of scans, those of the last steps.
        neighbours: k, the most that are seen in a set.
        neighbours_as: Which of the two kinds above.
        ticks: Ticks of 0.1 s that an action holds.
    """  # noqa: E501

    observation: Literal["dict", "flat"] = "dict"
    normalise: bool = False
    parts: tuple[Part, ...] = ("scan", "goal", "twist", "neighbours")
    rays: Count | None = None
    stack: Count = 1
    neighbours: Count = 4
    neighbours_as: Literal["set", "image"] = "set"
    ticks: Count = 1

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.parts or len(set(self.parts)) < len(self.parts):
            raise ConfigError(f"parts is {self.parts}; expected one or more, each once")


class Bounds(NamedTuple):
    """Shape of a part of an observation, and between what its numbers are."""

    shape: tuple[int, ...]
    low: float
    high: float


class Observer:
    """What some robots of one model see.

    Attributes:
        bounds: Shape and limits of each part.
    """

    def __init__(self, config: PolicyConfig, spec: RobotSpec, robots: int) -> None:
        """Begin without scans.

        Raises:
            ConfigError: If the LiDAR has fewer rays than are asked for.
        """
        lidar = spec.lidar
        rays = lidar.rays if config.rays is None else config.rays
        if rays > lidar.rays:
            raise ConfigError(f"rays is {rays}; the LiDAR of {spec.model} has {lidar.rays}")
        self._config, self._range_max = config, np.float32(lidar.range_max)
        self._sectors = np.arange(rays) * lidar.rays // rays if rays < lidar.rays else None
        self._most = np.maximum(speeds_of(spec), 1e-6)
        self._scans = np.zeros((robots, config.stack, rays), np.float32)
        self._scale = np.array([1, RADIO_RANGE, RADIO_RANGE, np.pi, *self._most[:2]], np.float32)
        self.bounds = self._bounds()

    def _bounds(self) -> Mapping[str, Bounds]:
        config, is_one = self._config, self._config.normalise
        stack, rays = self._scans.shape[1:]
        most, longest = (1.0, 1.0) if is_one else (math.inf, float(self._range_max))
        heard = (config.neighbours, NEIGHBOUR)
        known = {
            "scan": Bounds((stack, rays) if stack > 1 else (rays,), 0.0, longest),
            "goal": Bounds((3 if is_one else 2,), -most, most),
            "way": Bounds((2,), -most, most),
            "twist": Bounds((3,), -most, most),
            "neighbours": Bounds(
                heard if config.neighbours_as == "set" else (3, PIXELS, PIXELS), -most, most
            ),
            "precedence": Bounds((config.neighbours,), -1.0, 1.0),
        }
        return {part: known[part] for part in config.parts}

    def restart(self, ranges: Rows, robots: NDArray[np.bool_]) -> None:
        """Begin an episode of some robots, with the scans of now in place of former ones.

        Args:
            ranges: (n, rays) [m] of the latest scans.
            robots: (n,) mask.
        """
        self._scans[: len(robots)][robots] = self._scan(ranges)[robots, None]

    def add(self, ranges: Rows) -> None:
        """Take in the scans (n, rays) [m] of a step."""
        self._scans[:, :-1] = self._scans[:, 1:]
        self._scans[: len(ranges), -1] = self._scan(ranges)

    def _scan(self, ranges: Rows) -> Rows:
        scans: Rows = np.clip(ranges, np.float32(0.0), self._range_max)
        if self._sectors is not None:
            scans = np.minimum.reduceat(scans, self._sectors, axis=1)
        return scans / self._range_max if self._config.normalise else scans

    def observe(
        self,
        goals: FloatArray,
        ahead: FloatArray,
        poses: FloatArray,
        twists: FloatArray,
        numbers: NDArray[np.int64],
    ) -> Observation:
        """Return what the robots see, a row for each; they are the first m of n.

        Args:
            goals: (m, 2) [m] in map.
            ahead: (m, 2) [m] in map, where their ways lead; of no use without the part `way`.
            poses: (n, 3) x, y, yaw in map.
            twists: (n, 3) vx, wz, vy; vy of the first m only.
            numbers: (n,) of the robots.
        """
        is_one, count = self._config.normalise, len(goals)
        seen: Observation = {}
        for part in self._config.parts:
            if part == "scan":
                seen[part] = self._scans[:count].reshape(count, *self.bounds[part].shape).copy()
            elif part == "goal":
                seen[part] = _polar(_from_robot(goals, poses[:count]), is_one)
            elif part == "way":
                seen[part] = _polar(_from_robot(ahead, poses[:count]), is_one)[:, -2:]
            elif part == "twist":
                own = twists[:count] / self._most if is_one else twists[:count]
                seen[part] = own.astype(np.float32)
            else:
                seen[part] = self._heard(part, count, poses, twists, numbers)
        if is_one:
            for values in seen.values():
                np.clip(values, -1.0, 1.0, out=values)
        return seen

    def _heard(
        self,
        part: Part,
        count: int,
        poses: FloatArray,
        twists: FloatArray,
        numbers: NDArray[np.int64],
    ) -> Rows:
        config = self._config
        if part == "neighbours" and config.neighbours_as == "image":
            image = np.zeros((count, *self.bounds[part].shape), np.float32)
            observation_kernels.draw_neighbours(poses, twists, PIXEL, image)
            if config.normalise:
                image[:, 1:] /= self._scale[4]
            return image
        heard = np.zeros((count, config.neighbours, NEIGHBOUR), np.float32)
        rows = np.zeros(heard.shape[:2], np.int64)
        observation_kernels.nearest(poses, twists, RADIO_RANGE, heard, rows)
        if part == "precedence":
            signs: Rows = np.sign(numbers[rows] - numbers[:count, None]).astype(np.float32)
            return signs
        return heard / self._scale if config.normalise else heard


def flat(seen: Observation) -> Rows:
    """Return all parts of an observation in one row (m, numbers) for each robot."""
    return np.concatenate([part.reshape(len(part), -1) for part in seen.values()], axis=1)


def _from_robot(points: FloatArray, poses: FloatArray) -> FloatArray:
    """Return points (m, 2) [m] in map, in base_footprint of robots at poses (m, 3)."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    gap_x, gap_y = (points - poses[:, :2]).T
    return np.column_stack((cos * gap_x + sin * gap_y, cos * gap_y - sin * gap_x))


def _polar(points: FloatArray, is_wanted: bool) -> Rows:
    """Return d / (1 + d) and the unit vector of points (m, 2), or the points as they are."""
    if not is_wanted:
        return points.astype(np.float32)
    away = np.hypot(*points.T)[:, None]
    return np.hstack((away / (1.0 + away), points / np.maximum(away, 1e-9))).astype(np.float32)


def speeds_of(spec: RobotSpec) -> FloatArray:
    """Return the largest vx, wz and vy [m/s], [rad/s] of a robot; actions are limited to them."""
    return np.array([spec.max_vel_x, spec.max_vel_theta, spec.max_vel_y])


def twist_of(action: FloatArray, spec: RobotSpec, normalised: bool = False) -> Twist:
    """Return the twist of an action: vx, wz and perhaps vy; a number that is none counts as 0.

    Args:
        normalised: Whether the action is in shares of the largest speeds.
    """
    speeds = speeds_of(spec)
    values = np.zeros(3)
    values[: len(action)] = action
    values[~np.isfinite(values)] = 0.0
    vx, wz, vy = np.clip(values * speeds if normalised else values, -speeds, speeds).tolist()
    return Twist(vx, vy, wz)
