"""Draw the picture of the README: a swarm at work, from a real run of world and navigators.

Usage: python tools/picture.py [SECONDS] [FILE]    (150 simulated seconds, docs/factory_hall.png)
"""

from __future__ import annotations

import random
import sys
from pathlib import Path

import numpy as np
import pybullet
from PIL import Image

from swarm_common.map_io import load_map, map_path
from swarm_common.records import Pose
from swarm_common.robot_io import load_robot
from swarm_nav.config import NavConfig
from swarm_nav.goals import Goal, GoalEnded, GoalKind
from swarm_nav.navigator import Navigator
from swarm_sim.sdf import load_world
from swarm_sim.spawn import spawn_poses
from swarm_sim.world import World, WorldConfig

ROBOTS = 20
SIZE = (1280, 800)  # [px]
EYE, TARGET = (-12.5, -12.5, 13.0), (-1.5, 1.8, 0.0)  # [m]


def main() -> None:
    """Run the swarm for a while and take the picture."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 150.0
    file = Path(sys.argv[2] if len(sys.argv) > 2 else "docs/factory_hall.png")
    scene, spec = load_world("slim_blockage"), load_robot("turtlebot3_waffle")
    homes = spawn_poses(scene, spec, ROBOTS)
    world = World(scene, [spec] * ROBOTS, homes, WorldConfig(engine="bullet"), seed=0)
    grid = load_map(map_path(scene.name))
    robots = [
        Navigator(NavConfig(), spec, grid, scene.sites, index + 1, home)
        for index, home in enumerate(homes)
    ]
    routes = [_route(scene.sites.stations, index) for index in range(ROBOTS)]
    for robot, route in zip(robots, routes, strict=True):
        robot.set_goal(_goal(route.pop()))
    while world.sim_time < seconds:
        _step(world, robots, routes)
    file.parent.mkdir(exist_ok=True)
    Image.fromarray(_photograph(world)).save(file)
    print(f"{file}: {ROBOTS} robots after {seconds:.0f} s, collisions {len(world.collisions)}")
    world.close()


def _route(stations: dict[str, Pose], index: int) -> list[Pose]:
    route = [pose for name, pose in stations.items() if name.startswith("loader")]
    random.Random(index).shuffle(route)
    return [stations["shipping"], *route]


def _goal(pose: Pose) -> Goal:
    return Goal(kind=GoalKind.NAVIGATE, poses_map=(pose,))


def _step(world: World, robots: list[Navigator], routes: list[list[Pose]]) -> None:
    twists, beacons = [], []
    for robot, route, seen in zip(robots, routes, world.observe(), strict=True):
        robot.on_odom(seen.odom)
        robot.on_neighbors(seen.neighbors)
        if seen.scan is not None:
            robot.on_scan(seen.scan)
        output = robot.tick(world.tick)
        twists.append(output.twist)
        beacons.append(output.beacon)
        if route and any(isinstance(event, GoalEnded) for event in output.events):
            robot.set_goal(_goal(route.pop()))
    world.step(twists, beacons)


def _photograph(world: World) -> np.ndarray:
    width, height = SIZE
    view = pybullet.computeViewMatrix(EYE, TARGET, (0.0, 0.0, 1.0))
    lens = pybullet.computeProjectionMatrixFOV(52.0, width / height, 0.5, 60.0)
    _, _, pixels, _, _ = pybullet.getCameraImage(
        width,
        height,
        view,
        lens,
        lightDirection=(-6.0, -8.0, 20.0),
        shadow=1,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=world._engine._client,
    )
    return np.asarray(pixels, np.uint8).reshape(height, width, 4)[:, :, :3]


if __name__ == "__main__":
    main()
