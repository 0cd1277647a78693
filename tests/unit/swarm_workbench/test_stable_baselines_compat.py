"""Worlds and policies of stable-baselines3; they come with the extra `train`."""

import numpy as np
import pytest

from swarm_common.model.errors import SwarmError
from swarm_workbench import load_robot
from swarm_workbench.gym import TeamEnv
from swarm_workbench.policy import Policy

PPO = pytest.importorskip("stable_baselines3", reason="it comes with the extra `train`").PPO
compat = pytest.importorskip("swarm_workbench.stable_baselines_compat")
SEES = {"observation": "flat", "normalise": True, "rays": 12, "neighbours": 1}
SMALL = {"n_steps": 32, "batch_size": 32, "n_epochs": 1, "device": "cpu", "seed": 0}


@pytest.mark.parametrize("kind", ["bounded", "MlpPolicy"])
def test_an_exported_policy_does_what_the_trained_one_does(tmp_path, kind):
    env = compat.SharedPolicyVecEnv(2, "doorway", robots=2, limit=2.0, **SEES)
    model = PPO(compat.BoundedPolicy if kind == "bounded" else kind, env, **SMALL)
    model.learn(64)
    team = TeamEnv(2, "doorway", **SEES)
    path = tmp_path / "policy.onnx"
    compat.export_policy(model, path, team.options)
    exported = Policy(str(path), load_robot("turtlebot3_waffle"))
    assert exported.config.rays == 12
    seen, _ = team.reset(seed=1)
    wanted = model.predict(seen, deterministic=True)[0]
    (found,) = exported._model.run(None, {"observation": seen})
    assert np.clip(found, -1.0, 1.0) == pytest.approx(wanted, abs=1e-5)


def test_what_cannot_be_exported_is_named(tmp_path):
    nn = pytest.importorskip("torch").nn
    env = compat.SharedPolicyVecEnv(1, "doorway", **SEES)
    model = PPO("MlpPolicy", env, **SMALL)
    options, unnamed = TeamEnv(1, **SEES).options, TeamEnv(1).options
    with pytest.raises(SwarmError, match="observation is 'dict'; only 'flat' ones are exported"):
        compat.export_policy(model, tmp_path / "a", unnamed)
    with pytest.raises(SwarmError, match="cannot be written"):
        compat.export_policy(model, tmp_path / "no" / "a", options)
    model = PPO("MlpPolicy", env, policy_kwargs={"activation_fn": nn.ELU}, **SMALL)
    with pytest.raises(SwarmError, match="the policy has a layer ELU; only Linear, Tanh and ReLU"):
        compat.export_policy(model, tmp_path / "a", options)


def test_rows_have_the_attributes_of_their_environment_and_no_others():
    env = compat.SharedPolicyVecEnv(2, "doorway", robots=2, **SEES)
    assert env.get_attr("options")[3] == TeamEnv(2, **SEES).options
    assert not env.has_attr("no_such")
