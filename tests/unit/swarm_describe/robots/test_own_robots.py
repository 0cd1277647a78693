"""Robots of the user: URDF and xacro as packages have them."""

import math
from pathlib import Path

import numpy as np
import pytest

from swarm_common.model.errors import RobotModelError, SwarmError, UnknownNameError
from swarm_common.model.records import Pose, Twist
from swarm_common.model.shapes import Hull
from swarm_describe.robots.loading import load_robot, open_robot
from swarm_describe.robots.source import robot_names
from swarm_describe.worlds.scene import Scene
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.robots import LIMITS, URDF, write_packages

LASER = "lidar: {frame: laser, rays: 90, range_max: 5.0, rate: 5.0}\n"


@pytest.fixture
def packages(tmp_path, monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    urdf, xacro = write_packages(tmp_path)
    (urdf.parent / "robot.yaml").write_text(
        f"description: {urdf.name}\n" + LIMITS, encoding="utf-8"
    )
    (xacro.parent / "acme_big.robot.yaml").write_text(
        LIMITS + LASER + "packages: [../../../vendor]\n", encoding="utf-8"
    )
    return urdf, xacro


def test_a_urdf_of_a_package_tells_what_it_can(packages):
    robot = open_robot(packages[0])
    spec = robot.spec
    assert (spec.model, spec.drive) == ("acme", "differential")
    assert (spec.wheels_left, spec.wheels_right) == (("left_wheel_joint",), ("right_wheel_joint",))
    assert spec.wheel_radius == 0.05
    assert spec.wheel_separation == pytest.approx(0.3)
    # base_footprint is put on the ground between the wheels, 0.05 ahead of base_link
    np.testing.assert_allclose(robot.model.fixed["base_link"][:3, 3], [-0.05, 0.0, 0.07])
    assert '<link name="base_footprint"' in robot.urdf
    assert "namespace}" not in robot.urdf
    body = packages[0].parents[1] / "meshes" / "body.stl"
    assert f'filename="{body.as_uri()}"' in robot.urdf
    corners = np.array(spec.footprint)
    assert corners[:, 0].min() == pytest.approx(-0.25, abs=1e-3)
    assert corners[:, 1].max() == pytest.approx(0.16, abs=1e-3)
    assert spec.height == pytest.approx(0.12)
    lidar = spec.lidar
    assert (lidar.frame, lidar.rays, lidar.rate, lidar.sigma) == ("lidar_link", 181, 10.0, 0.02)
    assert (lidar.x, lidar.z) == (pytest.approx(0.05), pytest.approx(0.19))
    assert lidar.yaw == pytest.approx(math.pi / 2)
    assert lidar.angle_increment == pytest.approx(math.pi / 180)
    assert (lidar.range_min, lidar.range_max) == (0.1, 8.0)
    assert any("right_wheel has no <inertial>" in note for note in robot.model.notes)
    assert isinstance(robot.model.groups[0].parts[0].shape, Hull)
    assert {group.joint for group in robot.model.groups} == {
        "", "left_wheel_joint", "right_wheel_joint",
    }  # fmt: skip


def test_a_xacro_tree_with_includes_arguments_and_meshes(packages):
    spec = load_robot(packages[1])
    assert (spec.model, spec.drive) == ("acme_big", "skid")
    assert spec.wheels_left == ("front_left_wheel_joint", "rear_left_wheel_joint")
    assert spec.wheel_radius == pytest.approx(0.06, abs=1e-6)
    assert spec.wheel_base == pytest.approx(0.2)
    assert max(x for x, _ in spec.footprint) == pytest.approx(0.2, abs=1e-3)
    assert (spec.lidar.z, spec.lidar.rays) == (pytest.approx(0.2), 90)
    settings = packages[1].with_name("acme_big.robot.yaml")
    settings.write_text(settings.read_text() + "xacro_args: {big: true}\n", encoding="utf-8")
    assert max(x for x, _ in load_robot(packages[1]).footprint) == pytest.approx(0.3, abs=1e-3)


@pytest.mark.parametrize("variable", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_packages_are_found_where_ros_finds_them(packages, variable, monkeypatch, tmp_path):
    settings = packages[1].with_name("acme_big.robot.yaml")
    settings.write_text(LIMITS + LASER, encoding="utf-8")
    with pytest.raises(RobotModelError, match=r"package 'acme_parts' is not in .*--package-path"):
        load_robot(packages[1])
    place = tmp_path / "vendor"
    if variable == "AMENT_PREFIX_PATH":
        place = tmp_path / "install"
        (place / "share").mkdir(parents=True)
        (tmp_path / "vendor" / "acme_parts").rename(place / "share" / "acme_parts")
    monkeypatch.setenv(variable, str(place))
    assert load_robot(packages[1]).drive == "skid"


def test_what_the_file_does_not_tell_is_asked_for_and_wheels_are_needed(packages):
    settings = packages[0].with_name("robot.yaml")
    settings.unlink()
    with pytest.raises(RobotModelError) as caught:
        load_robot(packages[0])
    assert str(caught.value) == (
        f"{packages[0]} does not tell max_vel_x, max_vel_theta; write them into {settings}"
    )
    packages[0].write_text(URDF.replace('type="ray"', 'type="camera"'), encoding="utf-8")
    with pytest.raises(RobotModelError, match=r"max_vel_x, max_vel_theta, lidar\.x, lidar\.y"):
        load_robot(packages[0])
    text = URDF.replace("diff_drive", "nothing").replace('type="continuous"', 'type="fixed"')
    packages[0].write_text(text, encoding="utf-8")
    with pytest.raises(RobotModelError, match="no wheels to drive on: 0 on the left"):
        load_robot(packages[0])


@pytest.mark.parametrize("engine", ["planar", "bullet"])
def test_such_robots_drive(packages, engine):
    robots = [open_robot(path) for path in packages]
    world = World(
        Scene("field", Path("."), ()),
        [robot.spec for robot in robots],
        [Pose(0.0, 0.0, 0.0), Pose(0.0, 2.0, 0.0)],
        WorldConfig(engine=engine),
        models={robot.spec.model: robot.model for robot in robots},
    )
    for _ in range(20):
        world.step([Twist(0.3, 0.0, 0.2)] * 2, [None] * 2)
    for (pose, twist), start in zip(world.ground_truth(), (0.0, 2.0), strict=True):
        assert 0.5 < pose.x < 0.6
        assert pose.y > start + 0.05
        assert twist.vx == pytest.approx(0.3, abs=0.01)
        assert twist.wz == pytest.approx(0.2, abs=0.01)
    world.close()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<child link="${namespace}caster"/>', '<child link="${namespace}base_link"/>', "loop"),
        ('<parent link="${namespace}caster"/>', '<parent link="wheel"/>', "names no link: 'wheel'"),
        ('<child link="${namespace}caster"/>', '<child link="left_wheel"/>', "on two joints"),
        ('mass value="4.0"', 'mass value="0.0"', "link base_link: its mass is 0 kg"),
        ('xyz="0.05 0.15 -0.02"', 'xyz="0.05 nan -0.02"', "joint left_wheel_joint: <origin> xyz"),
        ('scale="0.001 0.001 0.001"', 'scale="0 1 1"', "must not be 0"),
        ("acme_description/m", "nowhere/m", "package 'nowhere' is not in"),
        ("<left_joint>left_wheel_joint", "<left_joint>wheel", "the wheel 'wheel' is no turning"),
        ('rpy="0 0 1.5707963"', 'rpy="2.1415927 0 0"', "is tilted by 57 degrees"),
        ("<update_rate>10", "<update_rate>often", "<update_rate> is 'often'"),
    ],
)
def test_nonsense_is_refused(packages, old, new, message):
    assert old in URDF
    packages[0].write_text(URDF.replace(old, new), encoding="utf-8")
    with pytest.raises(SwarmError) as caught:
        load_robot(packages[0])
    assert message in str(caught.value)
    assert str(packages[0]) in str(caught.value)


