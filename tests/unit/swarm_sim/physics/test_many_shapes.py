"""PyBullet keeps 16 shapes of one call and drops the rest: bodies have all of theirs anyway."""

from pathlib import Path

import numpy as np
import pytest

from swarm_common.model.errors import RobotModelError
from swarm_common.model.shapes import Box, Cylinder, Part, Sphere
from swarm_describe.robots.loading import open_robot
from swarm_describe.worlds.scene import Body, Scene
from swarm_sim.maps.world_check import differences
from swarm_sim.physics.trial import check_trial
from tests.fakes.own_robots import LIMITS, ball, box, inertial, joint, link, wheel

pytest.importorskip("pybullet")

from swarm_sim.physics.bullet import collision_shapes, probe

SHAPES = (Box((0.1, 0.1, 0.2)), Cylinder(0.05, 0.2), Sphere(0.05))


def row_of(count, *, is_static):
    parts = []
    for index in range(count):
        place = np.eye(4)
        place[:3, 3] = 0.3 * index, 0.1 * (index % 3), 0.1
        parts.append(Part(SHAPES[index % 3], place))
    return Body("row", np.eye(4), tuple(parts), is_static=is_static, mass=5.0)


@pytest.mark.parametrize("is_static", [True, False])
@pytest.mark.parametrize("count", [1, 16, 17, 33, 200])
def test_the_engine_has_every_shape_of_a_body(count, is_static):
    lacking = probe.lacking(row_of(count, is_static=is_static), 0.0, 0.2, 0.01)
    assert len(lacking) == 0


@pytest.mark.parametrize("is_static", [True, False])
def test_the_check_of_worlds_looks_at_whatever_can_be_touched(is_static, monkeypatch):
    monkeypatch.setattr(collision_shapes, "MOST_SHAPES", 100)  # as before: all in one call
    missed = probe.lacking(row_of(17, is_static=is_static), 0.0, 0.2, 0.01)
    assert missed[:, 0].min() > 4.7  # the last one


def own_robot(folder, base, more=""):
    """Return the path of a robot with two wheels and two balls, whose base has more shapes."""
    body = link("base_link", box(0.4, 0.3, 0.1), inertial(8.0, 0.2), "0 0 0.1")
    body = body.replace("</link>", f"{base}</link>")
    body += wheel("left", (0.0, 0.2, 0.05)) + wheel("right", (0.0, -0.2, 0.05))
    for index, x in enumerate((0.17, -0.17)):
        body += link(f"ball{index}", ball(0.02), inertial(0.1, 1e-4))
        body += joint(f"ball{index}_joint", "base_link", f"ball{index}", (x, 0.0, 0.02))
    body += link("laser") + joint("laser_joint", "base_link", "laser", (0.0, 0.0, 0.13))
    path = folder / "own.urdf"
    path.write_text(f'<robot name="own">{body}{more}</robot>', encoding="utf-8")
    settings = f"description: own.urdf\n{LIMITS}lidar: {{frame: laser}}\n"
    (folder / "own.robot.yaml").write_text(settings, encoding="utf-8")
    return str(path)


def bumper(folder):
    """Return the path of a robot with 18 small boxes before a long bumper, 0.7 m ahead."""
    shapes = [(0.01 * k - 0.1, 0.12, box(0.01, 0.01, 0.01)) for k in range(18)]
    return own_robot(
        folder,
        "".join(
            f'<collision><origin xyz="{x:.2f} 0 {z}"/><geometry>{shape}</geometry></collision>'
            for x, z, shape in (*shapes, (0.4, 0.1, box(0.6, 0.04, 0.04)))
        ),
    )


def test_a_marker_without_mass_is_no_hindrance(tmp_path):
    massless = link("tag", box(0.03, 0.03, 0.001), inertial(0.0, 0.0))
    tag = massless + joint("tag_joint", "base_link", "tag", (0.0, 0.0, 0.16))
    robot = open_robot(own_robot(tmp_path, "", tag))
    assert "link tag has a mass of 0; 0.01 kg are taken" in robot.model.notes


def test_a_robot_has_all_of_its_shapes_and_a_trial_says_which_it_lacks(tmp_path, monkeypatch):
    robot = open_robot(bumper(tmp_path))
    assert robot.spec.circumscribed_radius == pytest.approx(0.7, abs=0.015)
    assert probe.lacking_of_robot(robot.model, robot.spec) is None
    monkeypatch.setattr(collision_shapes, "MOST_SHAPES", 100)
    monkeypatch.setattr("swarm_sim.physics.trial.kept", lambda kind, parts, make: make())
    with pytest.raises(RobotModelError, match="lacks a collision shape of link base_link"):
        check_trial(robot.spec, robot.model, 0.01)


@pytest.mark.parametrize("is_static", [True, False])
def test_a_link_of_seventeen_shapes_is_in_map_lidar_and_engine(is_static):
    scene = Scene("rows", Path("rows.sdf"), (row_of(17, is_static=is_static),))
    assert list(differences(scene, [0.1], (0.01, 0.2), with_physics=True)) == []
