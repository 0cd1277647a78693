"""The example that learns: a hall, a door, the shield, and robots of the bench."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "learn.py"


@pytest.mark.long
@pytest.mark.timeout(7200)
def test_a_policy_learns_and_never_touches_anything_behind_the_shield(tmp_path):
    sb3 = pytest.importorskip("stable_baselines3", reason="it comes with the extra `train`")
    done = subprocess.run(
        [sys.executable, EXAMPLE], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    figures = {
        name: (int(goals), int(contacts))
        for name, goals, contacts in re.findall(
            r"^(.+): goals (\d+)%, contacts (\d+)%$", done.stdout, re.MULTILINE
        )
    }
    assert figures["empty hall"][0] >= 90
    assert figures["door"][0] >= 60
    assert figures["door, shielded"][1] == 0
    assert re.search(r"^policy.onnx: \d+ of 40 goals, 0 collisions$", done.stdout, re.MULTILINE)
    assert "ours: 40 of 40 goals, 0 collisions" in done.stdout
    assert (tmp_path / "policy.onnx").stat().st_size <= 200_000
    assert (tmp_path / "learning.svg").exists()
    sb3.PPO.load(tmp_path / "policy.zip", device="cpu")
