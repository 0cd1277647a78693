"""Tiny policies in ONNX."""

from pathlib import Path

import onnx
import onnx.parser

TO_THE_GOAL = """
<ir_version: 8, opset_import: ["": 17]>
policy (float[1, 360] scan, float[1, 2] goal, float[1, 3, 6] neighbours) => (float[1, 2] action)
<float[2, 2] gains = {2.0, 0.0, 0.0, 2.0}, float[1, 6] away = {0.002, 0.001, 0.0, 0.0, 0.0, 0.0}>
{
    wish = MatMul(goal, gains)
    nearest = ReduceMin<axes = [1]>(scan)
    slowed = Mul(wish, nearest)
    felt = Mul(neighbours, away)
    push = ReduceSum<keepdims = 0>(felt)
    action = Sub(slowed, push)
}
"""


def save_policy(path: Path, text: str = TO_THE_GOAL) -> str:
    """Write a policy that turns to the goal and slows down near walls; return its path."""
    onnx.save(onnx.parser.parse_model(text), path)
    return str(path)
