"""Which ray sensor is the LiDAR, how it is mounted, and that its scans say so."""

import math
from pathlib import Path

import numpy as np
import pytest

from swarm_common.model.errors import RobotModelError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, Twist
from swarm_common.model.sites import Sites
from swarm_describe.robots.description import parse_urdf
from swarm_describe.robots.loading import open_robot
from swarm_describe.worlds.scene import Scene
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.own_robots import (
    CHASSIS,
    LIMITS,
    PI,
    Own,
    caster,
    lidar,
    link,
    pair,
    ray_sensor,
    robot,
)  # fmt: skip
from tests.fakes.posts import off_the_posts, points_by_tf, post

DOWN = f"0 {PI / 2} 0"
CLIFF = lidar("cliff", (0.2, 0.0, 0.05), DOWN, rays=1, far=0.2, first=0.0, last=0.0)
FAN = lidar("cliff_fan", (0.2, 0.0, 0.05), DOWN, rays=720, far=20.0)
FINDER = lidar("range", (0.2, 0.0, 0.1), rays=5, far=4.0, first=-0.1, last=0.1)
CLOUD = lidar("velodyne", (0.0, 0.0, 0.5), rays=1800, far=100.0, layers=16)


def made_of(*sensors, settings=LIMITS):
    return Own(robot("own", [CHASSIS, *pair(), caster("caster", -0.15), *sensors]), settings)


def opened(folder, *sensors, settings=LIMITS):
    return open_robot(made_of(*sensors, settings=settings).write(folder))


def test_cliff_sensors_and_range_finders_are_no_lidars(tmp_path):
    made = opened(tmp_path, CLIFF, FINDER, FAN, CLOUD, lidar("laser", (0.1, 0.0, 0.2)))
    assert (made.spec.lidar.frame, made.spec.lidar.rays) == ("laser", 360)
    (note,) = [note for note in made.model.notes if "is the LiDAR" in note]
    assert note == (
        "laser (360 rays, 8 m) is the LiDAR, not cliff (1 rays, 0.2 m): 1 rays within 0 degrees, "
        "range (5 rays, 4 m): 5 rays within 11 degrees, cliff_fan (720 rays, 20 m): tilted by 90 "
        "degrees, velodyne (1800 rays, 100 m): 16 layers of rays; lidar: {frame: ...} in "
        "robot.yaml chooses another"
    )


def test_more_rays_times_range_win_then_level_then_high(tmp_path):
    near = lidar("near", (0.1, 0.0, 0.3), rays=360, far=4.0)
    far = lidar("far", (0.1, 0.0, 0.2), rays=360, far=8.0)
    assert opened(tmp_path, near, far).spec.lidar.frame == "far"
    leaning = lidar("leaning", (0.1, 0.0, 0.3), "0.05 0 0")
    assert opened(tmp_path, leaning, far).spec.lidar.frame == "far"
    high = lidar("high", (0.1, 0.0, 0.4))
    assert opened(tmp_path, far, high).spec.lidar.frame == "high"
    chosen = opened(tmp_path, far, high, settings=LIMITS + "lidar: {frame: far}\n")
    assert chosen.spec.lidar.z == pytest.approx(0.2)


def test_no_lidar_or_one_on_the_ground_is_refused_with_the_cure(tmp_path):
    with pytest.raises(RobotModelError) as caught:
        opened(tmp_path, CLIFF, FINDER)
    assert "cliff (1 rays within 0 degrees), range (5 rays" in str(caught.value)
    low = lidar(xyz=(0.1, 0.0, 0.0))
    with pytest.raises(RobotModelError, match=r"lidar\.z is 0.0; expected .m. of the scan plane"):
        opened(tmp_path, low)
    assert opened(tmp_path, low, settings=LIMITS + "lidar: {z: 0.2}\n").spec.lidar.z == 0.2


@pytest.mark.parametrize("rpy", ["0.8 0 0", "0 1.2 0"])
def test_the_cure_that_a_tilted_one_is_told_cures_it(rpy, tmp_path):
    with pytest.raises(RobotModelError, match=r"is tilted by .* lidar: \{x: \.\.\., y: "):
        opened(tmp_path, lidar(rpy=rpy))
    cure = "lidar: {x: 0.1, y: 0.0, z: 0.25, yaw: 0.5}\n"
    spec = opened(tmp_path, lidar(rpy=rpy), settings=LIMITS + cure).spec
    assert (spec.lidar.z, spec.lidar.yaw, spec.lidar.rays) == (0.25, 0.5, 360)


