"""Environments to learn in, over the bench: PettingZoo's parallel one, Gymnasium's for one policy.

Needs the extra `learn`. An action is a twist of base_footprint for one tick, 0.1 s, or for `ticks`
of them. Gymnasium knows `swarm_workbench/Robot-v0` and `swarm_workbench/Team-v0`, PettingZoo
`swarm_workbench/Swarm-v0`, once this module is imported. `make_vec` makes many at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_common.model.errors import SwarmError, UnknownNameError
from swarm_common.model.robot_names import RobotNames
from swarm_workbench.frames import Frame, PlanWindow
from swarm_workbench.team import EnvOptions, LearningTeam, options_of

try:
    import gymnasium
    import pettingzoo
    from gymnasium.vector.utils import batch_space
    from pettingzoo import ParallelEnv

    from swarm_workbench.vector import SwarmVectorEnv, spaces_of
except ImportError as error:
    raise SwarmError(
        f"{error.name} is missing, which environments need: pip install 'swarm-workbench[learn]'"
    ) from None

METADATA: dict[str, Any] = {
    "name": "swarm_workbench_v0",
    "render_modes": ["human", "rgb_array"],
    "render_fps": 30,  # three times real time
}
Seen = Any  # an array, or a dict of arrays by part


class _Pictures:
    """What an environment shows of its team."""

    def __init__(self, team: LearningTeam) -> None:
        self.mode = team.options.render_mode
        self._team, self._window = team, PlanWindow()

    def render(self) -> Frame | None:
        """Return a picture, or show it, as the render mode says."""
        if self.mode is None:
            return None
        frame = self._team.frame()
        if self.mode == "rgb_array":
            return frame
        self._window.show(frame)
        return None

    def update(self) -> None:
        """Show a picture where a person looks on."""
        if self.mode == "human":
            self.render()

    def close(self) -> None:
        """Close the window."""
        self._window.close()


class SwarmEnv(ParallelEnv):  # type: ignore[misc]
    """Every robot learns: PettingZoo's parallel environment.

    A robot is done when it is at its goal, or touches something; it then stands where it is. An
    episode begins at random places with random goals, or as the options of `reset` say: `starts`
    and `goals`, x, y, yaw and x, y of each robot; `distance` [m] of the goals, at most, or at least
    and at most; `robots` that take part; `people` who walk about.

    What it sees is in `EnvOptions`.
    """

    metadata = METADATA

    def __init__(self, robots: int = 4, world: str = "doorway", **options: Any) -> None:
        """Read world and robot.

        Args:
            options: Fields of `EnvOptions`.

        Raises:
            SwarmError: If an option is unknown or makes no sense.
        """
        self._team = LearningTeam(options_of(robots, world, options))
        self._pictures = _Pictures(self._team)
        self.render_mode = self._pictures.mode
        self.possible_agents = RobotNames().first(robots)
        self.agents: list[str] = []
        self._index = {name: index for index, name in enumerate(self.possible_agents)}
        # PettingZoo wants the same object at each call.
        self._spaces = {name: spaces_of(self._team) for name in self.possible_agents}

    @property
    def options(self) -> EnvOptions:
        """All options, also those that were not given."""
        return self._team.options

    def observation_space(self, agent: str) -> Any:
        """Return the shapes of an observation."""
        return self._spaces[self._known(agent)][0]

    def action_space(self, agent: str) -> Any:
        """Return the limits of a twist: vx [m/s], wz [rad/s], and vy of an omnidirectional one."""
        return self._spaces[self._known(agent)][1]

    def _known(self, agent: str) -> str:
        if agent not in self._index:
            raise UnknownNameError("robot", str(agent), self.possible_agents)
        return agent

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Seen], dict[str, dict[str, Any]]]:
        """Begin an episode.

        Args:
            seed: The same one gives the same episodes.
            options: What is not to be random; see above.

        Raises:
            SwarmError: If they make no sense.
        """
        if isinstance(options, Mapping):  # PettingZoo's API check passes this key
            options = {key: value for key, value in options.items() if key != "options"}
        self._team.reset(seed, options)
        self.agents = self.possible_agents[: self._team.count]
        self._pictures.update()
        return self._observations(self.agents), {name: {} for name in self.agents}

    def step(self, actions: Mapping[str, Any]) -> tuple[Any, ...]:
        """Drive for a step; return observations, rewards, terminations, truncations and infos.

        A robot without an action stands. After an episode, and without actions, all are empty.

        Raises:
            SwarmError: If a robot is unknown, an action makes no sense, or the episode is over.
        """
        team, present = self._team, self.agents
        if team.has_begun and not present and not actions:
            return {}, {}, {}, {}, {}
        team.check_begun()
        rows = [self._index[self._known(name)] for name in actions]
        twists = np.zeros((team.count, len(team.most)))
        twists[rows] = team.actions_of(actions)
        results = team.step(twists)
        columns = (each.tolist() for each in (team.is_done, team.is_late, *results))
        found = dict(zip(self.possible_agents, zip(*columns, strict=True), strict=False))
        ends = {name: found[name][0] for name in present}
        cuts = {name: found[name][1] and not ends[name] for name in present}
        gains = {name: found[name][2] for name in present}
        infos = {name: {"reached": found[name][3], "contact": found[name][4]} for name in present}
        self.agents = [name for name in present if not (ends[name] or cuts[name])]
        self._pictures.update()
        return self._observations(present), gains, ends, cuts, infos

    def render(self) -> Frame | None:
        """Return a picture of the plan, (h, w, 3), or show it, as `render_mode` says."""
        return self._pictures.render()

    def close(self) -> None:
        """Close the window."""
        self._pictures.close()

    def _observations(self, names: list[str]) -> dict[str, Seen]:
        seen = self._team.seen()
        if not isinstance(seen, dict):
            return {name: seen[self._index[name]] for name in names}
        rows = [dict(zip(seen, row, strict=True)) for row in zip(*seen.values(), strict=True)]
        return {name: rows[self._index[name]] for name in names}


class TeamEnv(gymnasium.Env):  # type: ignore[misc]
    """One policy drives all robots: observations and actions have a row for each; see `SwarmEnv`.

    The reward is the sum; infos have `rewards`, `reached` and `contact` (n,), and `terms` of the
    rewards by name. Rows of robots that do not take part are zeros.
    """

    metadata = METADATA

    def __init__(self, robots: int = 4, world: str = "doorway", **options: Any) -> None:
        """Read world and robot.

        Args:
            options: Options as for `SwarmEnv`.
        """
        self._team = LearningTeam(options_of(robots, world, options))
        self._pictures = _Pictures(self._team)
        self.render_mode = self._pictures.mode
        of_one, actions = spaces_of(self._team)
        self.observation_space = batch_space(of_one, robots)
        self.action_space = batch_space(actions, robots)
        self._robots = robots

    @property
    def options(self) -> EnvOptions:
        """All options, also those that were not given."""
        return self._team.options

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Seen, dict[str, Any]]:
        """Begin an episode; see `SwarmEnv.reset`."""
        self._team.reset(seed, options)
        super().reset(seed=seed)
        self._pictures.update()
        return self._seen(), {}

    def step(self, action: Any) -> tuple[Seen, float, bool, bool, dict[str, Any]]:
        """Drive for a step; return observation, reward, termination, truncation and info."""
        team = self._team
        team.check_begun()
        if np.shape(action) != self.action_space.shape:
            raise SwarmError(
                f"the action has the shape {np.shape(action)}; expected {self.action_space.shape},"
                " a row for each robot"
            )
        actions = np.asarray(action)
        if actions.dtype.kind not in "fiu" or not np.isfinite(actions).all():
            named = {f"robot {row + 1}": each for row, each in enumerate(action)}
            actions = team.actions_of(named)
        results = [self._padded(each) for each in team.step(actions[: team.count])]
        rewards, reached, contacts = results
        is_over = bool(team.is_done.all())
        is_late = bool((team.is_done | team.is_late).all()) and not is_over
        terms = {name: self._padded(values) for name, values in team.terms.items()}
        info = {"rewards": rewards, "reached": reached, "contact": contacts, "terms": terms}
        self._pictures.update()
        return self._seen(), float(rewards.sum()), is_over, is_late, info

    def render(self) -> Frame | None:
        """Return a picture of the plan, (h, w, 3), or show it, as `render_mode` says."""
        return self._pictures.render()

    def close(self) -> None:
        """Close the window."""
        self._pictures.close()

    def _seen(self) -> Seen:
        seen = self._team.seen()
        if isinstance(seen, dict):
            return {part: self._padded(rows) for part, rows in seen.items()}
        return self._padded(seen)

    def _padded(self, rows: Any) -> Any:
        missing = self._robots - len(rows)
        return np.pad(rows, [(0, missing)] + [(0, 0)] * (rows.ndim - 1)) if missing else rows


class RobotEnv(gymnasium.Env):  # type: ignore[misc]
    """One robot learns among others that stand: Gymnasium's environment; see `SwarmEnv`."""

    metadata = METADATA

    def __init__(self, robots: int = 4, world: str = "doorway", **options: Any) -> None:
        """Read world and robot.

        Args:
            options: Options as for `SwarmEnv`.
        """
        self._env = SwarmEnv(robots, world, **options)
        self.render_mode = self._env.render_mode
        self._name = self._env.possible_agents[0]
        self.observation_space = self._env.observation_space(self._name)
        self.action_space = self._env.action_space(self._name)

    @property
    def options(self) -> EnvOptions:
        """All options, also those that were not given."""
        return self._env.options

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Seen, dict[str, Any]]:
        """Begin an episode; see `SwarmEnv.reset`."""
        observations, infos = self._env.reset(seed, options)
        super().reset(seed=seed)
        return observations[self._name], infos[self._name]

    def step(self, action: Any) -> tuple[Seen, float, bool, bool, dict[str, Any]]:
        """Drive for a step; return observation, reward, termination, truncation and info."""
        if self._name not in self._env.agents:
            raise SwarmError("no episode is under way: call reset()")
        results = self._env.step({self._name: action})
        observation, reward, end, cut, info = (each[self._name] for each in results)
        return observation, reward, end, cut, info

    def render(self) -> Frame | None:
        """Return a picture of the plan, (h, w, 3), or show it, as `render_mode` says."""
        return self._env.render()

    def close(self) -> None:
        """Close the window."""
        self._env.close()


