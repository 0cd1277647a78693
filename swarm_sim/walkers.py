"""People who walk among the robots: where they are, and whom they run into."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.errors import ConfigError
from swarm_common.records import Pose, RobotSpec
from swarm_sim.actors import WalkerSpec
from swarm_sim.engine import Touch
from swarm_sim.randomness import hash_words, uniform
from swarm_sim.walker_kernels import walk

FloatArray = NDArray[np.float64]
PAUSES = 64  # drawn for each walker; then they begin again
START_GAP = 0.4  # [m] from any robot's circle at the start
SEARCH_STEP = 0.1  # [m] along the path when looking for such a place
START_WORD, PAUSE_WORD = 71, 72  # what a random number is for


class Walkers:
    """All walkers of a world.

    Attributes:
        names: As collisions name them.
        discs: (m, 3) x, y, radius [m] in map.
        speeds: (m,) [m/s] of each.
    """

    def __init__(
        self,
        specs: Sequence[WalkerSpec],
        robots: Sequence[RobotSpec],
        poses_map: Sequence[Pose],
        seed: int,
    ) -> None:
        """Place the walkers on their paths, away from the robots.

        Args:
            specs: One per walker.
            robots: Models of the robots.
            poses_map: Where these start.
            seed: Of starts that are not given, and of pauses.

        Raises:
            ConfigError: If a walker has no place on its path that is free of robots.
        """
        self.names = [spec.name for spec in specs]
        self.specs = tuple(specs)
        self.speeds = np.array([spec.speed for spec in specs])
        count = len(specs)
        corners = max([len(spec.path) for spec in specs], default=1) + 1
        self._paths = np.zeros((count, corners, 2))
        self._arcs = np.zeros((count, corners))
        self._counts = np.array([len(spec.path) + 1 for spec in specs], np.int64)
        self._traits = np.array(
            [[s.speed, s.radius, s.step_length, s.patience] for s in specs]
        ).reshape(-1, 4)
        self._pauses = np.zeros((count, PAUSES))
        self._state = np.zeros((count, 5))
        self._state[:, 1] = 1.0
        self.discs: FloatArray = np.zeros((count, 3))
        radii = [robot.circumscribed_radius for robot in robots]
        circles = np.array([(p.x, p.y, r) for p, r in zip(poses_map, radii, strict=True)])
        self._radii = np.array(radii)
        self._touches = np.full((len(robots), count), -1, np.int64)
        for index, spec in enumerate(specs):
            self._lay_out(index, spec, circles.reshape(-1, 3), seed)
        self._places = np.ascontiguousarray(self.discs[:, :2])

    def __len__(self) -> int:
        """Return the number of walkers."""
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
        """Walk for one physics step; return whether a walker ran into a robot.

        Args:
            poses: True poses (n, 3) of the robots.
            speeds: Forward speeds (n,) [m/s].
            hulls: Footprints (n, k, 2) in base_footprint.
            period: [s] of the step.
            step: Its number within the control period.
        """
        if not len(hulls):
            return False
        touched = walk(
            self._state,
            self._places,
            self._traits,
            (self._paths, self._arcs, self._counts, self._pauses),
            (np.ascontiguousarray(poses), np.ascontiguousarray(speeds), hulls, self._radii),
            self._touches,
            period,
            step,
        )
        self.discs[:, :2] = self._places
        return bool(touched)

    def touches(self) -> list[Touch]:
        """Return whom the walkers ran into in this control period."""
        return [
            Touch(int(i), -1, self.names[w], *self._place(w), int(self._touches[i, w]))
            for i, w in np.argwhere(self._touches >= 0)
        ]

    def _place(self, walker: int) -> tuple[float, float]:
        x, y = self._places[walker].tolist()
        return x, y

    def _lay_out(self, index: int, spec: WalkerSpec, circles: FloatArray, seed: int) -> None:
        closed = np.array([*spec.path, spec.path[0]])
        self._paths[index, : len(closed)] = closed
        lengths = np.hypot(*np.diff(closed, axis=0).T)
        arcs = np.concatenate([[0.0], np.cumsum(lengths)])
        self._arcs[index, : len(arcs)] = arcs
        words = hash_words(seed, PAUSE_WORD, index, np.arange(PAUSES))
        self._pauses[index] = spec.pause * (0.5 + uniform(words))
        draw = float(uniform(hash_words(seed, START_WORD, index)))
        start = draw * arcs[-1] if spec.start is None else spec.start
        for offset in np.arange(0.0, arcs[-1], SEARCH_STEP):
            arc = float((start + offset) % arcs[-1])
            x, y = (float(np.interp(arc, arcs, closed[:, axis])) for axis in range(2))
            gaps = np.hypot(circles[:, 0] - x, circles[:, 1] - y) - circles[:, 2]
            if gaps.min(initial=math.inf) >= spec.radius + START_GAP:
                self._state[index, 0] = arc
                self.discs[index] = x, y, spec.radius
                return
        raise ConfigError(f"{spec.name}: robots stand all along its path; move its path or them")
