"""Environments to learn in, over the bench: PettingZoo's parallel one, Gymnasium's for one policy.

Needs the extra `learn`. An action is a twist of base_footprint for one tick, 0.1 s. Gymnasium's
vector environments run copies of `RobotEnv` and `TeamEnv`, `AsyncVectorEnv` in a process each.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_bench.runs.episode import robot_named
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Mask
from swarm_common.model.robot_names import RobotNames
from swarm_workbench.arena import Arena, OpenArena, ShieldedArena, grid_of, places_on, spread
from swarm_workbench.observation import NEIGHBOUR, REACHED, Observation, observe, speeds_of

try:
    import gymnasium
    from gymnasium import spaces
    from gymnasium.vector.utils import batch_space
    from pettingzoo import ParallelEnv
except ImportError as error:
    raise SwarmError(
        f"{error.name} is missing, which environments need: pip install 'swarm-workbench[learn]'"
    ) from None

AT_GOAL, AT_CONTACT, PER_STEP = 10.0, -10.0, -0.01  # rewards; a metre of progress gives 1
METADATA: dict[str, Any] = {"name": "swarm_workbench_v0", "render_modes": []}


class _Team:
    """Episodes of all robots, in arrays with a row for each.

    Attributes:
        is_done: (n,) who has reached its goal or touched something, and stands.
    """

    def __init__(
        self,
        robots: int,
        world: str,
        *,
        robot: str = "turtlebot3_waffle",
        neighbours: int = 4,
        limit: float = 60.0,
        shield: bool = False,
    ) -> None:
        """Read world and robot; arguments as of `SwarmEnv`."""
        for name, value in (("robots", robots), ("neighbours", neighbours)):
            if value < 1:
                raise ConfigError(f"{name} is {value}; it must be 1 or more")
        if limit <= 0.0:
            raise ConfigError(f"limit is {limit} s; it must be positive")
        self._spec = spec = robot_named(robot)
        make = ShieldedArena if shield else OpenArena
        self._arena: Arena = make(world, robot, robots)
        self._places = places_on(grid_of(world), spec.circumscribed_radius)
        self._neighbours = neighbours
        self._limit = round(limit / CONTROL_PERIOD)
        self._speeds = speeds_of(spec)
        self._random = np.random.default_rng()
        self._tick = self._limit
        self.is_done = np.zeros(robots, np.bool_)
        self._goals = np.zeros((robots, 2))
        self._distances = np.zeros(robots)

    @property
    def observation_space(self) -> spaces.Dict:
        """Shapes of what one robot sees."""
        lidar, inf = self._spec.lidar, np.inf
        return spaces.Dict(
            {
                "scan": spaces.Box(0.0, lidar.range_max, (lidar.rays,), np.float32),
                "goal": spaces.Box(-inf, inf, (2,), np.float32),
                "twist": spaces.Box(-inf, inf, (3,), np.float32),
                "neighbours": spaces.Box(-inf, inf, (self._neighbours, NEIGHBOUR), np.float32),
            }
        )

    @property
    def action_space(self) -> spaces.Box:
        """Limits of a twist: vx [m/s], wz [rad/s], and vy of an omnidirectional robot."""
        high = self._speeds[: 3 if self._spec.is_omni else 2].astype(np.float32)
        return spaces.Box(-high, high, dtype=np.float32)

    def is_late(self) -> bool:
        """Whether the limit is over, as before the first episode."""
        return self._tick >= self._limit

    def reset(self, seed: int | None, options: Mapping[str, Any] | None) -> None:
        """Begin an episode."""
        if seed is not None:
            self._random = np.random.default_rng(seed)
        given = options or {}
        count, radius = len(self.is_done), self._spec.circumscribed_radius
        starts = spread(self._places, radius, count, self._random)
        goals = spread(self._places, radius, count, self._random)[:, :2]
        starts = np.asarray(given.get("starts", starts), np.float64)
        self._goals = np.asarray(given.get("goals", goals), np.float64)
        if starts.shape != (count, 3) or self._goals.shape != (count, 2):
            raise ConfigError(f"starts and goals are for {count} robots: (n, 3) and (n, 2)")
        self._tick = 0
        self.is_done[:] = False
        self._arena.reset(starts, int(self._random.integers(2**31)))
        self._distances = self._to_goals()

    def step(self, actions: Mapping[int, Any]) -> tuple[FloatArray, Mask, Mask]:
        """Drive for a tick by actions of some robots; return rewards, who is there, contacts."""
        twists = np.zeros((len(self.is_done), 3))
        for index, action in actions.items():
            twists[index, : len(action)] = action
        twists[self.is_done] = 0.0
        twists[~np.isfinite(twists)] = 0.0
        np.clip(twists, -self._speeds, self._speeds, out=twists)
        contacts = self._arena.step(twists)
        self._tick += 1
        distances = self._to_goals()
        reached = distances < REACHED
        rewards = self._distances - distances + PER_STEP
        rewards += AT_GOAL * reached + AT_CONTACT * contacts
        rewards[self.is_done] = 0.0
        self._distances = distances
        self.is_done |= reached | contacts
        return rewards, reached, contacts

    def observe(self) -> Observation:
        """Return what all robots see."""
        arena = self._arena
        return observe(
            arena.ranges, self._spec.lidar.range_max, self._goals, arena.poses, arena.twists,
            self._neighbours,
        )  # fmt: skip

    def _to_goals(self) -> FloatArray:
        distances: FloatArray = np.hypot(*(self._goals - self._arena.poses[:, :2]).T)
        return distances


class SwarmEnv(ParallelEnv):  # type: ignore[misc]
    """Every robot learns: PettingZoo's parallel environment.

    A robot is done when it is at its goal, or touches something; it then stands where it is. An
    episode begins at random places with random goals, or with `starts` and `goals` of the options
    of `reset`: x, y, yaw and x, y of each robot.

    An observation has `scan` (rays,) [m], `goal` (2,) [m] in base_footprint, `twist` (vx, wz, vy),
    and `neighbours` (k, 6), the nearest first: 1, x, y, yaw in base_footprint, vx, wz, or zeros.
    """

    metadata = METADATA
    render_mode = None

    def __init__(self, robots: int = 4, world: str = "doorway", **options: Any) -> None:
        """Read world and robot.

        Args:
            options: `robot`, a model; `neighbours`, most that are seen (4); `limit` [s] of an
                episode (60); `shield`, whether robots drive inside space that they have reserved,
                through their navigators' stop filter (False).

        Raises:
            SwarmError: If there is no such world or robot, or a number makes no sense.
        """
        self._team = _Team(robots, world, **options)
        self.possible_agents = RobotNames().first(robots)
        self.agents: list[str] = []
        self._index = {name: index for index, name in enumerate(self.possible_agents)}
        team, names = self._team, self.possible_agents
        # PettingZoo wants the same object at each call.
        self._spaces = {name: (team.observation_space, team.action_space) for name in names}

    def observation_space(self, agent: str) -> spaces.Dict:
        """Return the shapes of an observation."""
        return self._spaces[agent][0]

    def action_space(self, agent: str) -> spaces.Box:
        """Return the limits of a twist: vx [m/s], wz [rad/s], and vy of an omnidirectional one."""
        return self._spaces[agent][1]

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin an episode.

        Args:
            seed: The same one gives the same episodes.
            options: `starts` (n, 3) and `goals` (n, 2), in place of random ones.
        """
        self._team.reset(seed, options)
        self.agents = list(self.possible_agents)
        return self._observations(self.agents), {name: {} for name in self.agents}

    def step(self, actions: Mapping[str, Any]) -> tuple[Any, ...]:
        """Drive for a tick; return observations, rewards, terminations, truncations and infos."""
        team, present = self._team, self.agents
        results = team.step({self._index[name]: action for name, action in actions.items()})
        columns = (each.tolist() for each in (team.is_done, *results))
        rows = dict(zip(self.possible_agents, zip(*columns, strict=True), strict=True))
        ends = {name: rows[name][0] for name in present}
        cuts = {name: team.is_late() and not ends[name] for name in present}
        gains = {name: rows[name][1] for name in present}
        infos = {name: {"reached": rows[name][2], "contact": rows[name][3]} for name in present}
        self.agents = [] if team.is_late() else [name for name in present if not ends[name]]
        return self._observations(present), gains, ends, cuts, infos

    def render(self) -> None:
        """Show nothing: there is no render mode."""

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    def _observations(self, names: list[str]) -> dict[str, Observation]:
        seen = self._team.observe()
        rows = [dict(zip(seen, row, strict=True)) for row in zip(*seen.values(), strict=True)]
        return {name: rows[self._index[name]] for name in names}


