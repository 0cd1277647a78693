import math

import pytest

from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites, SpawnArea, SpawnAreas
from swarm_common.model.zones import KeepoutZone, Zones
from swarm_describe.worlds.world_file import find_world
from swarm_mission.leg import HOME
from swarm_mission.mission import load_mission, single_goal, usual_mission

HOME_POSE = Pose(1.0, 2.0, 3.0)
LOADERS = [f"loader_{number}" for number in range(1, 7)]


@pytest.fixture(scope="module")
def hall():
    return load_sites(find_world("slim_blockage").parent / "sites.yaml")


def stops(sites, **changes):
    values = {"seed": 0, "robot_id": 1} | changes
    return [s.name for s in load_mission("loading_route").stops(sites, HOME_POSE, **values)]


def test_the_loading_route_has_eight_goals_that_end_at_home(hall):
    names = stops(hall)
    assert sorted(names[:6]) == LOADERS
    assert names[6:] == ["shipping", HOME]


def test_the_order_depends_on_seed_robot_and_lap(hall):
    assert stops(hall) == stops(hall)
    orders = {tuple(stops(hall, seed=s, robot_id=r)) for s in range(5) for r in range(1, 5)}
    assert len(orders) > 15
    names = stops(hall, laps=3)
    assert len(names) == 24
    assert names[:8] == stops(hall)
    assert not names[:6] == names[8:14] == names[16:22]
    assert stops(hall, limit=3) == stops(hall)[:3]
    assert len(stops(hall, limit=100)) == 8


def test_a_loader_is_left_and_home_is_the_pose_given(hall):
    mission = load_mission("loading_route")
    pauses = [stop.pause_ticks for stop in mission.stops(hall, HOME_POSE, seed=0, robot_id=1)]
    assert pauses == [2, 2, 2, 2, 2, 2, 0, 0]
    assert load_mission("loading_route").stops(hall, HOME_POSE, seed=0, robot_id=1)[
        -1
    ].pose_map == (HOME_POSE)
    (stop,) = single_goal(Pose(1.5, 2.0, 0.0)).stops(Sites(), HOME_POSE, seed=0, robot_id=1)
    assert stop.pose_map == Pose(1.5, 2.0, 0.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("route: [", "line 1.*malformed"),
        ("route: []", "empty"),
        ("route:\n  - home: true\n  - home: 3", r"line 3: route\[1\].home is 3; expected true"),
        ("route:\n  - home: true\n    pose: [1, 2, 3]", "exactly one of"),
        ("retries: yes\nroute:\n  - home: true", "retries is True"),
    ],
)
def test_a_faulty_file_is_refused_with_file_and_place(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match="(?s)" + message) as caught:
        load_mission(str(path))
    assert "mine.yaml" in str(caught.value)


# Missions in which robots change places or roam

RING = [Pose(float(k), 0.0, 0.5) for k in range(5)]


def own_mission(folder, text):
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return load_mission(str(path))


def test_robots_cross_over_knowing_other_homes(tmp_path):
    mission = own_mission(tmp_path, "route:\n  - swap: opposite")
    (stop,) = mission.stops(Sites(), RING[1], seed=0, robot_id=2, homes_map=RING)
    assert stop.name == "home of Srobot4"
    assert (stop.pose_map.x, stop.pose_map.y) == (3.0, 0.0)
    assert stop.pose_map.yaw == pytest.approx(0.5 - math.pi)
    mission = own_mission(tmp_path, "route:\n  - swap: opposite")
    with pytest.raises(ConfigError, match="swarm-up --mission"):
        mission.stops(Sites(), HOME_POSE, seed=0, robot_id=1)


def test_robots_change_the_room(tmp_path):
    mission = own_mission(tmp_path, "spawn: rooms\nroute:\n  - swap: other_area")
    area = SpawnArea(0.0, 0.0, 1.0, 1.0)
    sites = Sites(spawns={"rooms": SpawnAreas((area, area))})
    mission.check_stations(sites, "sites.yaml")
    homes = [Pose(float(k % 2), float(k), 0.0) for k in range(8)]
    goals = [
        mission.stops(sites, home, seed=1, robot_id=k, homes_map=homes)[0].pose_map
        for k, home in enumerate(homes, 1)
    ]
    assert all(goal.x != home.x for goal, home in zip(goals, homes, strict=True))
    assert len({(goal.x, goal.y) for goal in goals}) == 8


