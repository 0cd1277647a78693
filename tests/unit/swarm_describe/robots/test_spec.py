"""Descriptions as others write them: read right, or refused with everything that is wrong."""

import numpy as np
import pytest

from swarm_common.model.errors import RobotModelError
from swarm_common.model.outline import outline_around
from swarm_describe.robots.loading import load_robot, open_robot
from swarm_describe.robots.spec import check_footprint
from tests.fakes.own_robots import (
    CHASSIS,
    LIMITS,
    Own,
    car,
    caster,
    inertial,
    joint,
    lidar,
    link,
    many_sided,
    on_swivels,
    own_footprint_joint,
    pair,
    planar_move,
    robot,
    tricycle,
)  # fmt: skip


def load_error(own, folder):
    with pytest.raises(RobotModelError) as caught:
        load_robot(own.write(folder))
    return str(caught.value)


# base_footprint


@pytest.mark.parametrize("extra", ["", "base_footprint_joint_2"])
def test_a_base_footprint_joint_of_its_own_is_no_obstacle(extra, tmp_path):
    own = own_footprint_joint()
    text = own.urdf
    if extra:
        more = link("extra") + joint(extra, "base_link", "extra")
        text = text.replace("</robot>", more + "</robot>")
    made = open_robot(Own(text, own.settings).write(tmp_path))
    assert set(made.model.fixed) >= {"base_footprint", "base_link", "base_footprint_of_model"}
    np.testing.assert_allclose(made.model.fixed["base_link"][:3, 3], [0.0, 0.0, 0.05], atol=1e-9)


# Cars


PLUGIN = '<gazebo><plugin name="drive" filename="{}"/></gazebo>'
CONTROL = (
    '<gazebo><plugin name="control" filename="libgazebo_ros2_control.so">'
    "<parameters>{}</parameters></plugin></gazebo>"
)


@pytest.mark.parametrize(
    ("own", "reason"),
    [
        (car(), "the joints front_left_steering, front_right_steering steer its wheels"),
        (car(kind="continuous"), "the joints front_left_steering, front_right_steering"),
        (car(ends=("front", "rear"), kind="continuous"), "rear_right_steering steer its wheels"),
        (car(PLUGIN.format("gz-sim-ackermann-steering-system")), "plugin gz-sim-ackermann"),
        (car(PLUGIN.format("libgazebo_ros_ackermann_drive.so"), ends=()), "plugin libgazebo_ros_a"),
        (tricycle(), "the joints fork_joint steer its wheels"),
    ],
)
def test_cars_are_refused_by_name(own, reason, tmp_path):
    message = load_error(own, tmp_path)
    assert "it steers like a car" in message
    assert reason in message
    assert "cannot turn on the spot" in message


def test_who_drives_a_car_is_known_and_believed(tmp_path):
    kind = "ackermann_steering_controller/AckermannSteeringController"
    (tmp_path / "control.yaml").write_text(f"controller_manager:\n  drive: {{type: {kind}}}\n")
    message = load_error(car(CONTROL.format(tmp_path / "control.yaml"), ends=()), tmp_path)
    assert f"controller {kind}" in message
    cure = "drive: differential\nwheels: {left: [rear_left_wheel_joint], "
    cure += "right: [rear_right_wheel_joint]}\n"
    spec = load_robot(Own(car().urdf, LIMITS + cure).write(tmp_path))
    assert (spec.drive, spec.wheels_left) == ("differential", ("rear_left_wheel_joint",))
    spec = load_robot(on_swivels().write(tmp_path))
    assert (spec.drive, spec.wheels_left) == ("differential", ("left_wheel_joint",))


# Drives without wheels of their own


@pytest.mark.parametrize("turning", [False, True])
def test_planar_move_needs_no_wheels_that_turn(turning, tmp_path):
    spec = load_robot(planar_move(turning).write(tmp_path))
    assert (spec.drive, spec.wheels_left, spec.wheels_right) == ("omni", (), ())
    assert 0.2 <= spec.circumscribed_radius < 0.25


# Footprints


def test_a_footprint_that_was_rounded_passes_its_own_check(tmp_path):
    assert load_robot(many_sided().write(tmp_path)).circumscribed_radius > 0.19


