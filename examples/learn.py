"""Learns to drive through a door by the cross-entropy method: learn.py [ROUNDS]."""

import sys

import numpy as np

from swarm_workbench.gym import SwarmEnv

ROUNDS = int(sys.argv[1]) if len(sys.argv) > 1 else 30
random = np.random.default_rng(0)
env = SwarmEnv(robots=2, world="doorway", limit=40.0)
high = env.action_space("Srobot1").high


def features(seen):
    """Return goal, nearness of the walls in eight sectors, and the nearest neighbour."""
    goal, distance = seen["goal"], np.linalg.norm(seen["goal"]) + 1e-6
    near = 1.0 / (0.2 + seen["scan"].reshape(8, -1).min(axis=1))
    return np.r_[goal / distance, min(distance, 1.0), near, seen["neighbours"][0, :3], 1.0]


def play(weights, seed):
    """Return the reward of an episode, and how many robots reached their goals."""
    (seen, _), total, reached = env.reset(seed=seed), 0.0, 0
    while env.agents:
        actions = {name: high * np.tanh(weights @ features(seen[name])) for name in env.agents}
        seen, rewards, _, _, infos = env.step(actions)
        total += sum(rewards.values())
        reached += sum(info["reached"] for info in infos.values())
    return total, reached


mean, spread = np.zeros((2, 15)), np.ones((2, 15))
for number in range(ROUNDS):
    tried = mean + spread * random.standard_normal((24, 2, 15))
    scores = [np.mean([play(each, 10 * number + k)[0] for k in range(4)]) for each in tried]
    best = tried[np.argsort(scores)[-6:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
    print(f"round {number}: mean {np.mean(scores):.1f}, best {max(scores):.1f}", flush=True)
print("reached", sum(play(mean, 10_000 + seed)[1] for seed in range(20)), "of 40 goals")
