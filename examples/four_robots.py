"""Four robots drive to stations, each in a process of its own; then their paths are drawn.

python examples/four_robots.py [--bench]     with --bench all is in this process, without ROS
"""

import sys

from swarm_workbench import Swarm

STATIONS = ("loader_1", "loader_2", "loader_3", "unload")

with Swarm(robots=4, world="slim_blockage", seed=3, bench="--bench" in sys.argv) as swarm:
    goals = [robot.go_to(station) for robot, station in zip(swarm, STATIONS, strict=True)]
    for goal in goals:
        print(goal.robot, goal.wait())
    print(f"t = {swarm.time:.1f} s, {swarm.report.collisions} collisions")
    swarm.plot().figure.savefig("four_robots.png", dpi=80)
