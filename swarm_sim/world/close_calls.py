"""Near misses: episodes in which a robot came very close to something, but did not touch it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_sim.physics.engine import NearPair

EPISODE_GAP = 0.5  # [s] without approach, or contact, that end an episode
Key = tuple[int, int, str]  # robot, other robot or -1, obstacle


@dataclass(frozen=True, slots=True)
class NearMiss:
    """An episode closer than `engine.NEAR_MISS` without contact."""

    robots: tuple[str, ...]  # names of the one or two robots in it
    obstacle: str  # name of the obstacle; empty if two robots met
    x: float  # [m] of the robot, or halfway between the two, where they were closest
    y: float  # [m]
    sim_time: float  # [s] when it began
    distance: float  # [m] smallest


@dataclass(slots=True)
class _Episode:
    start: float
    last: float
    distance: float
    place: tuple[float, float]


class CloseCalls:
    """Collects near misses tick by tick."""

    def __init__(self, names: Sequence[str]) -> None:
        """Begin without episodes."""
        self._names = list(names)
        self._open: dict[Key, _Episode] = {}
        self._last_touch: dict[Key, float] = {}
        self._over: list[tuple[Key, _Episode]] = []

    def add(self, name: str) -> None:
        """Add a robot."""
        self._names.append(name)

    def touch(self, key: Key, time: float) -> None:
        """Record a contact: the episode is a collision, and no near miss."""
        self._last_touch[key] = time
        self._open.pop(key, None)

    def observe(self, time: float, approaches: Iterable[NearPair], poses: FloatArray) -> None:
        """Record the near pairs at the end of a control period."""
        for key in [k for k, e in self._open.items() if time - e.last > EPISODE_GAP + 1e-9]:
            self._over.append((key, self._open.pop(key)))
        for approach in approaches:
            key = (approach.robot, approach.other, approach.obstacle)
            if time - self._last_touch.get(key, -np.inf) <= EPISODE_GAP + 1e-9:
                self._last_touch[key] = time  # still the collision's
                continue
            members = [approach.robot] if approach.other < 0 else [approach.robot, approach.other]
            x, y = poses[members, :2].mean(axis=0)
            episode = self._open.setdefault(key, _Episode(time, time, np.inf, (0.0, 0.0)))
            episode.last = time
            if approach.gap < episode.distance:
                episode.distance, episode.place = approach.gap, (float(x), float(y))

    def near_misses(self) -> tuple[NearMiss, ...]:
        """Return the episodes so far, in order of time."""
        episodes = [*self._over, *self._open.items()]
        return tuple(
            NearMiss(
                tuple(self._names[member] for member in key[:2] if member >= 0),
                key[2],
                *episode.place,
                round(episode.start, 6),
                float(episode.distance),
            )
            for key, episode in sorted(episodes, key=lambda pair: (pair[1].start, pair[0]))
        )
