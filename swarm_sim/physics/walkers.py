"""People who walk among the robots: positions, and contacts with robots."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_common.model.records import FloatArray, Pose, RobotSpec
from swarm_sim.physics.scripted_paths import ScriptedPaths
from swarm_sim.physics.walker_kernels import RobotStates, walk
from swarm_sim.scene.actors import WalkerSpec

SEARCH_STEP = 0.1  # [m] along the path when looking for a place to start
WORDS = (71, 72)  # what the random numbers of starts and pauses are for


class Walkers(ScriptedPaths[WalkerSpec]):
    """All walkers of a world.

    Attributes:
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
        """Place the walkers on their paths, away from the robots."""
        super().__init__(specs, robots, poses_map, seed, WORDS, SEARCH_STEP)
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