@pytest.mark.parametrize("seed", range(10))
def test_derived_footprints_pass_the_check_of_given_ones(seed):
    random = np.random.default_rng(seed)
    for _ in range(50):
        points = random.uniform(-0.3, 0.3, (random.integers(3, 30), 2))
        around = [[-0.35, 0.0], [0.35, 1e-4], [0.0, -0.35], [1e-4, 0.35]]
        points = np.vstack([points, around, points + random.uniform(0.0, 2e-4)])
        outline = outline_around(points, 8)
        check_footprint(outline, "footprint")
        for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
            aside = (bx - ax) * (points[:, 1] - ay) - (by - ay) * (points[:, 0] - ax)
            assert (aside / np.hypot(bx - ax, by - ay)).min() > -4e-4  # rounding to 0.1 mm


# Everything at once


def test_all_that_keeps_a_robot_from_loading_is_told_at_once(tmp_path):
    mesh = '<mesh filename="package://{}/body.stl"/>'
    parts = [
        CHASSIS, *pair(), caster("caster", -0.15),
        link("cover", mesh.format("acme_covers"), inertial(0.2, 1e-3)),
        joint("cover_joint", "base_link", "cover"),
        link("bumper", mesh.format("acme_bumpers"), inertial(0.2, 1e-3)),
        joint("bumper_joint", "base_link", "bumper"),
        link("weight", '<box size="0.1 0.1 0.1"/>', inertial(-1.0, 1e-3)),
        joint("weight_joint", "base_link", "weight"),
        lidar(rpy="0.9 0 0"),
    ]  # fmt: skip
    own = Own(robot("broken", parts), "max_vel_x: -1.0\nheight: tall\nmax_vel_theta: 1.0\nfoo: 1\n")
    with pytest.raises(RobotModelError) as caught:
        load_robot(own.write(tmp_path))
    message = str(caught.value)
    for part in (
        "own.urdf: 6 things are wrong:",
        "unknown key 'foo'",
        "link weight: its mass is -1 kg",
        "packages 'acme_covers' and 'acme_bumpers' are not in",
        "give their folders with --package-path",
        "the LiDAR on link 'laser' is tilted by 52 degrees; write the pose",
        "max_vel_x is -1.0; expected a number from 0.0001 to 50",
        "height is 'tall'; expected a number",
    ):
        assert part in message
    assert len(caught.value.faults) == 6


def test_all_faults_are_told_at_once(tmp_path):
    text = robot("broken", [CHASSIS, *pair(), lidar()])
    text = text.replace('type="continuous"', 'type="screw"').replace('radius="0.05"', 'radius="x"')
    message = load_error(Own(text), tmp_path)
    assert message.count("is of type 'screw'") == 2
    assert message.count("<cylinder> radius is 'x'") == 2
    message = load_error(Own(robot("bare", [CHASSIS, *pair()]), "model: bare\n"), tmp_path)
    assert "does not tell max_vel_x, max_vel_theta, acc_lim_x, acc_lim_theta, lidar.x" in message


XACRO = """<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="known" default="1"/>
  <xacro:include filename="$(find pkg_one)/x.xacro"/>
  <xacro:include filename="b.xacro"/>
  <link name="$(arg who)_$(arg known)"/>
</robot>
"""
INCLUDED = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="meshes" value="$(find pkg_two)/meshes"/>
  <link name="$(arg what)"/> <!-- $(find pkg_three) $(arg why) -->
</robot>
"""


def test_all_packages_and_arguments_that_a_xacro_lacks_are_named(tmp_path):
    (tmp_path / "b.xacro").write_text(INCLUDED)
    path = tmp_path / "a.xacro"
    path.write_text(XACRO)
    with pytest.raises(RobotModelError) as caught:
        load_robot(path)
    message = str(caught.value)
    assert "packages 'pkg_one' and 'pkg_two' are not in" in message
    assert "robot.yaml, xacro_args: {who: ..., what: ...}" in message
    assert "pkg_three" not in message
    assert "why" not in message
    path.write_text(XACRO.replace('<xacro:include filename="$(find pkg_one)/x.xacro"/>', ""))
    (tmp_path / "b.xacro").write_text(INCLUDED.replace("$(find pkg_two)/", ""))
    (tmp_path / "a.robot.yaml").write_text("xacro_args: {who: me}\n")
    with pytest.raises(RobotModelError, match=r"\$\(arg what\) has no value; .*xacro_args: \{what"):
        load_robot(path)