def test_an_undefined_property_is_refused_with_file_and_line(packages):
    wheel = packages[1].parents[3] / "vendor" / "acme_parts" / "urdf" / "wheel.xacro"
    wheel.write_text(wheel.read_text().replace("${radius - 0.1}", "${raduis - 0.1}"))
    with pytest.raises(RobotModelError) as caught:
        load_robot(packages[1])
    assert str(caught.value).startswith(f"{wheel}, line 13: xacro cannot expand it: name 'raduis'")


def test_paths_that_lead_nowhere(tmp_path):
    with pytest.raises(UnknownNameError, match="there is no file or folder"):
        load_robot(tmp_path / "none.urdf")
    (tmp_path / "picture.png").write_bytes(b"\x89PNG")
    with pytest.raises(RobotModelError, match="is no robot"):
        load_robot(tmp_path / "picture.png")
    (tmp_path / "a.urdf").write_bytes(b"\xff\xfe")
    with pytest.raises(RobotModelError, match="cannot read"):
        load_robot(tmp_path / "a.urdf")


def test_the_six_models_and_a_long_one_ship():
    assert [name for name in robot_names() if load_robot(name).is_oblong] == ["carrier"]
    assert robot_names() == [
        "carrier", "linorobot2_2wd", "linorobot2_4wd", "linorobot2_mecanum",
        "turtlebot3_burger", "turtlebot3_waffle", "turtlebot3_waffle_pi",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "drive", "radius"),
    [
        ("linorobot2_2wd", "differential", 0.183),
        ("linorobot2_4wd", "skid", 0.25),
        ("linorobot2_mecanum", "omni", 0.25),
        ("turtlebot3_waffle_pi", "differential", 0.238),
    ],
)
def test_models_have_their_published_figures(name, drive, radius):
    spec = load_robot(name)
    assert spec.drive == drive
    assert spec.circumscribed_radius == pytest.approx(radius, abs=6e-4)
    assert (spec.max_vel_y > 0.0) == spec.is_omni
