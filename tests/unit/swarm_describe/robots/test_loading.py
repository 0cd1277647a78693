"""Reading of robot.yaml, and finding what ships with the project."""

import dataclasses

import pytest

from swarm_common.files.resources import share_directory
from swarm_common.model.errors import RobotModelError, SwarmError, UnknownNameError
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.source import find_robot

WAFFLE = (share_directory() / "robots/turtlebot3_waffle/robot.yaml").read_text()


def test_the_waffle_has_its_published_figures_by_name_and_path(tmp_path):
    spec = load_robot("turtlebot3_waffle")
    assert spec.model == "turtlebot3_waffle"
    assert (spec.max_vel_x, spec.max_vel_theta) == (0.26, 1.82)
    assert spec.circumscribed_radius == pytest.approx(0.238, abs=5e-4)
    assert (spec.lidar.rays, spec.lidar.rate, spec.lidar.z) == (360, 5.0, 0.132)
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "robot.yaml").write_text(WAFFLE)
    assert load_robot(folder).model == "mine"
    assert load_robot(folder / "robot.yaml") == load_robot(folder)
    spec = load_robot("turtlebot3_waffle")
    plate = ((-0.3, -0.1), (0.1, -0.1), (0.1, 0.15), (-0.3, 0.15))
    assert dataclasses.replace(spec, footprint=plate).inscribed_radius == pytest.approx(0.1)
    assert spec.inscribed_radius == pytest.approx(0.069)  # the wheels are ahead of the middle


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("differential", "magnetic", "unknown drive 'magnetic'"),
        ("max_vel_x: 0.26", "max_vel_x: 0", "expected a number from 0.0001 to 50"),
        (
            "  - [0.069, -0.133]\n  - [0.069, 0.133]",
            "  - [0.069, 0.133]\n  - [0.069, -0.133]",
            "convex",
        ),
        ("rate: 5.0", "rate: 0", "expected a number from 0.01 to 1000"),
    ],
)
def test_bad_files_are_refused(tmp_path, old, new, message):
    assert old in WAFFLE
    path = tmp_path / "robot.yaml"
    path.write_text(WAFFLE.replace(old, new))
    with pytest.raises(SwarmError, match=r"robot\.yaml") as caught:
        load_robot(path)
    assert message in str(caught.value)
    assert isinstance(caught.value, RobotModelError | UnknownNameError)


@pytest.mark.parametrize(
    ("file", "name"),
    [("agv_1.5.urdf", "agv_1.5"), ("agv.urdf.xacro", "agv"), ("a.b.gazebo.xacro", "a.b.gazebo")],
)
def test_a_dot_in_a_name_is_no_ending(tmp_path, file, name):
    (tmp_path / file).write_text("<robot name='agv'/>")
    (tmp_path / f"{name}.robot.yaml").write_text("max_vel_x: 0.5\n")
    found = find_robot(tmp_path / file)
    assert (found.name, found.data) == (name, {"max_vel_x": 0.5})
