"""Slabs carry robots; a slab that does not is named."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from swarm_common.model.errors import WorldError
from swarm_common.model.records import Pose, Twist
from swarm_common.model.shapes import Box, Mesh, Part
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.floor import on_floor
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Body, Scene
from swarm_describe.worlds.world_file import world_names
from swarm_sim.maps.draw_map import draw_world, reach_of
from swarm_sim.maps.spawn import spawn_poses
from swarm_sim.maps.world_check import differences
from swarm_sim.world.world import World, WorldConfig

WAFFLE = load_robot("turtlebot3_waffle")
BOX = (
    "<model name='{}'><static>1</static><pose>{} 0 0 0</pose><link name='l'><collision name='c'>"
    "<geometry><box><size>{}</size></box></geometry></collision></link></model>"
)
WALLS = BOX.format("east", "4 0 0.5", "0.2 8 1.2") + BOX.format("west", "-4 0 0.5", "0.2 8 1.2")


def world(folder, inside):
    path = folder / "slabs.world"
    path.write_text(f"<sdf version='1.6'><world name='w'>{inside}</world></sdf>")
    return load_world(path)


def tiles(height):
    return "".join(
        BOX.format(f"tile_{i}_{j}", f"{i - 3.5} {j - 3.5} {height / 2}", f"1 1 {height}")
        for i in range(8)
        for j in range(8)
    )


@pytest.mark.parametrize("height", [0.005, 0.006, 0.02, 0.05, 0.1])
@pytest.mark.parametrize("kind", ["slab", "tiles"])
@pytest.mark.parametrize("engine", ["planar", "bullet"])
def test_robots_stand_and_drive_on_a_slab(tmp_path, height, kind, engine):
    slab = BOX.format("asphalt", f"0 0 {height / 2}", f"9 9 {height}")
    scene = world(tmp_path, (slab if kind == "slab" else tiles(height)) + WALLS)
    assert f"{height:.3f} m high" in scene.notes[-1]
    assert len(spawn_poses(scene, WAFFLE, 5)) == 5
    grid = draw_world(scene, reach=reach_of([WAFFLE]))
    assert 0.0 < (grid.cells == 100).mean() < 0.1
    start = Pose(2.0, 0.0, 0.0)
    robots = World(scene, [WAFFLE], [start], WorldConfig(engine=engine, with_lidar=False), 0)
    for _ in range(40):
        robots.step([Twist(0.26)], [None])
    assert robots.poses[0, 0] == pytest.approx(3.0, abs=0.05)
    assert robots.verdict.robot_world == 0
    for _ in range(60):
        robots.step([Twist(0.26)], [None])
    assert [c.obstacle for c in robots.verdict.collisions] == ["east::l"]
    robots.close()


@pytest.mark.parametrize("height", [0.0, 0.05])
def test_a_mesh_may_have_floor_and_walls_in_one(height):
    floor = trimesh.creation.box((9.0, 9.0, 0.1))
    floor.apply_translation((0.0, 0.0, height - 0.05))
    wall = trimesh.creation.box((0.2, 9.0, 1.0))
    wall.apply_translation((3.0, 0.0, 0.5))
    mesh = trimesh.util.concatenate([floor, wall])
    part = Part(Mesh(np.array(mesh.vertices), np.array(mesh.faces, np.int64)), np.eye(4))
    house = Body("house::link", np.eye(4), (part,))
    scene = on_floor(Scene("house", Path("house.sdf"), (house,)))
    robots = World(scene, [WAFFLE], [Pose(0.0, 0.0, 0.0)], WorldConfig(with_lidar=False), 0)
    for _ in range(80):
        robots.step([Twist(0.26)], [None])
    assert robots.verdict.robot_world == 0
    for _ in range(60):
        robots.step([Twist(0.26)], [None])
    assert robots.verdict.robot_world == 1
    robots.close()
    assert list(differences(scene, [0.132], (0.005, 0.141), with_physics=True)) == []


def test_what_is_no_floor_is_named_and_nothing_moved(tmp_path):
    stage = BOX.format("stage", "0 0 0.1", "5 5 0.2")  # most of the start, little of the world
    far = BOX.format("north", "0 15 0.5", "30 0.2 1") + BOX.format("south", "0 -15 0.5", "30 0.2 1")
    (tmp_path / "sites.yaml").write_text("spawn: {x_min: -2, y_min: -2, x_max: 2, y_max: 2}")
    scene = world(tmp_path, stage + far)
    with pytest.raises(WorldError, match=r"room for 0 robots.*in the way: 'stage::l' \(\d+ of"):
        spawn_poses(scene, WAFFLE, 5)
    plate = BOX.format("table", "0 0 0.5", "9 9 0.05")
    assert not world(tmp_path, plate).notes
    ramp = plate.replace("0 0 0.5 0 0 0", "0 0 0.1 0 0.05 0")
    assert not world(tmp_path, ramp).notes
    body = Body("b::l", np.eye(4), (Part(Box((1.0, 1.0, 1.0)), np.eye(4)),))
    scene = Scene("s", Path("s.sdf"), (body,))
    assert on_floor(scene) is scene


@pytest.mark.parametrize("name", world_names())
def test_worlds_that_ship_stand_on_the_ground(name):
    scene = load_world(name)
    assert not any("lowered" in note for note in scene.notes)
