"""Spawn places: any number, touching nothing, off stations and circuits."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from swarm_common.files.map_io import save_map
from swarm_common.model.errors import MapError, UnknownNameError, WorldError
from swarm_common.model.grid import FREE
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites, SpawnArea, SpawnAreas, SpawnCircle
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.reader import load_world
from swarm_sim.maps.draw_map import draw_world
from swarm_sim.maps.spawn import (
    CIRCUIT_CLEARANCE,
    STATION_CLEARANCE,
    deal_places,
    spawn_poses,
    wall_distance,
)
from swarm_sim.ros.build import build
from swarm_sim.ros.settings import RobotEntry, Settings
from swarm_sim.scene.section import section_between

WAFFLE = load_robot("turtlebot3_waffle")
SLIM = load_world("slim_blockage")


@pytest.mark.parametrize("count", [*range(1, 101)])
def test_any_size_spawns_without_touching_anything(count):
    """The original fell back to 10 robots where no number from 2 to 10 divides the size."""
    poses = spawn_poses(SLIM, WAFFLE, count)
    assert len(poses) == count
    points = np.array([(pose.x, pose.y) for pose in poses])
    gaps = [a.distance(b) for a, b in combinations(poses, 2)]
    assert min(gaps, default=1.0) >= 0.7
    section = section_between(SLIM.bodies, 0.005, WAFFLE.height)
    assert wall_distance(points, section).min() > WAFFLE.circumscribed_radius + 0.1
    assert (points[:, 0] > -2.0).all()  # in the eastern hall


@pytest.mark.parametrize("count", [60, 80, 97, 100])
def test_spawn_places_keep_off_stations_and_circuits(count):
    """The original's grid covered unload from 60 robots on and shipping from 80 on."""
    for pose in spawn_poses(SLIM, WAFFLE, count):
        for station in SLIM.sites.stations.values():
            assert pose.distance(station) >= STATION_CLEARANCE
        corners = SLIM.sites.circuits["island"]
        for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
            for share in np.linspace(0.0, 1.0, 60):
                x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
                assert math.hypot(pose.x - x, pose.y - y) >= CIRCUIT_CLEARANCE - 1e-9


@pytest.mark.parametrize(
    "name", ["hall_12", "corridor", "crossing", "doorway", "u_shape", "pillars"]
)
@pytest.mark.parametrize("count", [1, 12, 24])
def test_small_worlds_have_room(name, count):
    assert len(spawn_poses(load_world(name), WAFFLE, count)) == count


def test_a_world_without_sites_has_places_up_to_a_number():
    bare = replace(SLIM, sites=Sites())
    poses = spawn_poses(bare, WAFFLE, 20)
    assert len(set(poses)) == 20
    assert not any(-5.2 < pose.x < -3.8 and -3.0 < pose.y < 7.4 for pose in poses)  # the island
    open_field = replace(SLIM, sites=Sites(), bodies=())
    assert len(spawn_poses(open_field, WAFFLE, 100)) == 100
    assert all(math.hypot(p.x, p.y) < 2.5 for p in spawn_poses(open_field, WAFFLE, 3))
    with pytest.raises(WorldError, match=r"room for \d+ robots .* 500 are asked for"):
        spawn_poses(SLIM, WAFFLE, 500)
    area = replace(SLIM.sites.spawn, x_min=4.0, y_min=-4.9, x_max=9.4, y_max=-1.0)
    inside = replace(SLIM, sites=replace(SLIM.sites, spawn=area))
    with pytest.raises(WorldError):
        spawn_poses(inside, WAFFLE, 20)


def test_the_map_of_an_open_world_reaches_beyond_the_robots():
    """They stood beside it, and could not be given goals."""
    open_field = replace(SLIM, sites=Sites(), bodies=())
    poses = spawn_poses(open_field, WAFFLE, 20)
    grid = draw_world(open_field, starts=poses)
    for pose in poses:
        for angle in np.arange(0.0, math.tau, 0.5):
            x, y = pose.x + 5.0 * math.cos(angle), pose.y + 5.0 * math.sin(angle)
            assert grid.contains(x, y)
            assert grid.cells[grid.cell_of(x, y)] == FREE
    inside = replace(SLIM, sites=Sites())
    walled = draw_world(inside, starts=spawn_poses(inside, WAFFLE, 20))
    assert walled.cells.shape == draw_world(inside).cells.shape


