"""Robots stand on their driven wheels and roll, or are refused with the cause."""

import math
from pathlib import Path

import pytest

from swarm_common.model.errors import RobotModelError
from swarm_common.model.records import Pose, Twist
from swarm_describe.robots.loading import open_robot
from swarm_describe.robots.source import robot_names
from swarm_describe.worlds.scene import Scene
from swarm_sim.physics import trial
from swarm_sim.physics.trial import check_trial
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.foreign_robots import inboard_tyres, mecanum_by_controller, on_rollers
from tests.fakes.own_robots import (
    CHASSIS,
    LIMITS,
    TRAITS,
    Own,
    box,
    caster,
    inertial,
    lidar,
    link,
    pair,
    robot,
    slanting,
    sprung,
    wheel,
)  # fmt: skip

PERIOD = 0.01


def opened(own, folder):
    return open_robot(own.write(folder))


@pytest.mark.parametrize("name", [name for name in TRAITS if " mm " in name])
def test_wheels_carry_the_robot_however_casters_are_drawn(name, tmp_path):
    made = opened(TRAITS[name](), tmp_path)
    world = World(
        Scene("field", Path("."), ()),
        [made.spec],
        [Pose(0.0, 0.0, 0.0)],
        WorldConfig(with_lidar=False),
        models={made.spec.model: made.model},
    )
    for _ in range(20):
        world.step([Twist(0.3)], [None])
    pose, twist = world.ground_truth()[0]
    assert abs(math.degrees(pose.yaw)) < 1.0
    assert pose.x == pytest.approx(0.55, abs=0.02)
    assert twist.vx == pytest.approx(0.3, abs=0.01)
    world.close()
    done = check_trial(made.spec, made.model, PERIOD)
    assert min(done.left, done.right) > 0.15


@pytest.mark.parametrize("name", robot_names())
def test_every_model_that_ships_passes(name):
    made = open_robot(name)
    done = check_trial(made.spec, made.model, PERIOD)
    assert done.stands
    assert min(done.left, done.right) > 0.25
    assert done.ahead == pytest.approx(done.way, rel=0.02)


def narrow():
    """Wheels 9 cm apart and the weight behind them: it slips in curves only."""
    body = link("base_link", box(0.5, 0.125, 0.1), inertial(1.0, 0.022, "-0.225 0 0"), "0 0 0.175")
    limits = "max_vel_x: 1\nmax_vel_theta: 1\nacc_lim_x: 1.0\nacc_lim_theta: 2.0\n"
    return Own(robot("narrow", [body, *pair(0.125, 0.047, radius=0.125), lidar()]), limits)


def heavy_behind(x):
    mass = inertial(6.0, 0.08, f"{x} 0 0.1")
    chassis = link("base_link", box(0.4, 0.26, 0.1), mass, xyz="0 0 0.1")
    return Own(robot("heavy_behind", [chassis, *pair(), caster("caster", -0.15), lidar()]))


def of_lead():
    chassis = link("base_link", box(0.4, 0.26, 0.1), inertial(6.0, 5000.0), xyz="0 0 0.1")
    return Own(robot("of_lead", [chassis, *pair(), caster("caster", -0.15), lidar()]))


def sleepy_wheels():
    wheels = [
        wheel(name, (0.0, y, 0.05), mass=inertial(0.3, 50.0))
        for name, y in (("left", 0.15), ("right", -0.15))
    ]
    return Own(robot("sleepy", [CHASSIS, *wheels, caster("caster", -0.15), lidar()]))


@pytest.mark.parametrize(
    ("own", "words"),
    [
        (heavy_behind(-0.149), ("Cause: friction: the wheels turn as told", "inertia: shapes")),
        (heavy_behind(-0.19), ("Cause: inertia: the centre of mass is at (-0.17", "or it tips")),
        (of_lead(), ("Cause: inertia: the motors", "has 5e+03 kg m²", "inertia: shapes")),
        (sleepy_wheels(), ("Cause: inertia", "_wheel has 50", "inertia: shapes")),
        (narrow(), ("Cause: friction: the wheels turn as told", "in a curve it turned by 69 ")),
        (slanting(0.06), ("Cause: wheel height", "left_wheel_joint ends 60 mm", "wheels: {left")),
    ],
)
def test_what_does_not_drive_is_refused_with_cause_and_cure(own, words, tmp_path):
    made = opened(own, tmp_path)
    with pytest.raises(RobotModelError, match="does not drive") as caught:
        World(
            Scene("field", Path("."), ()),
            [made.spec],
            [Pose(0.0, 0.0, 0.0)],
            models={made.spec.model: made.model},
        )
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize("own", [heavy_behind(-0.149), heavy_behind(-0.19), of_lead()])
def test_inertias_that_follow_from_the_shapes_cure_it(own, tmp_path):
    made = opened(Own(own.urdf, LIMITS + "inertia: shapes\n"), tmp_path)
    done = check_trial(made.spec, made.model, PERIOD)
    assert done.stands
    assert done.goes_ahead
    assert done.turns


def test_two_wheels_that_are_to_roll_sideways_are_refused_with_what_they_were_taken_for(tmp_path):
    own = Own(sprung(0.0).urdf, LIMITS + "drive: omni\n")
    made = opened(own, tmp_path)
    with pytest.raises(RobotModelError) as caught:
        check_trial(made.spec, made.model, PERIOD)
    message = str(caught.value)
    assert "m to the left, it went" in message
    assert "its wheels report 0.00 m" in message
    assert "It was taken for: drive omni (robot.yaml); wheels left_wheel_joint (left)" in message
    assert "state it in robot.yaml: drive: ..., wheels:" in message


@pytest.mark.parametrize("make", [mecanum_by_controller, on_rollers, inboard_tyres])
def test_drives_of_others_pass(make, tmp_path):
    made = opened(make(), tmp_path)
    done = check_trial(made.spec, made.model, PERIOD)
    assert done.turned == pytest.approx(done.turn, rel=0.02)
    if made.spec.is_omni:
        assert done.slid == pytest.approx(done.side, rel=0.02)
        assert done.side > 0.3


def test_a_radius_that_is_too_small_is_blamed_as_well_as_the_caster(tmp_path):
    own = Own(sprung(0.0).urdf, LIMITS + "wheel_radius: 0.025\n")
    made = opened(own, tmp_path)
    with pytest.raises(RobotModelError, match=r"the wheels' radius, 0.025 m \(robot.yaml\)"):
        check_trial(made.spec, made.model, PERIOD)


def test_a_model_is_tried_once(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    first = opened(sprung(0.001), tmp_path)
    known = check_trial(first.spec, first.model, PERIOD)
    monkeypatch.setattr(trial, "drive", None)
    again = opened(sprung(0.001), tmp_path)
    assert check_trial(again.spec, again.model, PERIOD) == known
    other = opened(sprung(0.0015), tmp_path)
    with pytest.raises(TypeError):  # another content is another model
        check_trial(other.spec, other.model, PERIOD)