def test_roaming_robots_get_different_places_and_laps_differ(tmp_path):
    mission = own_mission(tmp_path, "route:\n  - roam: 3\n    distance: 2.0\n    pause: 0.5")
    sites = Sites(places=tuple(Pose(float(k), 5.0, 0.0) for k in range(12)))
    routes = [
        mission.stops(sites, home, seed=3, robot_id=k, laps=2, homes_map=RING)
        for k, home in enumerate(RING, 1)
    ]
    assert all(len(route) == 6 and route[0].pause_ticks == 5 for route in routes)
    for step in zip(*routes, strict=True):
        assert len({stop.name for stop in step}) == 5
    crowd = [Pose(0.0, 0.0, 0.0)] * 13
    with pytest.raises(ConfigError, match="12 places for 13 roaming robots"):
        mission.stops(sites, crowd[0], seed=0, robot_id=1, homes_map=crowd)


def test_robots_set_off_one_after_the_other_if_told_to(tmp_path):
    mission = own_mission(tmp_path, "start_spread: 2.0\nroute:\n  - home: true\n  - home: true")
    delays = [
        [s.delay_ticks for s in mission.stops(Sites(), HOME_POSE, seed=0, robot_id=k)]
        for k in range(1, 30)
    ]
    assert {later for _, later in delays} == {0}
    assert min(delays)[0] < 4
    assert 16 < max(delays)[0] <= 20


def test_only_some_of_the_stations_may_be_taken(tmp_path):
    text = "route:\n  - stations: [a, b, c]\n    order: random\n    take: 1"
    mission = own_mission(tmp_path, text)
    sites = Sites(stations={name: HOME_POSE for name in "abc"})
    routes = [mission.stops(sites, HOME_POSE, seed=0, robot_id=k) for k in range(1, 20)]
    assert {tuple(stop.name for stop in route) for route in routes} == {("a",), ("b",), ("c",)}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("route:\n  - roam: -1", "roam is -1"),
        ("route:\n  - stations: [a]\n    take: 2", "take is 2; expected 1 to 1"),
        ("route:\n  - home: true\n    swap: opposite", "exactly one of"),
    ],
)
def test_faults_of_the_newer_kinds_are_refused(tmp_path, text, message):
    with pytest.raises(ConfigError, match="(?s)" + message) as caught:
        own_mission(tmp_path, text)
    assert "mine.yaml" in str(caught.value)


def test_a_mission_names_what_the_world_lacks(tmp_path):
    with pytest.raises(UnknownNameError, match="unknown spawn 'rooms'"):
        own_mission(tmp_path, "spawn: rooms\nroute:\n  - home: true").check_stations(Sites(), "w")
    with pytest.raises(ConfigError, match="needs 'places', which w does not have"):
        own_mission(tmp_path, "route:\n  - roam: 2").check_stations(Sites(), "w")
    with pytest.raises(ConfigError, match="needs a spawn of several areas, which w does not have"):
        own_mission(tmp_path, "route:\n  - swap: other_area").check_stations(Sites(), "w")


def test_a_robot_without_a_mission_goes_to_what_its_world_has(hall):
    assert usual_mission(hall, "").name == "loading_route"
    folder = find_world("slim_blockage").parents[1]
    for path in sorted(folder.glob("*/sites.yaml")):
        sites = load_sites(path)
        if not sites.stations and not sites.places:
            continue
        mission = usual_mission(sites, str(path))
        mission.check_stations(sites, str(path))
        assert len(mission.stops(sites, HOME_POSE, seed=0, robot_id=1)) > 1
    with pytest.raises(ConfigError, match="give --goal"):
        usual_mission(Sites(), "the world")


def test_a_goal_in_a_keepout_zone_is_refused_before_the_run(tmp_path):
    path = tmp_path / "tour.yaml"
    path.write_text("route:\n  - pose: [1, 1, 0]\n", encoding="utf-8")
    zone = KeepoutZone("press", ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)))
    mission = load_mission(str(path))
    mission.check_stations(Sites(), "sites.yaml")
    with pytest.raises(ConfigError, match=r"goal \(1, 1\) lies in keepout zone 'press' of sites"):
        mission.check_stations(Sites(zones=Zones(keepout=(zone,))), "sites.yaml")