def make_vec(
    n: int,
    world: str = "doorway",
    *,
    robots: int = 1,
    processes: int = 1,
    autoreset: str = "next_step",
    **options: Any,
) -> SwarmVectorEnv:
    """Return n worlds as one vector environment of Gymnasium, in which a policy drives all robots.

    Each robot of each world is a row, an environment of its own: `num_envs` is n times `robots`.
    When its episode ends it gets a new start and goal, while the others of its world drive on; with
    `shield` a new goal only. The curriculum is asked for each new episode, for `robots` and
    `people` in `reset` alone.

    Args:
        n: Worlds; each has all `robots`.
        robots: Robots in each world, of which each is a row of its own.
        processes: Number of processes that share the worlds; 1 for none beside this one.
        autoreset: `next_step` or `same_step`, as Gymnasium names its modes.
        options: Options as for `SwarmEnv`.

    Raises:
        SwarmError: If an option is unknown or makes no sense.
    """
    return SwarmVectorEnv(n, options_of(robots, world, options), processes, autoreset)


def _make_vec(num_envs: int = 1, **options: Any) -> SwarmVectorEnv:
    """Return what `gymnasium.make_vec` asks for."""
    return make_vec(num_envs, **options)


def _register() -> None:
    """Tell Gymnasium and PettingZoo of the environments, once."""
    names, here = "swarm_workbench/{}-v0", f"{__name__}:"
    if names.format("Robot") in gymnasium.registry:
        return
    gymnasium.register(
        names.format("Robot"), here + "RobotEnv", vector_entry_point=here + "_make_vec"
    )
    gymnasium.register(names.format("Team"), here + "TeamEnv")
    pettingzoo.register("parallel", names.format("Swarm"), here + "SwarmEnv")


_register()