MOUNTS = {
    "upright": ((0.1, 0.02, 0.2), "0 0 0"),
    "upright, turned": ((0.1, 0.0, 0.2), "0 0 2.5"),
    "rolled": ((0.1, 0.02, 0.2), f"{PI} 0 0"),
    "rolled, turned": ((0.1, 0.0, 0.2), f"{PI} 0 1.0"),
    "pitched over": ((0.1, 0.0, 0.2), f"0 {PI} 0.4"),
}


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize(("first", "last"), [(-PI, PI), (-1.2, 2.0)])
@pytest.mark.parametrize("ray_time", [False, True])
def test_a_scan_shows_where_things_are_however_the_lidar_hangs(
    mount, first, last, ray_time, tmp_path
):
    xyz, rpy = MOUNTS[mount]
    made = opened(tmp_path, lidar(xyz=xyz, rpy=rpy, first=first, last=last, rays=721))
    posts = (post(2.0, 0.5), post(-1.0, 1.5), post(0.3, -2.2))  # on no axis of symmetry
    world = World(
        Scene("field", Path("."), posts),
        [made.spec],
        [Pose(0.2, -0.1, 0.3)],
        WorldConfig(engine="planar", sensors={"lidar": {"ray_time": ray_time}}),
        models={made.spec.model: made.model},
    )
    for _ in range(3):
        world.step([Twist()], [None])
    scan = world.observe()[0].scan
    pose = world.ground_truth()[0][0]
    world.close()
    through_tf = points_by_tf(scan, made, pose)
    assert len(through_tf) > 5
    assert off_the_posts(through_tf, posts) < 0.05
    seen = scan.from_above(made.spec.lidar)
    mount_pose = pose.compose(Pose(made.spec.lidar.x, made.spec.lidar.y, made.spec.lidar.yaw))
    angles = mount_pose.yaw + seen.angle_min + seen.angle_increment * np.arange(len(seen.ranges))
    hits = np.isfinite(seen.ranges)
    ends = np.column_stack([np.cos(angles), np.sin(angles)])[hits] * seen.ranges[hits, None]
    ends += [mount_pose.x, mount_pose.y]
    np.testing.assert_allclose(np.sort(ends, axis=0), np.sort(through_tf, axis=0), atol=1e-4)


def test_scans_have_a_frame_in_every_description(tmp_path):
    other = link("base_scan") + ray_sensor("base_link", pose="0 0 0.3 0 0 1")
    for sensors in ((lidar("sick"),), (lidar("sick", rpy=f"{PI} 0 0"),), (other,)):
        text = [*sensors]
        if sensors[0] is other:  # a link of that name that is elsewhere
            text.append(
                '<joint name="base_scan_joint" type="fixed"><parent link="base_link"/>'
                '<child link="base_scan"/><origin xyz="1 0 0"/></joint>'
            )
        made = opened(tmp_path, *text)
        place = parse_urdf(made.urdf, "").fixed["base_scan"]
        seen = made.spec.lidar
        np.testing.assert_allclose(place[:3, 3], [seen.x, seen.y, seen.z], atol=1e-6)
        assert math.atan2(place[1, 0], place[0, 0]) == pytest.approx(seen.yaw, abs=1e-6)
        assert (place[2, 2] < 0.0) == seen.upside_down


@pytest.mark.parametrize("rpy", ["0 0 0", f"{PI} 0 0.7"])
def test_the_navigator_marks_what_is_there(rpy, tmp_path):
    made = opened(tmp_path, lidar(rpy=rpy))
    posts = (post(1.0, 0.7),)
    grid = Grid(np.zeros((160, 160), np.int8), 0.05, -4.0, -4.0)
    world = World(
        Scene("field", Path("."), posts),
        [made.spec],
        [Pose(0.0, 0.0, 0.0)],
        WorldConfig(engine="planar"),
        models={made.spec.model: made.model},
    )
    navigator = Navigator(NavConfig(), made.spec, grid, Sites(), 1, Pose(0.0, 0.0, 0.0))
    navigator.services.activate()
    for tick in range(30):
        seen = world.observe()[0]
        navigator.on_odom(seen.odom)
        if seen.scan is not None:
            navigator.on_scan(seen.scan)
        navigator.tick(tick)
        world.step([Twist()], [None])
    world.close()
    marks = navigator._s.obstacles.points
    assert len(marks) > 3
    assert off_the_posts(marks, posts) < 0.06


@pytest.mark.parametrize(
    ("degrees", "step"), [(357.0, 357.0 / 359.0), (359.0, 1.0), (359.8, 1.0), (360.0, 1.0)]
)
def test_a_fan_that_is_no_full_turn_ends_where_it_says(degrees, step, tmp_path):
    half = math.radians(degrees / 2.0)
    spec = opened(tmp_path, lidar(first=-half, last=half)).spec.lidar
    assert math.degrees(spec.angle_increment) == pytest.approx(step)
