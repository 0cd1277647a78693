from pathlib import Path

import pytest

from swarm_commander.leg import HOME
from swarm_commander.mission import load_mission, mission_path, single_goal
from swarm_common.errors import ConfigError, SwarmError, UnknownNameError
from swarm_common.records import Pose
from swarm_common.resources import find_resource
from swarm_common.sites import Sites
from swarm_common.sites_io import load_sites

HOME_POSE = Pose(1.0, 2.0, 3.0)
LOADERS = [f"loader_{number}" for number in range(1, 7)]


@pytest.fixture(scope="module")
def hall() -> Sites:
    return load_sites(find_resource("world", "slim_blockage", "world.sdf").parent / "sites.yaml")


def stops(sites: Sites, **changes: int) -> list[str]:
    values = {"seed": 0, "robot_id": 1} | changes
    return [s.name for s in load_mission("loading_route").stops(sites, HOME_POSE, **values)]


def test_the_loading_route_has_eight_goals_that_end_at_home(hall: Sites) -> None:
    names = stops(hall)
    assert sorted(names[:6]) == LOADERS
    assert names[6:] == ["shipping", HOME]


def test_the_order_depends_on_seed_and_robot_and_on_nothing_else(hall: Sites) -> None:
    assert stops(hall) == stops(hall)
    orders = {tuple(stops(hall, seed=s, robot_id=r)) for s in range(5) for r in range(1, 5)}
    assert len(orders) > 15


def test_each_lap_has_an_order_of_its_own(hall: Sites) -> None:
    names = stops(hall, laps=3)
    assert len(names) == 24
    assert names[:8] == stops(hall)
    assert not names[:6] == names[8:14] == names[16:22]


def test_a_limit_cuts_the_route(hall: Sites) -> None:
    assert stops(hall, limit=3) == stops(hall)[:3]
    assert len(stops(hall, limit=100)) == 8


def test_a_loader_is_left_after_two_ticks(hall: Sites) -> None:
    mission = load_mission("loading_route")
    pauses = [stop.pause_ticks for stop in mission.stops(hall, HOME_POSE, seed=0, robot_id=1)]
    assert pauses == [2, 2, 2, 2, 2, 2, 0, 0]


def test_home_is_the_pose_given(hall: Sites) -> None:
    assert load_mission("loading_route").stops(hall, HOME_POSE, seed=0, robot_id=1)[
        -1
    ].pose_map == (HOME_POSE)


def test_a_single_goal_needs_no_sites() -> None:
    (stop,) = single_goal(Pose(1.5, 2.0, 0.0)).stops(Sites(), HOME_POSE, seed=0, robot_id=1)
    assert stop.pose_map == Pose(1.5, 2.0, 0.0)


def test_a_station_that_the_world_lacks_is_named_with_the_closest() -> None:
    sites = Sites(stations={"loader_one": HOME_POSE})
    with pytest.raises(UnknownNameError, match=r"loader_1.*sites\.yaml.*'loader_one'"):
        load_mission("loading_route").check_stations(sites, "sites.yaml")


def test_an_unknown_mission_is_named_with_the_closest() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'loading_route'"):
        mission_path("loading_rout")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("route: [", "line 1.*malformed"),
        ("rout: []", "unknown key 'rout'.*'route'"),
        ("route: 5", "route is 5; expected a list"),
        ("route: []", "empty"),
        ("route:\n  - statoins: [a]", "leg 1.*'stations'"),
        ("route:\n  - home: true\n  - home: 3", "leg 2: home is 3"),
        ("route:\n  - home: true\n    pose: [1, 2, 3]", "exactly one of"),
        ("route:\n  - pose: [1, 2]", "pose.*3 numbers"),
        ("route:\n  - pose: [1, 2, x]", "expected a number"),
        ("route:\n  - stations: [a]\n    order: randm", "did you mean 'random'"),
        ("route:\n  - stations: [a]\n    pause: -1", "pause is -1"),
        ("route:\n  - stations: loader_1", "list of names"),
        ("retries: yes\nroute:\n  - home: true", "retries is True"),
        ("retries: -1\nroute:\n  - home: true", "retries is -1"),
        ("route: []\nroute: []", "line 2.*twice"),
    ],
)
def test_a_faulty_file_is_refused_with_file_and_place(
    tmp_path: Path, text: str, message: str
) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match="(?s)" + message) as caught:
        load_mission(str(path))
    assert "mine.yaml" in str(caught.value)


def test_a_file_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(SwarmError, match=r"none\.yaml"):
        load_mission(str(tmp_path / "none.yaml"))
