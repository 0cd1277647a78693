"""Who may come, go and be put elsewhere, and what is refused."""

import math
from collections.abc import Callable

import pytest

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose, Twist
from swarm_common.model.sites import Sites
from swarm_describe.robots.spec import parse_battery
from swarm_describe.worlds.world_file import find_world
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.goals import Goal, GoalKind
from swarm_sim.ros.build import build
from swarm_sim.ros.settings import RobotEntry, Settings
from swarm_sim.world.model_reader import read_robot
from swarm_sim.world.request_checks import Reason, RefusedError
from swarm_sim.world.robot_registry import RobotRegistry
from tests.fakes.charging import BATTERY
from tests.fakes.navigation import without_lidar
from tests.fakes.own_robots import Own, box, caster, inertial, lidar, link, pair, robot

WAFFLE, BURGER = "turtlebot3_waffle", "turtlebot3_burger"
FREE = Pose(3.0, 3.0, 1.0)


def make_crew():
    robots = tuple(RobotEntry(f"Srobot{i}", WAFFLE) for i in (1, 2))
    setup, world = build(Settings(world="slim_blockage", robots=robots, engine="planar"))
    return RobotRegistry(world, setup.grid, setup.starts, "")


@pytest.fixture
def robots():
    return make_crew()


def spawn(robots, name, rename, model, pose):
    return robots.spawn(name, rename, model, read_robot(model), pose)


def refused(do):
    with pytest.raises(RefusedError) as caught:
        do()
    return caught.value


def test_a_robot_gets_the_next_number_and_a_place_of_its_own(robots):
    first = spawn(robots, "", False, BURGER, FREE)
    second = spawn(robots, "", False, WAFFLE, None)
    assert (first.name, first.number, first.index) == ("Srobot3", 3, 2)
    assert second.name == "Srobot4"
    assert robots.robots == ["Srobot1", "Srobot2", "Srobot3", "Srobot4"]
    assert robots.spawned == ["Srobot3", "Srobot4"]
    robots.remove("Srobot3")
    assert robots.robots == ["Srobot1", "Srobot2", "Srobot4"]
    assert spawn(robots, "", False, WAFFLE, None).name == "Srobot5"  # numbers are not used twice


def test_a_robot_comes_back_with_the_battery_that_its_fleet_gave_it():
    battery = parse_battery({name: BATTERY[name] for name in BATTERY if name != "initial"}, "")
    entries = (RobotEntry("Srobot1", WAFFLE, battery=battery), RobotEntry("Srobot2", WAFFLE))
    setup, world = build(Settings(world="slim_blockage", robots=entries, engine="planar"))
    robots = RobotRegistry(world, setup.grid, setup.starts, "")
    for _ in range(100):
        world.step([Twist()] * 2, [None] * 2)
    before = world.verdict.robots["Srobot1"].battery
    assert before.energy_used == pytest.approx(50.0 / 3600.0)
    robots.remove("Srobot1")
    for _ in range(100):
        world.step([Twist()] * 2, [None] * 2)
    assert spawn(robots, "Srobot1", False, WAFFLE, None).index == 0
    assert world.specs[0].battery == battery
    assert world.verdict.robots["Srobot1"].battery == before
    assert spawn(robots, "", False, WAFFLE, None).name == "Srobot3"
    world.step([Twist()] * 3, [None] * 3)
    assert world.verdict.robots["Srobot3"].battery is None


def test_a_name_can_come_back_with_the_same_model_only(robots):
    robots.remove("Srobot2")
    error = refused(lambda: spawn(robots, "Srobot2", False, BURGER, FREE))
    assert error.reason is Reason.NAME_TAKEN
    assert "was a turtlebot3_waffle" in str(error)
    again = spawn(robots, "Srobot2", False, WAFFLE, FREE)
    assert (again.index, again.pose_map) == (1, FREE)
    assert robots.robots == ["Srobot1", "Srobot2"]


def test_a_robot_that_does_not_drive_does_not_come(tmp_path):
    robots = (RobotEntry("Srobot1", WAFFLE),)
    setup, world = build(Settings(world="hall_12", robots=robots, engine="bullet"))
    robots = RobotRegistry(world, setup.grid, setup.starts, "")
    heavy = link("base_link", box(0.4, 0.26, 0.1), inertial(6.0, 5000.0), xyz="0 0 0.1")
    own = Own(robot("heavy", [heavy, *pair(), caster("caster", -0.15), lidar()]))
    path = str(own.write(tmp_path))
    error = refused(lambda: spawn(robots, "", False, path, FREE))
    world.close()
    assert error.reason is Reason.BAD_MODEL
    assert "Cause: inertia" in str(error)
    assert robots.robots == ["Srobot1"]


@pytest.mark.parametrize("name", ["Hans", "Srobot", "Srobot0", "Srobot99999", "robot1", "/Srobot5"])
def test_names_that_no_robot_may_have(robots, name):
    assert refused(lambda: spawn(robots, name, True, WAFFLE, FREE)).reason is Reason.NAME_INVALID