class TeamEnv(gymnasium.Env):  # type: ignore[misc]
    """One policy drives all robots: observations and actions have a row for each; see `SwarmEnv`.

    The reward is the sum; infos have `rewards`, `reached` and `contact` (n,).
    """

    metadata = METADATA

    def __init__(self, robots: int = 4, world: str = "doorway", **options: Any) -> None:
        """Read world and robot.

        Args:
            options: Options as for `SwarmEnv`.
        """
        self._team = _Team(robots, world, **options)
        self.observation_space = batch_space(self._team.observation_space, robots)
        self.action_space = batch_space(self._team.action_space, robots)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see `SwarmEnv.reset`."""
        super().reset(seed=seed)
        self._team.reset(seed, options)
        return self._team.observe(), {}

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for a tick; return observation, reward, termination, truncation and info."""
        team = self._team
        if team.is_late() or team.is_done.all():
            raise SwarmError("the episode is over: call reset()")
        rewards, reached, contacts = team.step(dict(enumerate(action)))
        is_over = bool(team.is_done.all())
        info = {"rewards": rewards, "reached": reached, "contact": contacts}
        return team.observe(), float(rewards.sum()), is_over, team.is_late() and not is_over, info


class RobotEnv(gymnasium.Env):  # type: ignore[misc]
    """One robot learns among others that stand: Gymnasium's environment; see `SwarmEnv`."""

    metadata = METADATA

    def __init__(self, robots: int = 4, world: str = "doorway", **options: Any) -> None:
        """Read world and robot."""
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
