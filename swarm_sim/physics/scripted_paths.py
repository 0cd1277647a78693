"""Base of walkers and vehicles: closed scripted paths, pauses, and contacts with robots."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

import numpy as np

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import FloatArray, Pose, RobotSpec
from swarm_describe.worlds.actors import VehicleSpec, WalkerSpec
from swarm_sim.physics.engine import Touch
from swarm_sim.physics.walker_kernels import Loops, RobotStates
from swarm_sim.scene.randomness import hash_words, uniform

PAUSES = 64  # drawn for each; then they begin again
START_GAP = 0.4  # [m] from any robot's circle at the start

Spec = TypeVar("Spec", bound=WalkerSpec | VehicleSpec)


class ScriptedPaths(ABC, Generic[Spec]):
    """Everybody of one kind on their closed paths."""

    words: tuple[int, int]  # words that draw the random numbers of starts and of pauses
    search_step: float  # [m] along a path when looking for a place that is free of robots

    def __init__(
        self,
        specs: Sequence[Spec],
        robots: Sequence[RobotSpec],
        poses_map: Sequence[Pose],
        seed: int,
    ) -> None:
        """Place them on their paths, away from the robots."""
        self.specs: tuple[Spec, ...] = tuple(specs)
        count = len(specs)
        corners = max([len(spec.path) for spec in specs], default=1) + 1
        self._paths = np.zeros((count, corners, 2))
        self._arcs = np.zeros((count, corners))
        self._counts = np.array([len(spec.path) + 1 for spec in specs], np.int64)
        self._pauses = np.zeros((count, PAUSES))
        self._state = np.zeros((count, 5))
        self._state[:, 1] = 1.0
        self._places = np.zeros((count, 2))
        self._radii = np.array([robot.circumscribed_radius for robot in robots])
        self._touches = np.full((len(robots), count), -1, np.int64)
        centres = np.array([(p.x, p.y) for p in poses_map]).reshape(-1, 2)
        for index in range(count):
            self._lay_out(index, centres, seed)
        self._set_up()

    @abstractmethod
    def _set_up(self) -> None:
        """Prepare what only this kind needs."""

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.specs)

    def add_robot(self, spec: RobotSpec) -> None:
        """Add a robot that the bodies can meet."""
        self._radii = np.append(self._radii, spec.circumscribed_radius)
        self._touches = np.full((len(self._radii), len(self.specs)), -1, np.int64)

    def begin(self) -> None:
        """Begin a control period."""
        self._touches[:] = -1

    def step(
        self, poses: FloatArray, speeds: FloatArray, hulls: FloatArray, period: float, step: int
    ) -> bool:
        """Go on for one physics step; return whether somebody ran into a robot."""
        if not len(self.specs) or not len(hulls):
            return False
        contiguous = np.ascontiguousarray(poses), np.ascontiguousarray(speeds)
        return self._advance(RobotStates(*contiguous, hulls, self._radii), period, step)

    @abstractmethod
    def _advance(self, robots: RobotStates, period: float, step: int) -> bool:
        """Go on among robots that can be met; see `step`."""

    @property
    def _loops(self) -> Loops:
        return Loops(self._paths, self._arcs, self._counts, self._pauses)

    def touches(self) -> list[Touch]:
        """Return the contacts that walkers or vehicles caused in this control period."""
        return [
            Touch(int(i), -1, self.specs[k].name, *self._place(k), int(self._touches[i, k]))
            for i, k in np.argwhere(self._touches >= 0)
        ]

    def _place(self, index: int) -> tuple[float, float]:
        x, y = self._places[index].tolist()
        return x, y

    def _lay_out(self, index: int, centres: FloatArray, seed: int) -> None:
        spec = self.specs[index]
        start_word, pause_word = self.words
        closed = np.array([*spec.path, spec.path[0]])
        self._paths[index, : len(closed)] = closed
        arcs = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
        self._arcs[index, : len(arcs)] = arcs
        pauses = uniform(hash_words(seed, pause_word, index, np.arange(PAUSES)))
        self._pauses[index] = spec.pause * (0.5 + pauses)
        draw = float(uniform(hash_words(seed, start_word, index)))
        start = draw * arcs[-1] if spec.start is None else spec.start
        for offset in np.arange(0.0, arcs[-1], self.search_step):
            arc = float((start + offset) % arcs[-1])
            x, y = (float(np.interp(arc, arcs, closed[:, axis])) for axis in range(2))
            gaps = np.hypot(centres[:, 0] - x, centres[:, 1] - y) - self._radii
            if gaps.min(initial=math.inf) >= spec.radius + START_GAP:
                self._state[index, 0] = arc
                self._places[index] = x, y
                return
        raise ConfigError(f"{spec.name}: robots stand all along its path; move its path or them")
