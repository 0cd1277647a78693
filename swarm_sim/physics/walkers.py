"""People who walk among the robots: positions, and contacts with robots."""

from __future__ import annotations

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_describe.worlds.actors import WalkerSpec
from swarm_sim.physics.scripted_paths import ScriptedPaths
from swarm_sim.physics.walker_kernels import RobotStates, walk


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
