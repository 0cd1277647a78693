"""Learns weights of goal and LiDAR, which drive two robots through a door: learn.py [ROUNDS]."""

import sys

import numpy as np
import onnx.parser
import onnxruntime

from swarm_workbench import run_scenario
from swarm_workbench.gym import TeamEnv

MODEL = """<ir_version: 8, opset_import: ["": 17]>
policy (float[N, 360] scan, float[N, 2] goal) => (float[N, 2] action) <float[2, 10] table = {%s},
    float[2] most = {0.26, 1.82}, int64[3] eight = {-1, 8, 45}> { sectors = Reshape(scan, eight)
    gaps = ReduceMin<axes = [2], keepdims = 0>(sectors)  near = Reciprocal(gaps)
    far = ReduceL2<axes = [1]>(goal)  course = Div(goal, far)  seen = Concat<axis = 1>(course, near)
    wish = Gemm<transB = 1>(seen, table)  share = Tanh(wish)  action = Mul(share, most) }"""
env, random, mean, spread = TeamEnv(4, limit=40.0), np.random.default_rng(0), 0.0, np.ones(10)


def play(w):
    """Save a policy that does to the left as to the right; return its reward in 16 rides."""
    table = np.r_[w[0], 0, w[1:5], w[4:0:-1], 0, w[5:], -w[:5:-1]]
    onnx.save(onnx.parser.parse_model(MODEL % ", ".join(map(str, table))), "policy.onnx")
    policy, total = onnxruntime.InferenceSession("policy.onnx"), 0.0
    for seed in range(4):
        (seen, _), is_over = env.reset(seed=seed), False
        while not is_over:
            action = policy.run(None, {"scan": seen["scan"], "goal": seen["goal"]})[0]
            seen, reward, end, cut, _ = env.step(np.nan_to_num(action))
            total, is_over = total + reward / 16, end or cut
    return total


for number in range(int([*sys.argv, 15][1])):
    best = sorted(mean + spread * random.standard_normal((16, 10)), key=play)[-4:]
    mean, spread = np.mean(best, axis=0), np.std(best, axis=0) + 0.05
    print(f"round {number}: reward {play(mean):.1f}", flush=True)
for brain in ("policy.onnx", "orca", "ours"):
    run = run_scenario("doorway", robots=2, brain=brain)
    print(brain, f"{run.goals_reached} of {run.goals_sent} goals, {run.robot_robot} collisions")
