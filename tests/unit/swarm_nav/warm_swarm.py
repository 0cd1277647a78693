"""Script: prints the kernels that a swarm compiles after `warm_up`; each would stop a robot.

Also those that `warm_up` leaves out although Python calls them: what robots rarely need.
"""

import importlib
import pkgutil
import random
import re
import sys
from pathlib import Path

import swarm_common
import swarm_nav
from swarm_common.files.map_io import load_map, map_path
from swarm_common.middleware.radio_check import read_neighbors
from swarm_common.model.beacon import reception_of, serialize_neighbors
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.reader import load_world
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalKind
from swarm_nav.launch.warm_up import warm_up
from swarm_sim.maps.spawn import spawn_poses
from swarm_sim.world.world import World, WorldConfig

WORLD = "slim_blockage"
OF_THE_WORLD = "beacon_kernels.fault"  # nobody else reads single beacons
MUTE_AFTER = 150  # ticks, then the last robot falls silent


def signatures() -> dict[str, set[str]]:
    """Return the compiled signatures of every kernel."""
    found: dict[str, set[str]] = {}
    modules = [
        module
        for package in (swarm_nav, swarm_common)
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    ]
    for module in modules:
        if not module.name.endswith("_kernels"):
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            if hasattr(value, "signatures"):
                found[f"{module.name}.{name}"] = {str(item) for item in value.signatures}
    return found


def drive(count: int, ticks: int) -> None:
    """Let robots work, their messages taken from bytes as on the graph."""
    scene, spec = load_world(WORLD), load_robot("turtlebot3_waffle")
    poses = spawn_poses(scene, spec, count)
    world = World(scene, [spec] * count, poses, WorldConfig(engine="planar"))
    grid = load_map(map_path(WORLD))
    robots = [
        Navigator(NavConfig(), spec, grid, scene.sites, i + 1, pose) for i, pose in enumerate(poses)
    ]
    chooser = random.Random(count)
    stations = list(scene.sites.stations.values())
    for tick in range(ticks):
        answers = []
        for robot_id, (robot, observed) in enumerate(zip(robots, world.observe(), strict=True), 1):
            if robot.services.goal_id is None and tick % 10 == 0:
                target = chooser.choice(stations[:2])
                robot.set_goal(Goal(kind=GoalKind.NAVIGATE, goal_id=1, poses_map=(target,)))
            data = serialize_neighbors(1000, 0, observed.neighbors)
            robot.on_odom(observed.odom)
            robot.on_reception(reception_of(read_neighbors(data, robot_id)[1]))
            if observed.scan is not None:
                robot.on_scan(observed.scan)
            answers.append(robot.tick(tick))
        beacons = [answer.beacon for answer in answers]
        if tick > MUTE_AFTER and count > 2:
            beacons[-1] = None
        world.step([answer.twist for answer in answers], beacons)


def left_out(found: dict[str, set[str]]) -> set[str]:
    """Return the kernels without a signature that modules of Python call."""
    texts = [
        path.read_text("utf-8")
        for package in (swarm_nav, swarm_common)
        for path in Path(package.__path__[0]).rglob("*.py")
        if not path.stem.endswith("_kernels")
    ]
    unknown = [name.rsplit(".", 2)[1:] for name, known in found.items() if not known]
    return {
        f"{module}.{name}"
        for module, name in unknown
        if any(
            module in text and re.search(rf"((?<![\w.])|kernels\.){name}\(", text) for text in texts
        )
    }


def main() -> None:
    """Print what was compiled too late, one kernel per line."""
    warm_up()
    before = signatures()
    for name in sorted(left_out(before) - {OF_THE_WORLD}):
        sys.stdout.write(f"{name} is left out\n")
    for count in (1, 2, 5):
        drive(count, 300)
    for name, found in signatures().items():
        if found - before.get(name, set()):
            sys.stdout.write(f"{name}: {len(found)} signatures, {len(before[name])} warmed\n")


if __name__ == "__main__":
    main()
