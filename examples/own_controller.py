"""A controller of your own, against the built-in one and ORCA, in the same runs.

python examples/own_controller.py [SEEDS]
"""

import math
import sys
from pathlib import Path
from typing import Any

from swarm_nav.interfaces import DriveLimits, PathAhead, Pose, Twist
from swarm_workbench import run_scenario

SEEDS = int(sys.argv[1]) if len(sys.argv) > 1 else 3


class Pursuit:
    """Turns towards the path half a metre ahead; drives while it looks that way."""

    def __init__(self, spec: Any) -> None:
        self.gain = 2.0

    def follow(self, path: PathAhead, pose_map: Pose, twist: Twist, limits: DriveLimits) -> Twist:
        x, y = path.points_map[:5][-1]
        turn = math.remainder(math.atan2(y - pose_map.y, x - pose_map.x) - pose_map.yaw, math.tau)
        return Twist(path.top_speed if abs(turn) < 0.5 else 0.0, 0.0, self.gain * turn)


if __name__ == "__main__":
    sys.path.append(str(Path(__file__).parent))
    own = {"controller.plugin": "own_controller:Pursuit"}
    for name, brain, parameters in (
        ("own", "ours", own),
        ("dwb", "ours", {}),
        ("orca", "orca", {}),
    ):
        case = {"robots": 8, "brain": brain, "parameters": parameters}
        runs = [run_scenario("circle", seed=seed, **case) for seed in range(SEEDS)]
        contacts = sum(run.robot_robot + run.robot_world for run in runs)
        print(f"{name}: {contacts} collisions, makespans {[run.makespan for run in runs]} s")
