"""Draw the picture of the README: a swarm at work, from a real run of world and navigators.

Usage: python tools/picture.py [SECONDS] [FILE]    (150 simulated seconds, docs/factory_hall.png)
"""

from __future__ import annotations

import random
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from swarm_common.files.map_io import load_map, map_path
from swarm_common.model.grid import OCCUPIED, UNKNOWN, Grid
from swarm_common.model.palette import STATES, YELLOW, css
from swarm_common.model.records import Pose
from swarm_common.robots.loading import load_robot
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind
from swarm_sim.maps.spawn import spawn_poses
from swarm_sim.sdf.reader import load_world
from swarm_sim.world.world import World, WorldConfig

ROBOTS = 20
SCALE = 120  # [px/m] before the picture is halved
COLORS = {
    state: css(STATES[state]) for state in ("driving", "waiting", "holding", "yielding", "idle")
}


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
    _photograph(world, robots, grid).save(file)
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


class Sheet:
    """A drawing in map coordinates, drawn large and shrunk for smooth lines."""

    def __init__(self, grid: Grid) -> None:
        """Start with the map: walls dark, unreachable places grey."""
        self._grid = grid
        shades = np.full(grid.cells.shape, 255, np.uint8)
        shades[grid.cells == UNKNOWN] = 205
        shades[grid.cells == OCCUPIED] = 60
        size = tuple(round(n * grid.resolution * SCALE) for n in grid.cells.shape[::-1])
        image = Image.fromarray(shades[::-1]).resize(size, Image.Resampling.NEAREST)
        self.image = image.convert("RGB")
        self._draw = ImageDraw.Draw(self.image)

    def line(self, points: np.ndarray, color: str, width: float) -> None:
        """Draw a polyline (n, 2); width in metres."""
        if len(points) > 1:
            pixels = [self._pixel(x, y) for x, y in points]
            self._draw.line(pixels, color, max(1, round(width * SCALE)), joint="curve")

    def polygon(self, points: np.ndarray, color: str) -> None:
        """Fill a polygon (n, 2)."""
        self._draw.polygon([self._pixel(x, y) for x, y in points], color, "black", width=3)

    def text(self, x: float, y: float, text: str, color: str, size: float) -> None:
        """Write centred text; size in metres."""
        font = ImageFont.load_default(round(size * SCALE))
        self._draw.text(self._pixel(x, y), text, color, font, anchor="mm")

    def _pixel(self, x: float, y: float) -> tuple[float, float]:
        grid = self._grid
        return (
            (x - grid.origin_x) * SCALE,
            (grid.origin_y + grid.height * grid.resolution - y) * SCALE,
        )


def _photograph(world: World, robots: list[Navigator], grid: Grid) -> Image.Image:
    """Draw stations, plans, held tubes, and the robots where physics says that they are."""
    sheet = Sheet(grid)
    for name, pose in robots[0].sites.stations.items():
        corners = np.array(((0.0, 0.22), (0.22, 0.0), (0.0, -0.22), (-0.22, 0.0)))
        sheet.polygon(corners + np.array((pose.x, pose.y)), css(YELLOW))
        sheet.text(pose.x + 0.75, pose.y + 0.28, name, "#555555", 0.26)
    colors = [COLORS.get(robot.status().state, COLORS["driving"]) for robot in robots]
    for robot, color in zip(robots, colors, strict=True):
        sheet.line(robot.plan_map(), color, 0.03)
        sheet.line(robot._s.tube.points[robot._s.tube.near : robot._s.tube.stop + 1], color, 0.12)
    for robot, color, (pose, _) in zip(robots, colors, world.ground_truth(), strict=True):
        turn = np.array(
            ((np.cos(pose.yaw), -np.sin(pose.yaw)), (np.sin(pose.yaw), np.cos(pose.yaw)))
        )
        sheet.polygon(np.array(robot.spec.footprint) @ turn.T + (pose.x, pose.y), color)
        nose = np.array(((0.0, 0.0), (0.2, 0.0))) @ turn.T + (pose.x, pose.y)
        sheet.line(nose, "black", 0.04)
    for row, (state, color) in enumerate(COLORS.items()):
        sheet.text(0.2 + 1.9 * row, 8.8, state, color, 0.34)
    return sheet.image.reduce(2)


if __name__ == "__main__":
    main()
