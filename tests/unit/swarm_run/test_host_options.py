"""Options of several hosts, the description that carries all else, and the robots' plan."""

from pathlib import Path

import pytest

from swarm_commander.hosts.robots_plan import robots_plan
from swarm_commander.hosts.run_description import compose, parse
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_run.host_options import Role, check_combination, parse_robots
from swarm_run.plan import check_plan
from swarm_run.spec import RunSpec


def test_robots_by_numbers_and_ranges():
    assert parse_robots("3") == (3,)
    assert parse_robots(" 2-4, 1 ,3") == (1, 2, 3, 4)


@pytest.mark.parametrize("text", ["", "0-3", "3-1", "1-", "-3", "a", "1,,2", "1-1001", "1--2", "²"])
def test_robots_that_are_no_numbers(text):
    with pytest.raises(ConfigError, match="expected numbers from 1 to"):
        parse_robots(text)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((None, "1-3", None, None), "--robots is for several hosts"),
        ((None, None, "host", None), "--connect is for several hosts"),
        ((None, None, None, "lo"), "--bind is for several hosts"),
        ((Role.WORLD, None, None, None), "--role world needs --bind"),
        ((Role.WORLD, "1-3", None, "lo"), "--robots belongs to the robots' hosts"),
        ((Role.ROBOTS, None, "host", None), "needs --robots"),
        ((Role.ROBOTS, "1-3", None, None), "needs --connect"),
    ],
)
def test_options_that_do_not_go_together(arguments, words):
    with pytest.raises(ConfigError, match=words):
        check_combination(*arguments)


@pytest.fixture(autouse=True)
def _no_variables(monkeypatch):
    monkeypatch.delenv("FASTRTPS_DEFAULT_PROFILES_FILE", raising=False)


SECRET = "sixteen letters or more"


def of_robots(robots, pack=1):
    return RunSpec(role=Role.ROBOTS, robots=robots, connect="127.0.0.1", pack=pack)


def test_plan_of_a_robots_host():
    typed = {"seed": 3, "robots": "1-5", "pack": 2}
    plan = robots_plan(of_robots("1-5", pack=2), typed, SECRET)
    assert (plan.own_address, plan.world_address) == ("127.0.0.1", "127.0.0.1")
    assert plan.stated == {"seed": 3}
    assert plan.processes == 3
    assert SECRET not in repr(plan)


def test_what_a_robots_host_refuses(monkeypatch):
    with pytest.raises(ConfigError, match="--mission belongs to the world's host"):
        robots_plan(of_robots("1"), {"mission": "loading_route"}, SECRET)
    with pytest.raises(ConfigError, match="with --pack 2"):
        robots_plan(of_robots("1-100"), {}, SECRET)
    with pytest.raises(ConfigError, match="--pack is '0'"):
        robots_plan(of_robots("1", pack=0), {}, SECRET)
    with pytest.raises(ConfigError, match="needs the secret of the world's host in SWARM_SECRET"):
        robots_plan(of_robots("1"), {}, "")
    monkeypatch.setenv("FASTRTPS_DEFAULT_PROFILES_FILE", "/my/profile.xml")
    with pytest.raises(ConfigError, match="unset it"):
        robots_plan(of_robots("1"), {}, SECRET)


def test_a_charter_gives_every_robot_the_parameters_of_a_run_on_one_host():
    plan = check_plan(RunSpec(swarm_size=3, mission="loading_route"))
    trees = {f"Srobot{n}": plan.parameter_file(n, Pose(n, 2.0, 0.5)) for n in (1, 2, 3)}
    facts = {"world": "slim_blockage", "seed": 0, "robot": "turtlebot3_waffle", "swarm_size": 3}
    description = parse(
        compose("run", "1", facts, trees, plan.sites_path, {}, plan.overrides.source).to_text()
    )
    for name, tree in trees.items():
        assert description.parameter_file(name, str(plan.sites_path)) == tree
        assert len(description.robots[name]) < 5
    assert description.sites == Path(str(plan.sites_path)).read_text(encoding="utf-8")
    own = description.parameter_file("Srobot1", "/elsewhere/sites.yaml")
    assert own["/Srobot1/navigator"]["ros__parameters"]["sites"] == "/elsewhere/sites.yaml"
