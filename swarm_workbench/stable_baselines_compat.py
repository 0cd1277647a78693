"""Vector environments for stable-baselines3, with the extra `train`."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarm_common.model.errors import ConfigError, SwarmError
from swarm_workbench.gym import make_vec

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise SwarmError(
        f"{error.name} is missing, which the trainer needs: pip install 'swarm-workbench[train]'"
    ) from None


class SharedPolicyVecEnv(VecEnv):  # type: ignore[misc]
    """Many worlds in which one policy drives all robots; the arguments are those of `make_vec`.

    Attributes:
        ended: What became of the episodes that ended since `forget`: pairs of whether the robot
            reached its goal, and whether it touched something.
    """

    def __init__(self, n: int, world: str = "doorway", **options: Any) -> None:
        """Make the worlds.

        Raises:
            SwarmError: If an option is unknown or makes no sense.
        """
        if "autoreset" in options:
            raise ConfigError("stable-baselines3 wants autoreset in the same step; leave it out")
        self._env = make_vec(n, world, autoreset="same_step", **options)
        self.ended: list[tuple[bool, bool]] = []
        self._actions: Any = None
        super().__init__(
            self._env.num_envs, self._env.single_observation_space, self._env.single_action_space
        )

    def forget(self) -> None:
        """Begin anew with what became of episodes."""
        self.ended = []

    def reset(self) -> Any:
        """Begin anew in all worlds."""
        seed = self._seeds[0]
        observations, _ = self._env.reset(seed=seed)
        self._reset_seeds()
        return observations

    def step_async(self, actions: Any) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Drive for a step."""
        observations, rewards, ends, cuts, found = self._env.step(self._actions)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for row in np.flatnonzero(ends | cuts).tolist():
            infos[row] = {
                "terminal_observation": found["final_obs"][row],
                "TimeLimit.truncated": bool(cuts[row]),
            }
            self.ended.append((bool(found["reached"][row]), bool(found["contact"][row])))
        return observations, rewards.astype(np.float32), ends | cuts, infos

    def close(self) -> None:
        """End the processes."""
        self._env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the rows, which they share."""
        value = getattr(self._env, attr_name, None)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: rows have no attributes of their own."""
        raise ConfigError(f"{attr_name} is fixed; make another environment")

    def env_method(
        self, method_name: str, *arguments: Any, indices: Any = None, **options: Any
    ) -> list[Any]:
        """Refuse: rows have no methods of their own."""
        raise ConfigError(f"the rows have no {method_name}()")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        """Return that no row is wrapped."""
        return [False for _ in self._get_indices(indices)]
