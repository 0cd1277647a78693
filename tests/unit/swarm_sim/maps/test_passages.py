"""Robots that are too wide for every way to a station."""

import dataclasses
import re
from pathlib import Path

import pytest

from swarm_common.model.errors import ConfigError, WorldError
from swarm_common.model.records import Pose
from swarm_common.model.sites import SpawnArea, SpawnCircle
from swarm_common.model.zones import KeepoutZone, Zones
from swarm_describe.robots.fleet import load_fleet
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.source import robot_names
from swarm_describe.worlds.reader import load_world
from swarm_sim.maps.check import check_sites
from swarm_sim.maps.passages import Ways, check_ways, needed_width
from swarm_sim.maps.spawn import deal_places

WAFFLE, BURGER = load_robot("turtlebot3_waffle"), load_robot("turtlebot3_burger")


def square(half):
    corners = ((-half, -half), (half, -half), (half, half), (-half, half))
    return dataclasses.replace(WAFFLE, model="square", footprint=corners)


def test_a_robot_too_wide_or_behind_walls_has_no_way():
    scene = load_world("doorway")  # its door is 0.70 m wide
    start = [Pose(-4.0, 0.0, 0.0)]
    check_ways(scene, [WAFFLE], start)
    with pytest.raises(WorldError) as caught:
        check_ways(scene, [square(0.27)], start)
    message = str(caught.value)
    assert message.startswith("no square can get from its start at (-4.00, 0.00) to station 'east_")
    assert message.endswith("this robot needs 0.84 m")
    passage = Ways(scene, WAFFLE.height).narrowest(start[0], Pose(4.0, 0.0, 0.0))
    assert passage.width == pytest.approx(0.70, abs=0.05)
    assert abs(passage.x) < 0.15
    assert abs(passage.y) < 0.1
    scene = load_world("slim_blockage")
    sites = dataclasses.replace(scene.sites, stations={"inside": Pose(6.5, -3.0, 0.0)})
    closed = dataclasses.replace(scene, sites=sites)
    with pytest.raises(WorldError, match="no way at all"):
        check_ways(closed, [BURGER], [Pose(0.0, 0.0, 0.0)])


def test_groups_start_where_they_are_told_if_they_fit():
    scene = load_world("slim_blockage")
    area = SpawnArea(4.5, 2.0, 8.5, 4.0, 1.0, 0.5)
    poses = deal_places(scene, [BURGER, WAFFLE, BURGER], [area, "", area], WAFFLE)
    assert [poses[i].x > 4.4 for i in range(3)] == [True, False, True]
    assert poses[0].yaw == 0.5
    scene = load_world("slim_blockage")
    area = SpawnArea(4.5, 2.0, 5.5, 3.0)
    with pytest.raises(WorldError, match="has room for 4 robots of model turtlebot3_burger; 5"):
        deal_places(scene, [BURGER] * 5, [area] * 5, WAFFLE)
    scene = load_world("slim_blockage")
    areas = [SpawnArea(4.5, 2.0, 8.5, 4.0), SpawnArea(4.6, 2.0, 8.5, 4.0)]
    with pytest.raises(WorldError, match=r"robots 1 and 2 would overlap .*, at \(4\.60, 2\.00\)"):
        deal_places(scene, [BURGER] * 2, areas, BURGER)


def test_starts_of_a_fleet_are_checked(tmp_path_factory):
    path = tmp_path_factory.mktemp("fleet") / "fleet.yaml"
    group = "groups: [{model: turtlebot3_burger, count: 2, start: %s}]"
    path.write_text(group % "{x_min: 0, y_min: 0, x_max: 3, y_max: 3}")
    assert load_fleet(path).members[1].start == {"x_min": 0, "y_min": 0, "x_max": 3, "y_max": 3}
    path.write_text(group % "{x_min: 0, y_min: 0, x_max: -3, y_max: 3}")
    with pytest.raises(ConfigError, match=r"groups\[0\]: start: it is empty"):
        load_fleet(path)


def test_the_document_has_the_widths_that_the_models_need():
    text = (Path(__file__).parents[4] / "docs" / "robots.md").read_text("utf-8")
    head, _, *rows = text.split("\n\n")[1].splitlines()
    column = [name.strip() for name in head.split("|")].index("door [m]")
    told = {
        name: float(row.split("|")[column]) for row in rows for name in re.findall(r"`(\w+)`", row)
    }
    assert set(told) == set(robot_names())
    for name, width in told.items():
        assert width == pytest.approx(needed_width(load_robot(name)), abs=0.006), name


def with_keepout(world, *corners):
    scene = load_world(world)
    zones = Zones(keepout=(KeepoutZone("k", corners),))
    return dataclasses.replace(scene, sites=dataclasses.replace(scene.sites, zones=zones))


def test_a_station_behind_or_too_near_to_a_keepout_zone_is_told():
    scene = with_keepout("doorway", (-0.2, -4.0), (0.2, -4.0), (0.2, 4.0), (-0.2, 4.0))
    with pytest.raises(WorldError, match="keepout zones counted as walls: there is no way at all"):
        check_ways(scene, [WAFFLE], [Pose(-4.0, 0.0, 0.0)])
    half = with_keepout("doorway", (-0.2, -4.0), (0.2, -4.0), (0.2, 0.0), (-0.2, 0.0))
    with pytest.raises(WorldError, match=r"a passage of about 0\.3. m") as caught:
        check_ways(half, [WAFFLE], [Pose(-4.0, 0.0, 0.0)])
    assert "keepout zones counted as walls" in str(caught.value)
    near = (-7.6, 0.5), (-7.0, 0.5), (-7.0, 1.5), (-7.6, 1.5)
    with pytest.raises(ConfigError, match=r"loader_3.* lies 0\.146 m from a keepout zone"):
        check_sites(with_keepout("slim_blockage", *near), WAFFLE)


def test_nobody_starts_in_a_keepout_zone():
    box = (-1.0, -0.5), (3.0, -0.5), (3.0, 3.0), (-1.0, 3.0)
    scene = with_keepout("slim_blockage", *box)
    poses = deal_places(scene, [WAFFLE] * 20, [""] * 20, WAFFLE)
    need = WAFFLE.circumscribed_radius
    assert not any(-1 - need < p.x < 3 + need and -0.5 - need < p.y < 3 + need for p in poses)
    full = (-9.0, -5.0), (9.0, -5.0), (9.0, 9.0), (-9.0, 9.0)
    with pytest.raises(WorldError, match=r"in the way: .*keepout zones \("):
        deal_places(with_keepout("slim_blockage", *full), [WAFFLE], [""], WAFFLE)
    with pytest.raises(WorldError, match="spawn circle of world 'pillars' meets a keepout zone"):
        deal_places(with_keepout("pillars", *full), [WAFFLE], [SpawnCircle(0.0, 0.0, 3.0)], WAFFLE)
