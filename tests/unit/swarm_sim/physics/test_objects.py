"""Things that can be pushed, forklifts, and concave meshes in both engines."""

import math
from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh
from msgspec.structs import replace

from swarm_common.model.errors import ConfigError, WorldError
from swarm_common.model.records import Pose, Twist
from swarm_common.model.shapes import Box, Mesh, Part, transform_from_xyz_rpy
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.actors import VehicleSpec, load_actors
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Body, Scene
from swarm_sim.maps.check import check_vehicles
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.world import World, WorldConfig

SPEC = load_robot("turtlebot3_waffle")
ORIGIN = transform_from_xyz_rpy(0, 0, 0, 0, 0, 0)
FORKLIFT = VehicleSpec(name="truck", path=((2.0, 0.0), (8.0, 0.0)), start=0.0, pause=0.5)


def crate(x, size=0.4, mass=1.0, friction=0.3):
    place = transform_from_xyz_rpy(x, 0, size / 2, 0, 0, 0)
    part = Part(Box((size, size, size)), ORIGIN)
    return Body("crate::link", place, (part,), is_static=False, mass=mass, friction=friction)


def scene_of(*bodies, vehicles=()):
    return Scene("field", Path("world.sdf"), bodies, vehicles=vehicles)


def world_of(scene, engine="bullet", x=0.0):
    return World(scene, [SPEC], [Pose(x, 0.0, 0.0)], WorldConfig(engine=engine))


def drive(world, seconds, speed):
    for _ in range(round(seconds * 10)):
        world.observe()
        world.step([Twist(speed, 0.0, 0.0)], [None])


def test_a_light_box_is_pushed_and_a_heavy_one_stays():
    world = world_of(scene_of(crate(0.8)))
    drive(world, 6.0, 0.26)
    (box,) = world.objects()
    assert box.world_from_body[0, 3] > 1.0
    assert box.world_from_body[2, 3] == pytest.approx(0.2, abs=0.01)
    assert [collision.obstacle for collision in world.collisions] == ["crate::link"]
    world.close()
    world = world_of(scene_of(crate(0.8, mass=200.0, friction=1.0)))
    drive(world, 6.0, 0.26)
    (box,) = world.objects()
    assert box.world_from_body[0, 3] == pytest.approx(0.8, abs=0.02)
    assert world.poses[0, 0] < 0.55
    world.close()


@pytest.mark.parametrize("engine", ["bullet", "planar"])
def test_lidars_see_boxes_and_forklifts(engine):
    world = world_of(scene_of(crate(1.5)), engine)
    (seen,) = world.observe()
    lidar_x = SPEC.lidar.x
    assert seen.scan.ranges[0] == pytest.approx(1.3 - lidar_x, abs=0.06)
    assert world.clearances[0, 1] == math.inf
    world.close()
    world = world_of(scene_of(vehicles=(replace(FORKLIFT, pause=100.0),)), engine)
    (seen,) = world.observe()
    assert seen.scan.ranges[0] == pytest.approx(2.0 - 1.1 - SPEC.lidar.x, abs=0.06)
    world.close()


def test_a_box_inside_a_wall_is_refused_and_one_that_reaches_into_it_pushed_out():
    wall = Body("wall::link", ORIGIN, (Part(Box((0.2, 4.0, 2.0)), ORIGIN),))
    with pytest.raises(WorldError, match=r"'crate::link' reaches 0\.\d+ m into 'wall::link'"):
        world_of(scene_of(wall, crate(0.1)), x=-2.0)
    wall = Body("wall::link", ORIGIN, (Part(Box((0.2, 4.0, 2.0)), ORIGIN),))
    world = world_of(scene_of(wall, crate(0.25)), x=-2.0)
    drive(world, 2.0, 0.0)
    (box,) = world.objects()
    assert box.world_from_body[0, 3] == pytest.approx(0.3, abs=0.02)  # it touches the wall
    assert abs(box.world_from_body[1, 3]) < 0.02
    world.close()


