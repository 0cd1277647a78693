"""A rule of your own: the robot with the highest number goes first.

python examples/own_rule.py
"""

import sys
from pathlib import Path
from typing import Any

from swarm_nav.interfaces import RankedGoal
from swarm_workbench import run_scenario


class HighestNumber:
    """Ranks robots by their number, as long as both drive."""

    def __init__(self, spec: Any) -> None:
        pass

    def seniority(self, task: RankedGoal) -> int:
        return task.robot_id


if __name__ == "__main__":
    sys.path.append(str(Path(__file__).parent))
    for name, parameters in (
        ("built in", {}),
        ("highest number", {"traffic.priority_plugin": "own_rule:HighestNumber"}),
    ):
        run = run_scenario("doorway", robots=8, seed=1, parameters=parameters)
        contacts = run.robot_robot + run.robot_world
        print(f"{name}: {run.makespan} s, {run.pushes} pushes, {contacts} collisions")
