"""Environments to learn in, over the bench: PettingZoo's parallel one, Gymnasium's for one robot.

Needs the extra `learn`. An action is a twist of base_footprint for one tick, 0.1 s.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_bench.runs.episode import robot_named
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_common.model.robot_names import RobotNames
from swarm_workbench.arena import Arena, OpenArena, ShieldedArena, grid_of, places_on, spread
from swarm_workbench.observation import NEIGHBOUR, REACHED, Observation, observe, speeds_of

try:
    import gymnasium
    from gymnasium import spaces
    from pettingzoo import ParallelEnv
except ImportError as error:
    raise SwarmError(
        f"{error.name} is missing, which environments need: pip install 'swarm-workbench[learn]'"
    ) from None

AT_GOAL, AT_CONTACT, PER_STEP = 10.0, -10.0, -0.01  # rewards; a metre of progress gives 1


class SwarmEnv(ParallelEnv):  # type: ignore[misc]
    """Every robot learns: PettingZoo's parallel environment.

    A robot is done when it is at its goal, or touches something; it then stands where it is. An
    episode begins at random places with random goals, or with `starts` and `goals` of the options
    of `reset`: x, y, yaw and x, y of each robot.

    An observation has `scan` (rays,) [m], `goal` (2,) [m] in base_footprint, `twist` (vx, wz, vy),
    and `neighbours` (k, 6), the nearest first: see `NEIGHBOUR`.
    """

    metadata = {"name": "swarm_workbench_v0", "render_modes": []}  # noqa: RUF012
    render_mode = None

    def __init__(
        self,
        robots: int = 4,
        world: str = "doorway",
        *,
        robot: str = "turtlebot3_waffle",
        neighbours: int = 4,
        limit: float = 60.0,
        shield: bool = False,
    ) -> None:
        """Read world and robot.

        Args:
            neighbours: Most that an observation has.
            limit: [s] after which an episode is truncated.
            shield: Whether navigators keep the robots inside space that they have reserved.

        Raises:
            SwarmError: If there is no such world or robot, or a number makes no sense.
        """
        for name, value in (("robots", robots), ("neighbours", neighbours)):
            if value < 1:
                raise ConfigError(f"{name} is {value}; it must be 1 or more")
        if limit <= 0.0:
            raise ConfigError(f"limit is {limit} s; it must be positive")
        self._spec = spec = robot_named(robot)
        self.possible_agents = RobotNames().first(robots)
        self.agents: list[str] = []
        self._index = {name: index for index, name in enumerate(self.possible_agents)}
        make = ShieldedArena if shield else OpenArena
        self._arena: Arena = make(world, robot, robots)
        self._places = places_on(grid_of(world), spec.circumscribed_radius)
        self._neighbours = neighbours
        self._limit = round(limit / CONTROL_PERIOD)
        self._speeds = speeds_of(spec)
        self._random = np.random.default_rng()
        self._tick = 0
        self._is_done = np.zeros(robots, np.bool_)
        self._goals = np.zeros((robots, 2))
        self._distances = np.zeros(robots)

    @functools.cache  # noqa: B019  (PettingZoo wants the same object)
    def observation_space(self, agent: str) -> spaces.Dict:
        """Return the shapes of an observation."""
        lidar, inf = self._spec.lidar, np.inf
        return spaces.Dict(
            {
                "scan": spaces.Box(0.0, lidar.range_max, (lidar.rays,), np.float32),
                "goal": spaces.Box(-inf, inf, (2,), np.float32),
                "twist": spaces.Box(-inf, inf, (3,), np.float32),
                "neighbours": spaces.Box(-inf, inf, (self._neighbours, NEIGHBOUR), np.float32),
            }
        )

    @functools.cache  # noqa: B019
    def action_space(self, agent: str) -> spaces.Box:
        """Return the limits of a twist: vx [m/s], wz [rad/s], and vy of an omnidirectional one."""
        high = self._speeds[: 3 if self._spec.is_omni else 2].astype(np.float32)
        return spaces.Box(-high, high, dtype=np.float32)

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin an episode.

        Args:
            seed: The same one gives the same episodes.
            options: `starts` (n, 3) and `goals` (n, 2), in place of random ones.
        """
        if seed is not None:
            self._random = np.random.default_rng(seed)
        given = options or {}
        count, radius = len(self.possible_agents), self._spec.circumscribed_radius
        starts = spread(self._places, radius, count, self._random)
        goals = spread(self._places, radius, count, self._random)[:, :2]
        starts = np.asarray(given.get("starts", starts), np.float64)
        self._goals = np.asarray(given.get("goals", goals), np.float64)
        if starts.shape != (count, 3) or self._goals.shape != (count, 2):
            raise ConfigError(f"starts and goals are for {count} robots: (n, 3) and (n, 2)")
        self._tick = 0
        self._is_done[:] = False
        self.agents = list(self.possible_agents)
        self._arena.reset(starts, int(self._random.integers(2**31)))
        self._distances = self._to_goals()
        return self._observations(self.agents), {name: {} for name in self.agents}

    def step(self, actions: Mapping[str, Any]) -> tuple[Any, ...]:
        """Drive for a tick; return observations, rewards, terminations, truncations and infos."""
        twists = np.zeros((len(self.possible_agents), 3))
        for name, action in actions.items():
            index = self._index[name]
            if not self._is_done[index]:
                twists[index, : len(action)] = action
        twists[~np.isfinite(twists)] = 0.0
        np.clip(twists, -self._speeds, self._speeds, out=twists)
        contacts = self._arena.step(twists)
        self._tick += 1
        distances = self._to_goals()
        reached = distances < REACHED
        rewards = self._distances - distances + PER_STEP
        rewards += AT_GOAL * reached + AT_CONTACT * contacts
        self._distances = distances
        is_late = self._tick >= self._limit
        present, self.agents = self.agents, []
        ends, cuts, infos = {}, {}, {}
        for name in present:
            index = self._index[name]
            ends[name] = self._is_done[index] = bool(reached[index] or contacts[index])
            cuts[name] = is_late and not ends[name]
            infos[name] = {"reached": bool(reached[index]), "contact": bool(contacts[index])}
            if not (ends[name] or cuts[name]):
                self.agents.append(name)
        gains = {name: float(rewards[self._index[name]]) for name in present}
        return self._observations(present), gains, ends, cuts, infos

    def render(self) -> None:
        """Show nothing: there is no render mode."""

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    def _to_goals(self) -> FloatArray:
        distances: FloatArray = np.hypot(*(self._goals - self._arena.poses[:, :2]).T)
        return distances

    def _observations(self, names: list[str]) -> dict[str, Observation]:
        arena = self._arena
        seen = observe(
            arena.ranges, self._spec.lidar.range_max, self._goals, arena.poses, arena.twists,
            self._neighbours,
        )  # fmt: skip
        rows = zip(*seen.values(), strict=True)
        of_all = [dict(zip(seen, row, strict=True)) for row in rows]
        return {name: of_all[self._index[name]] for name in names}


class RobotEnv(gymnasium.Env):  # type: ignore[misc]
    """One robot learns among others that stand: Gymnasium's environment; see `SwarmEnv`."""

    metadata = SwarmEnv.metadata

    def __init__(self, robots: int = 4, world: str = "doorway", **options: Any) -> None:
        """Read world and robot.

        Args:
            options: As of `SwarmEnv`.
        """
        self._env = SwarmEnv(robots, world, **options)
        self._name = self._env.possible_agents[0]
        self.observation_space = self._env.observation_space(self._name)
        self.action_space = self._env.action_space(self._name)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see `SwarmEnv.reset`."""
        super().reset(seed=seed)
        observations, infos = self._env.reset(seed, options)
        return observations[self._name], infos[self._name]

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for a tick; return observation, reward, termination, truncation and info."""
        if self._name not in self._env.agents:
            raise SwarmError("the episode is over: call reset()")
        results = self._env.step({self._name: action})
        observation, reward, end, cut, info = (each[self._name] for each in results)
        return observation, reward, end, cut, info