@pytest.mark.parametrize("engine", ["bullet", "planar"])
def test_a_forklift_drives_to_and_fro(engine):
    world = world_of(scene_of(vehicles=(FORKLIFT,)), engine)
    places = []
    for _ in range(200):
        drive(world, 0.1, 0.0)
        (truck,) = world.objects()
        places.append(float(truck.world_from_body[0, 3]))
    assert max(places) == pytest.approx(8.0, abs=0.01)
    assert min(places[100:]) == pytest.approx(2.0, abs=0.3)  # and back again
    assert world.objects()[0].world_from_body[0, 0] == pytest.approx(1.0)  # backwards
    steps = np.abs(np.diff(places))
    assert steps.max() <= 0.1 + 1e-9
    assert not world.collisions
    world.close()


@pytest.mark.parametrize("engine", ["bullet", "planar"])
def test_a_forklift_waits_for_a_robot_that_stands_and_turns_round(engine):
    truck = replace(FORKLIFT, path=((3.0, 0.0), (-3.0, 0.0)), patience=2.0)
    world = world_of(scene_of(vehicles=(truck,)), engine)
    places = []
    for _ in range(120):
        drive(world, 0.1, 0.0)
        places.append(float(world.objects()[0].world_from_body[0, 3]))
    assert 1.1 < min(places) < 2.7  # half its length, and a step
    assert max(places[20:]) == pytest.approx(3.0, abs=0.1)
    assert not world.collisions
    world.close()


def test_a_forklift_gets_away_from_a_robot_that_stands_close_beside_it():
    scene = scene_of(vehicles=(FORKLIFT,))
    beside = 0.5 * FORKLIFT.width + 0.05 + max(y for _, y in SPEC.footprint)
    world = ChangingWorld(scene, [SPEC], [Pose(-5.0, 0.0, 0.0)], WorldConfig(engine="planar"))
    assert world.objects()[0].world_from_body[0, 3] == 2.0
    world.place(0, Pose(2.0, beside, 0.0))
    drive(world, 4.0, 0.0)
    assert world.objects()[0].world_from_body[0, 3] > 4.0
    assert not world.collisions


@pytest.mark.parametrize("engine", ["bullet", "planar"])
def test_a_robot_in_a_concave_mesh_touches_its_wall_only(engine):
    outline = shapely.Polygon([(-2, -1), (1, -1), (1, 1), (-2, 1)])
    room = shapely.difference(
        outline, shapely.Polygon([(-2, -0.8), (0.8, -0.8), (0.8, 0.8), (-2, 0.8)])
    )
    solid = trimesh.creation.extrude_polygon(room, 1.0)
    mesh = Mesh(np.array(solid.vertices), np.array(solid.faces), "room")
    world = world_of(scene_of(Body("room::link", ORIGIN, (Part(mesh, ORIGIN),))), engine)
    assert world.observe()[0].scan.ranges[0] == pytest.approx(0.8 - SPEC.lidar.x, abs=0.06)
    drive(world, 2.0, 0.26)
    assert not world.collisions
    drive(world, 3.0, 0.26)
    assert [collision.obstacle for collision in world.collisions] == ["room::link"]
    assert world.poses[0, 0] < 0.75
    world.close()


def test_actors_from_yaml_need_room_to_turn(tmp_path):
    path = tmp_path / "actors.yaml"
    path.write_text("forklifts:\n  - {path: [[0, 0], [5, 0]], length: 3, speed: 0.5}\n")
    (truck,) = load_actors(path).vehicles
    assert (truck.name, truck.length, truck.speed) == ("forklift_1", 3.0, 0.5)
    path.write_text("forklifts:\n  - {path: [[0, 0], [5, 0]], length: 99}\n")
    with pytest.raises(ConfigError, match="length is 99"):
        load_actors(path)
    hall = load_world("hall_12")
    check_vehicles(hall, [replace(FORKLIFT, path=((-4.0, 0.0), (4.0, 0.0)))])
    with pytest.raises(ConfigError, match="does not fit"):
        check_vehicles(hall, [replace(FORKLIFT, path=((-4.0, 0.0), (5.0, 0.0)))])
