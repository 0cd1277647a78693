"""Teaches one policy to all robots by PPO, with the extra `train`."""

import argparse
import resource

import numpy as np
import torch
from matplotlib import pyplot
from stable_baselines3 import PPO

from swarm_workbench import run_scenario
from swarm_workbench.gym import TeamEnv
from swarm_workbench.stable_baselines_compat import (
    BoundedPolicy,
    SharedPolicyVecEnv,
    export_policy,
)

SEES = {"observation": "flat", "normalise": True, "rays": 36, "neighbours": 2, "ticks": 4,
        "parts": ("scan", "goal", "way", "twist", "neighbours", "precedence")}  # fmt: skip
REWARD = {"progress": 0.0, "way": 1.0, "goal": 5.0, "contact": 5.0, "time": 0.05, "closeness": 0.5}
SEEDS = range(1000, 1020)  # of episodes that were not trained with


def nearby(number, random):
    """Send each robot to a goal that is further away from episode to episode."""
    return {"distance": 2.0 + number / 50}


def across(number, random):
    """Send each of two robots into the other room."""

    def places(sides):
        return np.column_stack((sides * random.uniform(1.0, 5.4, 2), random.uniform(-2.4, 2.4, 2)))

    sides = np.array([-1.0, 1.0])
    starts = np.column_stack((places(sides), random.uniform(-3.1, 3.1, 2)))
    return {"starts": starts, "goals": places(-sides)}


def minutes():
    return sum(resource.getrusage(resource.RUSAGE_SELF)[:2]) / 60.0


def train(budget):
    """Return a trained model, and rows of CPU minutes, shares of goals and of contacts.

    Each round overwrites policy.onnx, for robots, and policy.zip, for `PPO.load`.
    """
    model, curve, start = None, [], minutes()
    options = TeamEnv(2, **SEES).options
    stages = (("hall_12", 8, 4, nearby, 0.1), ("doorway", 2, 16, across, 1.0))
    for world, robots, worlds, curriculum, end in stages:
        env = SharedPolicyVecEnv(
            worlds, world, robots=robots, reward=REWARD, curriculum=curriculum, **SEES
        )
        model = model or PPO(
            BoundedPolicy, env, n_steps=128, batch_size=512, n_epochs=10, gamma=0.99, seed=0,
            learning_rate=4e-4, device="cpu",
            policy_kwargs={"log_std_init": -0.5, "net_arch": [128, 128]},
        )  # fmt: skip
        model.set_env(env)
        while minutes() - start < end * budget:
            env.forget()
            model.learn(512 * env.num_envs, reset_num_timesteps=False)
            curve.append((minutes() - start, *np.mean(env.ended, axis=0)))
            shares = "goals {:.0%}, contacts {:.0%}".format(*curve[-1][1:])
            print(f"{world} minute {curve[-1][0]:.1f}: {shares}", flush=True)
            export_policy(model, "policy.onnx", options)
            model.save("policy.zip")
    return model, np.array(curve)


def draw(curve):
    """Draw the curve in colours that stand out from white and from black."""
    pyplot.figure(figsize=(7.0, 2.8))
    for column, name, colour in ((1, "goals", "#0a7bc4"), (2, "contacts", "#c26a00")):
        pyplot.plot(curve[:, 0], curve[:, column], color=colour, label=name)
    pyplot.xlabel("CPU minutes")
    pyplot.ylabel("share of episodes")
    pyplot.legend(labelcolor="#767676", frameon=False)
    pyplot.tick_params(colors="#767676")
    for axis in (pyplot.gca().xaxis, pyplot.gca().yaxis):
        axis.label.set_color("#767676")
    pyplot.savefig("learning.svg", transparent=True, bbox_inches="tight")


def judge(model, robots, world, curriculum=None, shield=False):
    """Return the shares of goals and of contacts."""
    env = TeamEnv(robots, world, curriculum=curriculum, shield=shield, limit=120.0, **SEES)
    found = np.zeros(2)
    for seed in SEEDS:
        (seen, _), is_over = env.reset(seed=seed), False
        while not is_over:
            seen, _, end, cut, info = env.step(model.predict(seen, deterministic=True)[0])
            found += info["reached"].sum(), info["contact"].sum()
            is_over = end or cut
    return "goals {:.0%}, contacts {:.0%}".format(*found / (len(SEEDS) * robots))


if __name__ == "__main__":
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("cpu_minutes", nargs="?", type=float, default=13.0)
    budget = arguments.parse_args().cpu_minutes
    if not 0.0 < budget < np.inf:
        arguments.error(f"cpu_minutes is {budget}; expected a number above 0")
    torch.set_num_threads(1)
    model, curve = train(budget)
    draw(curve)
    print("empty hall:", judge(model, 1, "hall_12"))
    print("door:", judge(model, 2, "doorway", across))
    print("door, shielded:", judge(model, 2, "doorway", across, shield=True))
    for brain in ("policy.onnx", "orca", "ours"):
        runs = [
            run_scenario("doorway", robots=2, brain=brain, seed=seed, lidar=True) for seed in SEEDS
        ]
        reached, sent, touched = (
            sum(getattr(run, name) for run in runs)
            for name in ("goals_reached", "goals_sent", "robot_robot")
        )
        print(f"{brain}: {reached} of {sent} goals, {touched} collisions")
