"""Reading of SDF worlds, and sections through them."""

import math

import numpy as np
import pytest

from swarm_common.model.errors import WorldError
from swarm_common.model.shapes import Box, Cylinder, Sphere
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.world_file import world_names
from swarm_sim.scene.section import convex_hull, section_between
from tests.fakes.scenes import read_bodies, section_at

COLLISION = "<collision name='c'><geometry>{}</geometry></collision>"


def world(folder, inside):
    path = folder / "test.world"
    path.write_text(f"<sdf version='1.6'>\n<world name='w'>{inside}</world>\n</sdf>")
    return path


def box_model(pose="", static="<static>1</static>"):
    shape = COLLISION.format("<box><size>1 2 3</size></box>")
    return f"<model name='m'>{static}{pose}<link name='l'>{shape}</link></model>"


def test_slim_blockage_has_the_walls_of_the_original():
    scene = load_world("slim_blockage")
    section = section_at(scene, 0.132)
    extents = {
        name.split("::")[1]: (*polygon.min(axis=0), *polygon.max(axis=0))
        for name, polygon in zip(section.names, section.polygons, strict=True)
    }
    assert len(extents) == 10
    assert extents["wall_south"] == pytest.approx((-8.47, -4.97, 9.52, -4.82))
    assert extents["island_east"] == pytest.approx((-3.91, -3.02, -3.76, 7.48))
    assert extents["box_north"] == pytest.approx((3.91, -1.56, 9.41, -1.41))
    assert len(scene.sites.stations) == 8
    assert len(scene.sites.circuits["island"]) == 4


@pytest.mark.parametrize("name", world_names())
def test_every_shipped_world_is_readable(name):
    scene = load_world(name)
    assert scene.bodies
    assert scene.sites.stations or scene.sites.places


def test_poses_of_model_link_and_collision_add_up(tmp_path):
    link = (
        "<link name='l'><pose>1 0 0 0 0 0</pose><collision name='c'><pose>0 0 5 0 0 0</pose>"
        "<geometry><sphere><radius>2</radius></sphere></geometry></collision></link>"
    )
    inner = f"<model name='inner'><pose>10 0 0 0 0 0</pose>{link}</model>"
    outer = (
        f"<model name='outer'><static>true</static><pose>0 0 0 0 0 1.5707963</pose>{inner}</model>"
    )
    (body,) = read_bodies(world(tmp_path, outer))
    place = body.world_from_body @ body.parts[0].body_from_part
    assert body.name == "outer::inner::l"
    assert body.is_static
    np.testing.assert_allclose(place[:3, 3], [0.0, 11.0, 5.0], atol=1e-6)
    assert body.parts[0].shape == Sphere(2.0)


def test_shapes_mass_and_what_is_not_solid(tmp_path):
    cylinder = COLLISION.format("<cylinder><radius>0.5</radius><length>2</length></cylinder>")
    mass = "<inertial><mass>7</mass></inertial>"
    text = f"<model name='m'><link name='l'>{mass}{cylinder}</link></model>" + box_model()
    round_body, square_body = read_bodies(world(tmp_path, text))
    assert round_body.parts[0].shape == Cylinder(0.5, 2.0)
    assert (round_body.mass, round_body.is_static) == (7.0, False)
    assert square_body.parts[0].shape == Box((1.0, 2.0, 3.0))
    assert square_body.is_static
    text = (
        "<light name='sun'/><plugin name='p' filename='x'/><physics/>"
        "<model name='m'><link name='l'>"
        "<visual name='v'><geometry><mesh/></geometry></visual></link></model>"
    )
    assert read_bodies(world(tmp_path, text)) == []


def test_a_world_without_sites_works(tmp_path):
    scene = load_world(world(tmp_path, box_model()))
    assert scene.name == "test"
    assert scene.sites.stations == {}


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("<model>\n</mdel>", "line 3"),
        (box_model().replace("1 2 3", "1 2"), "<size> of m::l is '1 2'"),
        (box_model().replace("1 2 3", "1 0 3"), "must be positive"),
        ("<model name='m'><link name='l'><collision/></link></model>", "no <geometry>"),
    ],
)
def test_malformed_worlds_are_refused(tmp_path, inside, message):
    with pytest.raises(WorldError, match=r"test\.world") as caught:
        read_bodies(world(tmp_path, inside))
    assert message in str(caught.value)


def test_bodies_are_cut_at_the_height_asked_for(tmp_path):
    tilted = box_model(f"<pose>0 0 0 0 {math.pi / 4} 0</pose>").replace("1 2 3", "2 1 2")
    section = section_between(read_bodies(world(tmp_path, tilted)), 0.5, 0.5)
    (polygon,) = section.polygons
    # A square of side 2 on its corner is 2 * (sqrt 2 - 0.5) wide at half a metre.
    assert polygon[:, 0].max() == pytest.approx(math.sqrt(2.0) - 0.5)
    assert polygon[:, 1].max() == pytest.approx(0.5)
    post = COLLISION.format("<cylinder><radius>0.5</radius><length>4</length></cylinder>")
    pose = f"<pose>0 0 0 {math.pi / 2} 0 0</pose>"
    text = f"<model name='m'>{pose}<link name='l'>{post}</link></model>"
    (polygon,) = section_between(read_bodies(world(tmp_path, text)), 0.0, 0.0).polygons
    assert polygon[:, 1].max() == pytest.approx(2.0)
    assert polygon[:, 0].max() == pytest.approx(0.5, abs=0.01)
    ball = COLLISION.format("<sphere><radius>1</radius></sphere>")
    post = COLLISION.format("<cylinder><radius>0.2</radius><length>4</length></cylinder>")
    text = f"<model name='m'><link name='l'>{ball}{post}</link></model>"
    section = section_between(read_bodies(world(tmp_path, text)), 0.6, 0.9)
    np.testing.assert_allclose(section.discs, [[0, 0, 0.8], [0, 0, 0.2]])
    assert not section_between(read_bodies(world(tmp_path, text)), 2.1, 3.0).names


def test_a_hull_is_convex_and_holds_all_points():
    rng = np.random.default_rng(0)
    points = np.vstack([rng.normal(size=(50, 2)), [[0, 0], [0, 0]]])
    hull = convex_hull(points)
    edges = np.roll(hull, -1, axis=0) - hull
    for corner, edge in zip(hull, edges, strict=True):
        assert (edge[0] * (points - corner)[:, 1] - edge[1] * (points - corner)[:, 0] > -1e-8).all()
