"""Reading of robot descriptions."""

import numpy as np
import pytest

from swarm_common.model.errors import RobotModelError
from swarm_common.model.shapes import Box, Sphere
from swarm_describe.robots.description import parse_urdf
from swarm_describe.robots.loading import load_robot, open_robot
from swarm_describe.robots.source import robot_names
from swarm_sim.scene.section import section_between

URDF = """<robot name="r">
  <link name="base">
    <inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
  <link name="mast">
    <inertial>
      <mass value="2"/>
      <inertia ixx="1e-8" iyy="1e-8" izz="1e-8" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><origin xyz="0 0 1"/><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <link name="wheel"/>
  <joint name="fix" type="fixed"><parent link="base"/><child link="mast"/>
    <origin xyz="1 0 0"/></joint>
  <joint name="turn" type="continuous"><parent link="mast"/><child link="wheel"/>
    <origin xyz="0 2 0"/><axis xyz="0 1 0"/></joint>
</robot>"""


def test_fixed_links_are_folded_into_their_parent():
    base, wheel = parse_urdf(URDF, "here").groups
    assert [type(part.shape) for part in base.parts] == [Box, Sphere]
    np.testing.assert_allclose(base.parts[1].body_from_part[:3, 3], [1, 0, 1])
    assert base.mass == 4.0
    np.testing.assert_allclose(base.center, [0.5, 0, 0])
    np.testing.assert_allclose(np.diag(base.inertia), [1, 2, 2])  # parallel axes
    assert (wheel.joint, wheel.parent) == ("turn", 0)
    np.testing.assert_allclose(wheel.parent_from_group[:3, 3], [1, 2, 0])
    assert wheel.axis.tolist() == [0, 1, 0]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</robot>", "", "malformed URDF"),
        ('<child link="mast"/>', '<child link="mst"/>', "names no link: 'mst'"),
        ('<link name="wheel"/>', '<link name="wheel"/><link name="lost"/>', "one root link"),
        ('size="1 1 1"', 'size="1 1"', "expected 3 numbers"),
        ('size="1 1 1"', 'size="1 1 x"', "malformed URDF"),
        (
            '<sphere radius="0.1"/>',
            '<mesh filename="a.stl"/>',
            "link mast: its collision mesh: there is no file",
        ),
        ("<sphere ", "<capsule ", "capsule"),
    ],
)
def test_malformed_descriptions_are_refused(old, new, message):
    with pytest.raises(RobotModelError, match="here") as caught:
        parse_urdf(URDF.replace(old, new), "here")
    assert message in str(caught.value)


@pytest.mark.parametrize("name", robot_names())
def test_descriptions_agree_with_robot_yaml(name):
    spec, model = load_robot(name), open_robot(name).model
    scan = model.fixed[spec.lidar.frame]
    np.testing.assert_allclose(scan[:3, 3], [spec.lidar.x, spec.lidar.y, spec.lidar.z], atol=1e-9)
    section = section_between(model.bodies(), 0.0, 1.0)
    outline = np.vstack(section.outlines(64))
    corners = np.array(spec.footprint)
    edges = np.roll(corners, -1, axis=0) - corners
    for corner, edge in zip(corners, edges, strict=True):  # the body lies within the footprint
        aside = edge[0] * (outline[:, 1] - corner[1]) - edge[1] * (outline[:, 0] - corner[0])
        assert (aside / np.hypot(*edge)).min() > -1e-3
    assert np.abs(outline[:, 1]).max() == pytest.approx(corners[:, 1].max(), abs=1e-3)
    assert {g.joint for g in model.groups[1:]} == {*spec.wheels_left, *spec.wheels_right}
    track = [group.parent_from_group[1, 3] for group in model.groups[1:]]
    assert max(track) - min(track) == pytest.approx(spec.wheel_separation)


def test_a_burger_is_above_a_waffles_scan_plane_and_a_waffle_below_a_burgers():
    waffle, burger = load_robot("turtlebot3_waffle"), load_robot("turtlebot3_burger")
    model = open_robot("turtlebot3_burger").model
    assert burger.circumscribed_radius == pytest.approx(0.124, abs=5e-4)
    seen = section_between(model.bodies(), waffle.lidar.z, waffle.lidar.z)
    assert len(seen.polygons) == 1  # its box
    assert waffle.height < burger.lidar.z
    assert sum(group.mass for group in model.groups) == pytest.approx(
        0.8257 + 2 * 0.0285 + 0.114 + 0.005
    )


@pytest.mark.parametrize("name", ["turtlebot3_waffle", "turtlebot3_burger"])
def test_other_readers_accept_the_description(name):
    text = open_robot(name).urdf
    assert "xacro" not in text.split("<robot", 1)[1]
    for link in ("base_footprint", "base_link", "wheel_left_link", "base_scan", "imu_link"):
        assert f'<link name="{link}"' in text


def test_a_folder_without_a_description_is_refused(tmp_path):
    (tmp_path / "robot.yaml").write_text("drive: differential\n")
    with pytest.raises(RobotModelError, match="there is no description beside it"):
        open_robot(tmp_path)
    (tmp_path / "model.urdf.xacro").write_text("<robot><oops></robot>")
    with pytest.raises(RobotModelError, match="xacro cannot expand it"):
        open_robot(tmp_path)
