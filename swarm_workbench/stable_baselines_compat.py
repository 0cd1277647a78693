"""Environments for stable-baselines3, and its policies for robots; with the extra `train`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.model.errors import ConfigError, SwarmError
from swarm_workbench.gym import make_vec
from swarm_workbench.observation import FLAT, PolicyConfig
from swarm_workbench.policy import describe_policy

try:
    import torch
    from stable_baselines3.common.policies import ActorCriticPolicy
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
        """Return an attribute of the rows, which they share.

        Raises:
            AttributeError: If there is none, so that `has_attr` is true of others only.
        """
        value = getattr(self._env, attr_name)
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


class BoundedPolicy(ActorCriticPolicy):  # type: ignore[misc]
    """Policy whose mean action is from -1 to 1; unbounded means leave the range of actions.

    With full speed as a mean of 2, random actions never try out to wait.
    """

    def _get_action_dist_from_latent(self, latent: Any) -> Any:
        mean = torch.tanh(self.action_net(latent))
        return self.action_dist.proba_distribution(mean, self.log_std)


def export_policy(model: Any, path: str | Path, options: PolicyConfig) -> None:
    """Write what a trained policy does without chance as a model in ONNX, for `brain.plugin`.

    Args:
        model: Of stable-baselines3, with a `BoundedPolicy` or an "MlpPolicy".
        path: Receives the model; what was there is overwritten.
        options: `options` of an environment as it was trained in, or `get_attr("options")[0]` of
            a `SharedPolicyVecEnv`; observations are flat.

    Raises:
        SwarmError: If observations are not flat, the policy has other layers than linear ones, Tanh
            and ReLU, or the file cannot be written.
    """
    import onnx
    import onnx.parser

    policy = model.policy
    if options.observation != "flat":
        raise ConfigError(f"observation is {options.observation!r}; only 'flat' ones are exported")
    modules = [*policy.mlp_extractor.policy_net, policy.action_net]
    if isinstance(policy, BoundedPolicy):
        modules.append(torch.nn.Tanh())
    given, lines, held = FLAT, [], []
    for number, module in enumerate(modules):
        given, former = f"y{number}", given
        if isinstance(module, torch.nn.Linear):
            lines.append(f"{given} = Gemm<transB = 1>({former}, w{number}, b{number})")
            for name, values in ((f"w{number}", module.weight), (f"b{number}", module.bias)):
                held.append(onnx.numpy_helper.from_array(values.detach().cpu().numpy(), name))
        elif isinstance(module, torch.nn.Tanh | torch.nn.ReLU):
            kind = "Tanh" if isinstance(module, torch.nn.Tanh) else "Relu"
            lines.append(f"{given} = {kind}({former})")
        else:
            raise ConfigError(
                f"the policy has a layer {type(module).__name__}; only Linear, Tanh and ReLU are"
                " exported"
            )
    made = onnx.parser.parse_model(
        f'<ir_version: 8, opset_import: ["": 17]> policy (float[N, {policy.features_dim}] {FLAT})'
        f" => (float[N, {policy.action_net.out_features}] action)"
        f" {{ {chr(10).join(lines)} action = Identity({given}) }}"
    )
    made.graph.initializer.extend(held)
    try:
        onnx.save(made, str(path))
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error}") from None
    describe_policy(path, options)
