"""Learns to drive through a door by the cross-entropy method: a linear policy, no library.

python examples/learn.py [ROUNDS]
"""

import sys

import numpy as np

from swarm_workbench.gym import SwarmEnv

ROUNDS = int(sys.argv[1]) if len(sys.argv) > 1 else 30
CANDIDATES, ELITE = 24, 6
random = np.random.default_rng(0)
env = SwarmEnv(robots=2, world="doorway", limit=40.0)
high = env.action_space("Srobot1").high


def features(seen):
    """Return goal, nearness of the walls in eight sectors, and the nearest neighbour."""
    distance = np.linalg.norm(seen["goal"]) + 1e-6
    near = 1.0 / (0.2 + seen["scan"].reshape(8, -1).min(axis=1))
    return np.r_[seen["goal"] / distance, min(distance, 1.0), near, seen["neighbours"][0, :3], 1.0]


def play(weights, seed):
    """Return the mean reward of an episode, and how many robots reached their goals."""
    seen, _ = env.reset(seed=seed)
    total, reached = 0.0, 0
    while env.agents:
        actions = {name: high * np.tanh(weights @ features(seen[name])) for name in env.agents}
        seen, rewards, _, _, infos = env.step(actions)
        total += sum(rewards.values())
        reached += sum(info["reached"] for info in infos.values())
    return total / 2, reached


mean, spread = np.zeros((2, 15)), np.ones((2, 15))
for round_ in range(ROUNDS):
    candidates = mean + spread * random.standard_normal((CANDIDATES, 2, 15))
    scores = [np.mean([play(each, 10 * round_ + k)[0] for k in range(4)]) for each in candidates]
    elite = candidates[np.argsort(scores)[-ELITE:]]
    mean, spread = elite.mean(axis=0), elite.std(axis=0) + 0.05
    print(f"round {round_}: mean reward {np.mean(scores):.2f}, best {max(scores):.2f}", flush=True)
print("reached", sum(play(mean, 10_000 + seed)[1] for seed in range(50)), "of 100 goals")
