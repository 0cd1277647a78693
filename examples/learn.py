"""Learns to drive by the cross-entropy method; then the policy drives at a door: learn.py [N]."""

import multiprocessing
import sys

import numpy as np
import onnx.parser
import onnxruntime

from swarm_workbench import run_scenario
from swarm_workbench.gym import TeamEnv

MODEL = """<ir_version: 8, opset_import: ["": 17]>
policy (float[N, 360] scan, float[N, 2] goal) => (float[N, 2] action)
<float[11, 2] weights = {%s}, float[2] speeds = {0.26, 1.82}, int64[3] shape = {-1, 8, 45},
 float least = {0.2}> { sectors = Reshape(scan, shape)
    gaps = ReduceMin<axes = [2], keepdims = 0>(sectors)  free = Add(gaps, least)
    near = Reciprocal(free)  distance = ReduceL2<axes = [1]>(goal)  course = Div(goal, distance)
    one = Div(distance, distance)  features = Concat<axis = 1>(course, near, one)
    wish = MatMul(features, weights)  share = Tanh(wish)  action = Mul(share, speeds) }"""


def play(weights):
    """Return a policy, and the mean reward of a robot in four episodes."""
    model = onnx.parser.parse_model(MODEL % ", ".join(f"{w:.6f}" for w in weights))
    policy, env = onnxruntime.InferenceSession(model.SerializeToString()), TeamEnv(4, limit=40.0)
    total = 0.0
    for seed in range(4):
        (seen, _), is_over = env.reset(seed=seed), False
        while not is_over:
            action = policy.run(None, {"scan": seen["scan"], "goal": seen["goal"]})[0]
            seen, reward, end, cut, _ = env.step(action)
            total, is_over = total + reward / 16.0, end or cut
    return model, total


if __name__ == "__main__":
    random, mean, spread = np.random.default_rng(0), np.zeros(22), np.ones(22)
    with multiprocessing.Pool(2) as pool:
        for number in range(int(sys.argv[1]) if len(sys.argv) > 1 else 40):
            tried = mean + spread * random.standard_normal((24, 22))
            scores = np.array([score for _, score in pool.map(play, tried)])
            best = tried[np.argsort(scores)[-6:]]
            mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
            print(f"round {number}: mean {scores.mean():.1f}, best {scores.max():.1f}", flush=True)
    onnx.save(play(mean)[0], "policy.onnx")
    for brain in ("policy.onnx", "orca", "ours"):
        run = run_scenario("doorway", robots=2, brain=brain)
        contacts = run.robot_robot + run.robot_world
        print(f"{brain}: {run.goals_reached} of {run.goals_sent} goals, {contacts} collisions")
