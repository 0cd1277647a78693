"""What is made of a world is compared with its triangles, and who hides something is named."""

import itertools
from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh

from swarm_common.model.engines import BULLET, check_engine
from swarm_common.model.errors import WorldError
from swarm_common.model.shapes import Box, Cylinder, Part, Sphere, transform_from_xyz_rpy
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Body, Scene
from swarm_describe.worlds.world_file import world_names
from swarm_sim.maps import world_check
from swarm_sim.maps.spawn import wall_distance
from swarm_sim.maps.world_check import checked, differences, picture
from swarm_sim.scene import mesh_section
from swarm_sim.scene.section import section_between
from tests.fakes.gazebo_package import write_package
from tests.oracles.triangles import body_of
from tests.unit.swarm_sim.test_mesh_soups import double_faced, room, soup

REACH = (0.005, 0.192)
SCANS = (0.132, 0.182)


def found(scene):
    return list(differences(scene, SCANS, REACH, with_physics=True))


def scene_of(*bodies):
    return Scene("test", Path("test.sdf"), bodies)


@pytest.mark.parametrize("world", world_names())
def test_the_worlds_that_ship_are_as_their_files_have_them(world):
    assert found(load_world(world)) == []


def test_a_package_with_meshes_is(tmp_path):
    assert found(load_world(write_package(tmp_path))) == []


def test_every_shape_at_every_tilt():
    rng = np.random.default_rng(3)
    shapes = (Box((0.5, 0.3, 0.2)), Cylinder(0.2, 0.4), Sphere(0.3))
    bodies = []
    for index in range(30):
        place = transform_from_xyz_rpy(
            index, 0.0, *rng.uniform(-0.1, 0.3, 1), *rng.uniform(0, 3, 3)
        )
        part = Part(shapes[index % 3], np.eye(4))
        bodies.append(Body(f"thing_{index}::link", place, (part,)))
    assert found(scene_of(*bodies)) == []


@pytest.mark.parametrize("seed", range(8))
def test_soups(seed):
    rng = np.random.default_rng(seed)
    mesh = soup(rng, int(rng.integers(1, 60)))
    bodies = [body_of(double_faced(mesh), "soup::link"), body_of(room(4.0), "room::link")]
    assert found(scene_of(*bodies)) == []


def of_corners(*triangles):
    faces = np.arange(3 * len(triangles)).reshape(-1, 3)
    return trimesh.Trimesh(np.reshape(triangles, (-1, 3)), faces, process=False)


@pytest.mark.parametrize("width", [0.0, 1e-9, 1e-7, 1e-6, 5e-6, 2e-5, 1e-3])
@pytest.mark.parametrize("slope", [0.0, 0.5, 20.0])
def test_a_needle_that_pierces_the_plane_is_a_dot(width, slope):
    needle = of_corners([(0.0, 0.0, -1.0), (2.0 * slope, 0.0, 1.0), (2.0 * slope, width, 1.0)])
    assert found(scene_of(body_of(needle))) == []
    outlines = section_between([body_of(needle)], 0.132, 0.132).outlines()
    middle = np.vstack(outlines).mean(axis=0)
    np.testing.assert_allclose(middle, (1.132 * slope, 0.566 * width), atol=0.002)


@pytest.mark.parametrize("size", [2e-6, 1e-4, 5e-4, 1e-3, 3e-3])
def test_a_tiny_solid_is_there(size):
    post = trimesh.creation.box((size, size, 1.0))
    flat = trimesh.creation.box((size, 10.0 * size, 1.0))
    for mesh in (post, flat):
        assert section_between([body_of(mesh)], *REACH).names
        assert found(scene_of(body_of(mesh))) == []


@pytest.mark.parametrize("length", [2.0, 40.0, 400.0])
@pytest.mark.parametrize("depth", [0.1, 0.3])
def test_a_long_wall_with_a_notch_keeps_it(length, depth):
    """Its mean depth over the whole outline is less than a millimetre."""
    half = length / 2.0
    outline = [(-half, 0.0), (half, 0.0), (half, 1.0), (depth, 1.0), (0.0, 1.0 - depth)]
    wall = shapely.Polygon([*outline, (-depth, 1.0), (-half, 1.0)])
    mesh = trimesh.creation.extrude_polygon(wall, 1.0)
    assert found(scene_of(body_of(mesh))) == []
    cut = section_between([body_of(mesh)], 0.132, 0.132)
    assert wall_distance(np.array([[0.0, 1.0 - depth / 2.0]]), cut)[0] > 0.3 * depth


@pytest.mark.parametrize(
    ("sections", "radius"),
    [
        *itertools.product((31, 33, 300), (0.2, 5.0)),
        (33, 100.0),
        pytest.param(31, 100.0, marks=pytest.mark.long),
        pytest.param(300, 100.0, marks=pytest.mark.long),
    ],
)
def test_a_round_solid_of_any_size_is_round(radius, sections):
    mesh = trimesh.creation.cylinder(radius, 1.0, sections=sections)
    assert found(scene_of(body_of(mesh))) == []
    cut = section_between([body_of(mesh)], 0.132, 0.132)
    assert wall_distance(np.array(mesh.vertices[:, :2]), cut).max() < 0.006


def test_who_is_left_out_or_invented_is_named(monkeypatch):
    scene = scene_of(body_of(room(3.0), "room::link"), body_of(trimesh.creation.box((1, 1, 1))))
    assert found(scene) == []
    cut = mesh_section._polygons
    with monkeypatch.context() as patch:
        patch.setattr(mesh_section, "_polygons", lambda *args: cut(*args)[:-1])
        names = {(d.body, d.what) for d in found(scene)}
        assert ("room::link", "the LiDAR lacks it") in names
        assert ("soup::link", "what robots can touch lacks it") in names
        assert picture(scene, REACH).missing.any()
        with pytest.raises(WorldError, match=r"'room::link': the LiDAR lacks it around \("):
            checked(scene, SCANS, REACH, with_physics=False)
        left = checked(scene, SCANS, REACH, with_physics=False, skip_broken=True)
        assert left.bodies == ()
        assert "differs from its triangles: room::link, soup::link" in left.notes[0]
    more = np.array([[8.0, 8.0], [9.0, 8.0], [9.0, 9.0]])
    monkeypatch.setattr(mesh_section, "_polygons", lambda *args: (*cut(*args), more))
    names = {(d.body, d.what) for d in found(scene)}
    assert ("room::link", "the LiDAR has more of it") in names


def test_bodies_that_the_physics_engine_lacks_are_named(monkeypatch):
    check_engine(BULLET, "what it feels")
    scene = scene_of(body_of(room(3.0), "room::link"))
    monkeypatch.setattr("swarm_sim.physics.bullet.probe.pieces_of", lambda body: ())
    (difference,) = found(scene)
    assert (difference.body, difference.what) == ("room::link", "the physics engine lacks it")


def test_a_world_is_looked_at_once(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    scene = load_world("hall_12")
    checked(scene, SCANS, REACH, with_physics=True)
    monkeypatch.setattr(world_check, "differences", lambda *_, **__: pytest.fail("looked again"))
    checked(scene, SCANS, REACH, with_physics=True)