def test_a_start_beside_the_map_is_refused(tmp_path):
    world, plan = tmp_path / "field.sdf", tmp_path / "field.yaml"
    box = "<geometry><box><size>1 1 1</size></box></geometry>"
    world.write_text(
        "<sdf version='1.7'><world name='field'><model name='box'><static>1</static>"
        f"<pose>20 20 0.5 0 0 0</pose><link name='l'><collision name='c'>{box}</collision></link>"
        "</model></world></sdf>",
        encoding="utf-8",
    )
    save_map(draw_world(load_world(str(world))), plan)
    settings = Settings(
        robots=(RobotEntry("Srobot1", "turtlebot3_waffle"),),
        world=str(world),
        map=str(plan),
        engine="planar",
    )
    with pytest.raises(MapError, match=r"Srobot1 would .* beside the map .* from \(19.00, 19.00"):
        build(settings)


@pytest.mark.parametrize("count", [1, 2, 7, 20])
def test_robots_are_dealt_to_several_areas_in_turn(count):
    poses = spawn_poses(load_world("corridor"), WAFFLE, count, "both_rooms")
    assert len(set(poses)) == count
    assert all((pose.x > 0.0) == bool(index % 2) for index, pose in enumerate(poses))


def test_starts_that_overlap_or_are_near_a_station_are_refused():
    """Four robots started 0.2 m apart, and three collided in the first tick."""
    areas = tuple(SpawnArea(x, 0.0, x, 0.0, 1.0) for x in (0.0, 0.2))
    field = replace(SLIM, sites=Sites(spawn=SpawnAreas(areas)), bodies=())
    with pytest.raises(
        WorldError, match=r"robots 1 and 2 .* at \(0\.20, 0\.00\): give their start"
    ):
        deal_places(field, [WAFFLE] * 2, [""] * 2, WAFFLE)
    assert len(deal_places(field, [WAFFLE], [""], WAFFLE)) == 1
    # a robot that is added later takes a free one of them
    assert len(spawn_poses(field, WAFFLE, 2)) == 2
    sites = Sites(stations={"a": Pose(1.0, 0.0, 0.0)}, spawn=SpawnArea(0.5, 0.0, 0.5, 0.0, 1.0))
    field = replace(SLIM, sites=sites, bodies=())
    with pytest.raises(
        WorldError, match=r"stations, from which starts keep 1\.2 m, .*1 of 1 places"
    ):
        spawn_poses(field, WAFFLE, 1)


@pytest.mark.parametrize("count", [1, 8, 40])
def test_robots_stand_evenly_on_a_circle_and_face_its_centre(count):
    poses = spawn_poses(load_world("hall_12"), WAFFLE, count, "circle")
    assert len(poses) == count
    for index, pose in enumerate(poses):
        assert math.hypot(pose.x, pose.y) == pytest.approx(5.0)
        assert math.cos(pose.yaw - math.atan2(-pose.y, -pose.x)) == pytest.approx(1.0)
        if count > 1:
            gap = 10.0 * math.sin(math.pi / count)
            assert pose.distance(poses[index - 1]) == pytest.approx(gap)


def test_a_circle_that_is_full_or_meets_a_wall_is_refused():
    hall = load_world("hall_12")
    with pytest.raises(WorldError, match=r"circle .* room for 44 robots .* 45 are asked for"):
        spawn_poses(hall, WAFFLE, 45, "circle")
    wide = replace(hall, sites=Sites(spawn=SpawnCircle(0.0, 0.0, 5.9)))
    with pytest.raises(WorldError, match=r"meets an obstacle at \(5\.90, 0\.00\)"):
        spawn_poses(wide, WAFFLE, 4)
    with pytest.raises(UnknownNameError, match="did you mean 'circle'"):
        spawn_poses(hall, WAFFLE, 4, "cirle")