def test_own_names_go_on_by_the_pattern_of_the_run():
    entries = tuple(RobotEntry(name, WAFFLE) for name in ("amr_beta", "amr_alpha"))
    settings = Settings(world="slim_blockage", robots=entries, engine="planar", pattern="agv{:02}")
    setup, world = build(settings)
    robots = RobotRegistry(world, setup.grid, setup.starts, "", settings.names)
    error = refused(lambda: spawn(robots, "Srobot3", False, WAFFLE, FREE))
    assert error.reason is Reason.NAME_INVALID
    assert "expected amr_beta and amr_alpha, or agv03 to agv65535" in str(error)
    named = spawn(robots, "agv05", False, WAFFLE, FREE)
    assert (named.name, named.number) == ("agv05", 5)
    assert spawn(robots, "", False, WAFFLE, None).number == 6
    robots.remove("amr_beta")
    again = spawn(robots, "amr_beta", False, WAFFLE, None)
    assert (again.index, again.number) == (0, 1)
    assert robots.robots == ["amr_beta", "amr_alpha", "agv05", "agv06"]


@pytest.mark.parametrize("name", ["walker_1", "slim_blockage"])
def test_no_robot_is_called_like_something_of_the_world(name):
    people = find_world("slim_blockage", "people.yaml")
    entries = (RobotEntry(name, WAFFLE),)
    settings = Settings(world="slim_blockage", robots=entries, engine="planar", actors=str(people))
    with pytest.raises(ConfigError, match=f"are both called '{name}'"):
        build(settings)


def test_bad_input_changes_nothing(robots, tmp_path):
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot", encoding="utf-8")
    cases: list[tuple[Callable[[], object], Reason, str]] = [
        (
            lambda: spawn(robots, "Srobot2", False, WAFFLE, FREE),
            Reason.NAME_TAKEN,
            "Srobot3 would be",
        ),
        (lambda: spawn(robots, "", False, "", FREE), Reason.NO_MODEL, "no robot model"),
        (lambda: spawn(robots, "", False, "turtlebot9", FREE), Reason.BAD_MODEL, "did you mean"),
        (lambda: spawn(robots, "", False, str(broken), FREE), Reason.BAD_MODEL, "broken.urdf"),
        (lambda: spawn(robots, "", False, WAFFLE, Pose(99.0, 0, 0)), Reason.BAD_PLACE, "99.00"),
        (
            lambda: spawn(robots, "", False, WAFFLE, Pose(math.inf, 0, 0)),
            Reason.BAD_PLACE,
            "out of",
        ),
        (lambda: spawn(robots, "", False, WAFFLE, Pose(0, 1e308, 0)), Reason.BAD_PLACE, "out of"),
        (
            lambda: spawn(robots, "", False, WAFFLE, Pose(0, 0, math.nan)),
            Reason.BAD_PLACE,
            "no place",
        ),
        (lambda: spawn(robots, "", False, WAFFLE, Pose(12, 0, 0)), Reason.BAD_PLACE, "no free"),
        (
            lambda: spawn(robots, "", False, WAFFLE, Pose(-1.4, -0.6, 0)),
            Reason.BAD_PLACE,
            "Srobot1",
        ),
        (lambda: robots.remove("Srobot7"), Reason.UNKNOWN, "there are Srobot1, Srobot2"),
        (lambda: robots.move("Srobot7", FREE), Reason.UNKNOWN, "no 'Srobot7'"),
        (lambda: robots.move("Srobot1", Pose(0.1, -0.6, 0)), Reason.BAD_PLACE, "Srobot2 stands"),
    ]
    for do, reason, words in cases:
        error = refused(do)
        assert error.reason is reason, error
        assert words in str(error)
    assert robots.robots == ["Srobot1", "Srobot2"]


def test_all_go_home(robots):
    robots.move("Srobot1", FREE)
    spawn(robots, "", False, WAFFLE, Pose(-1.4, -0.6, 0.0))  # where Srobot1 was
    error = refused(robots.send_home)
    assert error.reason is Reason.BAD_PLACE
    assert "nothing was moved" in str(error)
    robots.remove("Srobot3")
    homes = robots.send_home()
    assert [robot for robot, _ in homes] == [0, 1]
    assert homes[0][1].distance(Pose(-1.4, -0.6, 0.0)) < 1e-9


def test_nobody_meets_a_robot_that_does_not_know_yet_where_it_was_put():
    """Others had forgotten it meanwhile, and no LiDAR saw it: they drove into it."""
    entries = tuple(RobotEntry(f"Srobot{i}", WAFFLE) for i in (1, 2))
    setup, world = build(Settings(world="hall_12", robots=entries, engine="planar"))
    robots = RobotRegistry(world, setup.grid, setup.starts, "")
    starts = {"Srobot1": Pose(-3.0, 0.0, 0.0), "Srobot2": Pose(0.0, 3.0, 0.0)}
    for name, pose in starts.items():
        robots.move(name, pose)
    navigators = [
        Navigator(without_lidar(), spec, setup.grid, Sites(), number, pose)
        for number, (spec, pose) in enumerate(zip(world.specs, starts.values(), strict=True), 1)
    ]
    goal = Pose(3.0, 0.0, 0.0)
    navigators[0].set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(goal,)))
    while goal.distance(Pose(*world.poses[0].tolist())) > 0.3:
        assert world.tick < 600
        if world.tick == 20:
            robots.move("Srobot2", Pose(0.0, 0.0, 0.0))
        outputs = []
        for navigator, seen in zip(navigators, world.observe(), strict=True):
            navigator.on_odom(seen.odom)
            navigator.on_reception(seen.reception)
            outputs.append(navigator.tick(world.tick))
        commands, beacons = [o.twist for o in outputs], [o.beacon for o in outputs]
        if world.tick >= 20:  # as `Moves.hold` has it
            commands[1], beacons[1] = Twist(), None
        assert world.step(commands, beacons) == []
    world.close()
