"""Drives one simulator with random commands and prints what it cost: drivers.py NAME SECONDS.

Each robot has a disc of 0.22 m, 360 rays up to 3.5 m and a scan at every step; 20 robots are in a
hall of 12 m. A function returns a callable that makes a step, and how many robots that moves. It
runs in an environment of its own, so it imports nothing of this project but in `ours`.
"""

from __future__ import annotations

import importlib.metadata
import json
import math
import os
import random
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

ROBOTS, RAYS, RANGE, RADIUS, HALF = 20, 360, 3.5, 0.22, 6.0
BATCH = 32  # worlds, where a simulator takes many at once
LEAST = 20  # steps before time is taken
Step = Callable[[], Any]


def ours() -> tuple[Step, int]:
    """`make_vec` of this project; a step lasts 0.2 s, as a turn of its LiDAR."""
    from swarm_workbench.gym import make_vec

    env = make_vec(1, "hall_12", robots=ROBOTS, ticks=2, autoreset="same_step")
    env.reset(seed=0)
    env.action_space.seed(0)
    return lambda: env.step(env.action_space.sample()), ROBOTS


def navground() -> tuple[Step, int]:
    """World of navground; its robots get random commands."""
    from navground import core, sim

    world, sensors = sim.World(), []
    corners = [(-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF)]
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        world.add_wall(sim.Wall(start, end))
    for row in range(ROBOTS):
        kinematics = core.kinematics.TwoWheelsDifferentialDriveKinematics(0.26, 0.28)
        agent = sim.Agent(radius=RADIUS, kinematics=kinematics)
        agent.behavior = core.behaviors.DummyBehavior(kinematics=kinematics, radius=RADIUS)
        agent.pose = core.Pose2(_place(row), 0.0)
        world.add_agent(agent)
        lidar = sim.state_estimations.LidarStateEstimation(
            range=RANGE, start_angle=-math.pi, field_of_view=2.0 * math.pi, resolution=RAYS
        )
        seen = core.SensingState()
        lidar.prepare_state(seen)
        sensors.append((agent, lidar, seen))
    world.update_dry(0.1)  # it prepares itself

    def step() -> None:
        for agent, _, _ in sensors:
            speed, turn = random.uniform(-0.26, 0.26), random.uniform(-1.8, 1.8)
            agent.last_cmd = core.Twist2((speed, 0.0), turn, core.Frame.relative)
        world.actuate(0.1)
        for agent, lidar, seen in sensors:
            lidar.update(agent, world, seen)

    return step, ROBOTS


def vmas() -> tuple[Step, int]:
    """Scenario `navigation` of VMAS, many worlds at once; its hall has no walls."""
    import torch
    from vmas import make_env

    torch.set_num_threads(1)
    env = make_env(
        "navigation", BATCH, seed=0, n_agents=ROBOTS, n_lidar_rays=RAYS, lidar_range=RANGE,
        agent_radius=RADIUS, world_spawning_x=HALF, world_spawning_y=HALF, enforce_bounds=True,
    )  # fmt: skip
    return lambda: env.step(env.get_random_actions()), ROBOTS * BATCH


def irsim() -> tuple[Step, int]:
    """World of IR-SIM from a file, without a window."""
    import irsim as library

    corners = [[0, 0], [12, 0], [12, 12], [0, 12], [0, 0]]
    world = {
        "world": {"height": 12, "width": 12, "step_time": 0.1, "collision_mode": "unobstructed"},
        "robot": [{
            "number": ROBOTS, "kinematics": {"name": "diff"}, "vel_max": [0.26, 1.8],
            "shape": {"name": "circle", "radius": RADIUS},
            "distribution": {"name": "manual"},
            "state": [[x + HALF, y + HALF, 0.0] for x, y in map(_place, range(ROBOTS))],
            "sensors": [{
                "name": "lidar2d", "range_max": RANGE, "angle_range": 2.0 * math.pi, "number": RAYS,
            }],
        }],
        "obstacle": [{"shape": {"name": "linestring", "vertices": corners}, "state": [0, 0, 0]}],
    }  # fmt: skip
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", delete=False) as file:
        json.dump(world, file)
    try:
        env = library.make(file.name, display=False, disable_all_plot=True, log_level="ERROR")
    finally:
        os.unlink(file.name)

    def step() -> None:
        commands = [
            [[random.uniform(-0.26, 0.26)], [random.uniform(-1.8, 1.8)]] for _ in range(ROBOTS)
        ]
        env.step(commands, list(range(ROBOTS)))
        for robot in env.robot_list:
            robot.get_lidar_scan()

    return step, ROBOTS


DRIVERS: dict[str, tuple[Callable[[], tuple[Step, int]], str]] = {  # and the distribution
    "ours": (ours, ""),
    "navground": (navground, "navground"),
    "VMAS": (vmas, "vmas"),
    "IR-SIM": (irsim, "ir-sim"),
}


def _place(row: int) -> tuple[float, float]:
    return 2.2 * (row % 5) - 4.4, 2.6 * (row // 5) - 3.9


def main() -> None:
    """Write version and robot-steps per second of CPU time."""
    name, seconds = sys.argv[1], float(sys.argv[2])
    make, package = DRIVERS[name]
    random.seed(0)
    step, robots = make()
    for _ in range(LEAST):
        step()
    count, start = 0, time.process_time()
    while (used := time.process_time() - start) < seconds:
        step()
        count += 1
    version = importlib.metadata.version(package) if package else ""
    sys.stdout.write(json.dumps({"version": version, "rate": count * robots / used}) + "\n")


if __name__ == "__main__":
    main()
