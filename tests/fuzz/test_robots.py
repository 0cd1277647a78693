"""Mutated robots and fleets: each loads, or is refused with a SwarmError. Never anything else.

A few of each run always; many with `FUZZ_EXAMPLES=10000 pytest tests/fuzz --timeout=0`.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from swarm_common.files.resources import share_directory
from swarm_common.model.errors import SwarmError
from swarm_common.model.outline import placed_corners
from swarm_common.model.records import Pose, Twist, wrap_angle
from swarm_common.model.shapes import Part
from swarm_describe.robots.fleet import load_fleet
from swarm_describe.robots.loading import open_robot
from swarm_describe.worlds.scene import Scene
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.posts import off_the_posts, points_by_tf, post
from tests.fakes.robots import LIMITS, SIZES, URDF, WHEEL, XACRO, write_packages
from tests.fuzz.mutation import mutated
from tests.fuzz.robot_generator import robots

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "0"))
FEW, MANY = 25, 60  # examples of slow and of fast inputs, unless told otherwise
FULL = (share_directory() / "robots/turtlebot3_waffle/robot.yaml").read_text(encoding="utf-8")
PARTLY = LIMITS + (
    "description: acme.urdf\nmodel: own\npackages: ['..']\nxacro_args: {a: 1}\n"
    "wheels: {left: [left_wheel_joint], right: [right_wheel_joint]}\n"
    "lidar: {frame: lidar_link, rays: 90, rate: 5.0, yaw: 0.1}\n"
    "footprint: [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]\n"
)
FLEET = """order: mixed
groups:
  - {model: turtlebot3_burger, count: 3, limits: {max_vel_x: 0.2}, mission: loading_route}
  - model: turtlebot3_waffle
    count: 2
    start: {x_min: 0.0, y_min: 0.0, x_max: 4.0, y_max: 4.0, pitch: 1.0, yaw: 0.5}
"""


def of(usual):
    return settings(
        max_examples=EXAMPLES or usual,
        deadline=None,
        derandomize=not EXAMPLES,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    return write_packages(tmp_path_factory.mktemp("workspace"))


def try_robot(path):
    try:
        robot = open_robot(path)
    except SwarmError:
        return
    drive(robot)


def drive(robot):
    """Let a robot that was accepted drive for a moment in either engine."""
    for engine in ("planar", "bullet"):
        try:
            world = World(
                Scene("field", Path("."), ()),
                [robot.spec],
                [Pose(0.0, 0.0, 0.0)],
                WorldConfig(engine=engine),
                models={robot.spec.model: robot.model},
            )
        except SwarmError:
            continue
        try:
            world.step([Twist(0.1, 0.1, 0.1)], [None])
            world.observe()
        finally:
            world.close()


def put(path, text):
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    return path


@of(MANY)
@given(text=mutated(URDF))
def test_urdf(packages, text):
    put(packages[0].with_name("robot.yaml"), f"description: {packages[0].name}\n" + LIMITS)
    try_robot(put(packages[0], text))


@of(FEW)
@given(text=mutated(XACRO))
def test_xacro(packages, text):
    settings_of_xacro(packages[1])
    try_robot(put(packages[1], text))


@of(FEW)
@given(text=mutated(WHEEL, SIZES))
def test_included_xacro(packages, text):
    settings_of_xacro(packages[1])
    put(packages[1], XACRO)
    folder = packages[1].parents[3] / "vendor" / "acme_parts" / "urdf"
    name = "wheel.xacro" if "acme_wheel" in text or "macro" in text else "sizes.xacro"
    try:
        put(folder / name, text)
        try_robot(packages[1])
    finally:
        put(folder / "wheel.xacro", WHEEL)
        put(folder / "sizes.xacro", SIZES)


@of(MANY)
@given(text=mutated(FULL, PARTLY))
def test_robot_yaml(packages, text):
    put(packages[0], URDF)
    try_robot(put(packages[0].with_name("robot.yaml"), text))


@of(MANY)
@given(text=mutated(FLEET))
def test_fleet(packages, text):
    path = put(packages[0].with_name("fleet.yaml"), text)
    try:
        fleet = load_fleet(path)
    except SwarmError:
        return
    assert all(member.limits_in_force for member in fleet.members)


@of(MANY)
@given(made=robots())
def test_generated_robots_drive_and_see_or_are_refused(packages, made):
    path = made.write(packages[0].parent / "generated")
    try:
        robot = open_robot(path)
        world = stage(robot)
    except SwarmError:
        return
    try:
        body_is_in_the_footprint(robot)
        sees_what_is_there(robot, world)
        goes_where_it_is_told(robot, world)
    finally:
        world.close()


def stage(robot):
    """Put a robot among posts, in the physics engine."""
    return World(
        Scene("field", Path("."), POSTS),
        [robot.spec],
        [Pose(0.0, 0.0, 0.4)],
        WorldConfig(engine="bullet"),
        models={robot.spec.model: robot.model},
    )


def body_is_in_the_footprint(robot):
    places = robot.model.root_from_groups()
    parts = [
        Part(part.shape, place @ part.body_from_part)
        for group, place in zip(robot.model.groups, places, strict=True)
        for part in group.parts
    ]
    points, corners = placed_corners(parts)[:, :2], robot.spec.footprint
    for (ax, ay), (bx, by) in zip(corners, (*corners[1:], corners[0]), strict=True):
        aside = (bx - ax) * (points[:, 1] - ay) - (by - ay) * (points[:, 0] - ax)
        assert (aside / np.hypot(bx - ax, by - ay)).min() > -1e-3


def sees_what_is_there(robot, world):
    scan = world.observe()[0].scan
    assert scan is not None
    points = points_by_tf(scan, robot, world.ground_truth()[0][0])
    if robot.spec.lidar.z < 1.0:  # the posts' height
        assert not len(points) or off_the_posts(points, POSTS) < 0.1
    else:
        assert not len(points)


def goes_where_it_is_told(robot, world):
    """Two seconds of driving, compared with kinematics."""
    spec = robot.spec
    speed, rate = 0.5 * min(spec.max_vel_x, 0.8), 0.3 * min(spec.max_vel_theta, 1.0)
    start, ticks = world.ground_truth()[0][0], 20
    for _ in range(ticks):
        world.step([Twist(speed, 0.0, rate)], [None])
    for _ in range(15):
        world.step([Twist()], [None])
    pose = world.ground_truth()[0][0]
    turned = wrap_angle(pose.yaw - start.yaw)
    assert abs(turned - 0.1 * ticks * rate) < 0.1
    assert abs(start.distance(pose) - 0.1 * ticks * speed) < 0.1 * speed + 0.03


POSTS = (post(3.0, 0.9), post(-2.5, 1.9), post(0.7, -3.2))


def settings_of_xacro(path):
    put(
        path.with_name("acme_big.robot.yaml"),
        LIMITS + "lidar: {frame: laser, rays: 90, rate: 5.0}\npackages: [../../../vendor]\n",
    )
