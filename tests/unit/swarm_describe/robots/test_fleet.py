"""Reading of fleets."""

import dataclasses
from pathlib import Path

import pytest

from swarm_common.model.errors import SwarmError
from swarm_describe.robots.fleet import load_fleet, uniform_fleet
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.source import find_robot, robot_names

BURGER, WAFFLE = "turtlebot3_burger", "turtlebot3_waffle"
GROUPS = f"""groups:
  - {{model: {BURGER}, count: 3, limits: {{max_vel_x: 0.2}}, mission: loading_route}}
  - {{model: {WAFFLE}, count: 1}}
"""


def write(folder, text):
    path = folder / "fleet.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_fleets_ship():
    fleet = load_fleet("mixed")
    assert [member.model for member in fleet.members] == [BURGER, WAFFLE] * 15
    assert fleet.label == f"15 {BURGER}, 15 {WAFFLE}"
    assert fleet.members[0].limits_in_force["max_vel_x"] == 0.22
    assert fleet.members[1].limits_in_force["max_vel_x"] == 0.26
    fleet = load_fleet("all_models")
    assert {member.model for member in fleet.members} == set(robot_names()) - {"carrier"}
    limits = {m.spec.drive: m.limits_in_force for m in fleet.members}
    assert limits["omni"]["max_vel_y"] == 0.4
    assert "max_vel_y" not in limits["skid"]
    fleet = uniform_fleet(WAFFLE, 7)
    assert len(fleet.members) == 7
    assert fleet.label == WAFFLE


def test_groups_follow_each_other_or_are_mixed(tmp_path):
    grouped = load_fleet(write(tmp_path, GROUPS))
    assert [member.model for member in grouped.members] == [BURGER] * 3 + [WAFFLE]
    mixed = load_fleet(write(tmp_path, "order: mixed\n" + GROUPS))
    assert [member.model for member in mixed.members] == [BURGER, WAFFLE, BURGER, BURGER]
    first, second = mixed.members[:2]
    assert (first.mission, second.mission) == ("loading_route", None)
    limits = {"max_vel_x": 0.2, "max_vel_theta": 2.84, "acc_lim_x": 1.0, "acc_lim_theta": 3.2}
    assert first.limits_in_force == limits
    assert first.spec == load_robot(BURGER)


def test_a_model_may_lie_beside_the_fleet(tmp_path):
    own = tmp_path / "models" / "own"
    own.mkdir(parents=True)
    (own / "robot.yaml").write_text(find_robot(BURGER).settings.read_text())
    (member,) = load_fleet(write(tmp_path, "groups:\n  - {model: models/own, count: 1}\n")).members
    assert member.spec == dataclasses.replace(load_robot(BURGER), model="own")
    assert Path(member.model).is_absolute()


@pytest.mark.parametrize(
    ("top", "groups", "names"),
    [
        ("", ("", ""), ["Srobot1", "Srobot2", "Srobot3"]),
        ("names: agv{}", ("", ""), ["agv1", "agv2", "agv3"]),
        ("names: [ann, bob, cem]", ("", ""), ["ann", "bob", "cem"]),
        ("", ("names: 'leo{}'", "names: 'husky{:02}'"), ["leo1", "leo2", "husky01"]),
        ("order: mixed", ("names: 'leo{}'", "names: [max]"), ["leo1", "max", "leo2"]),
        ("", ("names: [ann, bob]", ""), ["ann", "bob", "Srobot3"]),
    ],
)
def test_names_are_the_fleets_or_the_groups(tmp_path, top, groups, names):
    lines = [
        f"  - {{model: {BURGER}, count: {count}, {own}}}"
        for count, own in zip((2, 1), groups, strict=True)
    ]
    fleet = load_fleet(write(tmp_path, "\n".join([top, "groups:", *lines])))
    assert fleet.names.first(len(fleet.members)) == names


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("groups: [", "line"),
        ("groups: []", "expected a list of model and count"),
        (
            f"groups: [{{model: {BURGER}, count: 0}}]",
            "count is 0; expected an integer from 1 to 1000",
        ),
        ("groups: [{model: turtlebot3_burgr, count: 1}]", f"did you mean '{BURGER}'"),
        ("groups: [{model: ../none, count: 1}]", "there is no file or folder '../none'"),
        (f"groups: [{{model: {BURGER}, count: 1, limits: 1}}]", "expected 'name: value' lines"),
        (
            f"groups: [{{model: {BURGER}, count: 1, limits: {{max_vel_x: 0.26}}}}]",
            "a turtlebot3_burger allows",
        ),
        (f"names: 3\ngroups: [{{model: {BURGER}, count: 1}}]", "'3' is no name"),
        (f"groups: [{{model: {BURGER}, count: 2, names: [a, a]}}]", "two robots are called 'a'"),
        (
            f"groups: [{{model: {BURGER}, count: 1, names: [a]}}, "
            f"{{model: {WAFFLE}, count: 1, names: [a]}}]",
            "two robots are called 'a'",
        ),
        (
            f"names: b{{}}\ngroups: [{{model: {BURGER}, count: 1, names: [a]}}]",
            "groups of the fleet have names, too",
        ),
    ],
)
def test_bad_fleets_are_refused(tmp_path, text, message):
    path = write(tmp_path, text)
    with pytest.raises(SwarmError) as caught:
        load_fleet(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
