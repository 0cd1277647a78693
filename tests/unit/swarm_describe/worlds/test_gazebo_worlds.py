"""Worlds in the form that real packages have: includes, meshes, `<state>`, frames, actors."""

import math
import shutil

import numpy as np
import pytest
import trimesh

from swarm_common.model.errors import WorldError
from swarm_common.model.grid import OCCUPIED
from swarm_common.model.shapes import Hull, Mesh, MeshFile
from swarm_describe.worlds.reader import load_world
from swarm_sim.maps.draw_map import draw_world
from swarm_sim.scene.section import section_between
from tests.fakes.gazebo_package import write_package
from tests.fakes.scenes import read_bodies, section_at

BOX = "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"

MASSLESS = "<inertial><mass>0</mass></inertial>"


@pytest.fixture(name="office")
def office_fixture(tmp_path):
    return load_world(write_package(tmp_path))


def body_named(scene, name):
    (body,) = [body for body in scene.bodies if body.name == name]
    return body


def place(body):
    return [float(value) for value in body.world_from_body[:3, 3]]


def write(folder, inside, version="1.7"):
    path = folder / "test.sdf"
    path.write_text(f"<sdf version='{version}'><world name='w'>{inside}</world></sdf>")
    return path


def test_includes_frames_and_states_are_read(office):
    # bay at (10, 0) turned by 90 degrees; the left table 2 m ahead and 1 m to the left of it
    left, right = (body_named(office, f"bay::{side}::top") for side in ("left", "right"))
    np.testing.assert_allclose(place(left), [9.0, 2.0, 0.75], atol=1e-9)
    np.testing.assert_allclose(place(right), [11.0, 2.0, 0.75], atol=1e-9)
    leg = body_named(office, "bay::left::leg")
    np.testing.assert_allclose(place(leg), [9.0 - 0.3, 2.0 + 0.6, 0.37], atol=1e-9)
    barrier, crate = body_named(office, "barrier_0::link"), body_named(office, "crate::link")
    np.testing.assert_allclose(place(barrier), [5.0, -5.0, 0.0])
    assert barrier.world_from_body[1, 0] == pytest.approx(math.sin(0.5))
    np.testing.assert_allclose(place(crate), [3.0, 1.0, 0.25])


def test_meshes_are_scaled_and_cut_as_they_are(office):
    (part,) = body_named(office, "barrier_0::link").parts
    assert isinstance(part.shape, Mesh | Hull)
    section = section_between([body_named(office, "barrier_0::link")], 0.0, 0.001)
    points = np.vstack(section.polygons) - (5.0, -5.0)
    along = points @ (math.cos(0.5), math.sin(0.5))
    across = points @ (-math.sin(0.5), math.cos(0.5))
    assert np.ptp(along) == pytest.approx(0.4, abs=0.01)  # 0.8 m, scaled by half
    assert np.ptp(across) == pytest.approx(4.0, abs=0.01)
    grid = draw_world(office, 0.15)
    inside, corner = (10.0 - 1.0, 1.0), (10.0 - 0.1, 1.0)
    assert grid.cells[grid.cell_of(*inside)] != OCCUPIED
    assert grid.cells[grid.cell_of(*corner)] == OCCUPIED


def test_mass_friction_and_looks_are_kept(office):
    crate = body_named(office, "crate::link")
    assert (crate.is_static, crate.mass, crate.friction) == (False, 4.0, 0.4)
    assert office.loose == (crate,)
    grid = draw_world(office, 0.15)
    assert grid.cells[grid.cell_of(3.0, 1.0)] != OCCUPIED  # a map shows what stays
    crate, table = body_named(office, "crate::link"), body_named(office, "bay::left::top")
    assert crate.visuals[0].color == (0.8, 0.2, 0.1, 1.0)
    assert table.visuals[0].color == pytest.approx((0.6, 0.42, 0.25, 1.0))
    (visual,) = body_named(office, "barrier_0::link").visuals
    assert isinstance(visual.shape, MeshFile)
    assert visual.shape.path.name == "barrier.dae"


def test_actors_become_walkers_and_vehicles(office):
    (clerk,), (truck,) = office.walkers, office.vehicles
    assert clerk.path == ((-2.0, 0.0), (-2.0, 4.0))
    assert clerk.speed == pytest.approx(1.0)
    assert (truck.name, truck.length, truck.width, truck.height) == ("truck", 2.0, 1.0, 1.8)
    assert truck.path == ((-8.0, -4.0), (0.0, -4.0))


def test_what_is_ignored_is_said(office):
    (note,) = office.notes
    assert note == "office.world: ignored: 2 <light>, 3 <plugin>, 1 <sensor>"


def test_all_missing_files_are_listed_at_once(tmp_path):
    world = write_package(tmp_path)
    models = tmp_path / "office" / "models"
    shutil.rmtree(models / "table")
    (models / "barrier" / "meshes" / "barrier.dae").unlink()
    with pytest.raises(WorldError) as caught:
        load_world(world)
    message = str(caught.value)
    assert "2 files are missing" in message
    assert "model://table  (included as 'left')" in message
    assert "model://barrier/meshes/barrier.dae  (barrier_0::link)" in message
    assert str(models) in message
    assert "--skip-missing" in message
    scene = load_world(world, skip_missing=True)
    assert {body.name for body in scene.bodies} >= {"bay::curb", "crate::link"}
    assert any("left out" in note and "model://table" in note for note in scene.notes)


@pytest.mark.parametrize(
    "variable", ["GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH", "IGN_GAZEBO_RESOURCE_PATH"]
)
def test_models_are_found_by_the_variables_of_gazebo(tmp_path, monkeypatch, variable):
    world = write_package(tmp_path)
    away = tmp_path / "elsewhere"
    shutil.move(tmp_path / "office" / "models", away)
    with pytest.raises(WorldError, match="missing"):
        load_world(world)
    monkeypatch.setenv(variable, f"/nowhere:{away}")
    assert body_named(load_world(world), "bay::left::top")


def test_packages_are_found_by_the_variables_of_ros(tmp_path, monkeypatch):
    mesh = tmp_path / "install" / "share" / "parts" / "meshes" / "box.obj"
    mesh.parent.mkdir(parents=True)
    trimesh.creation.box((1, 1, 1)).export(mesh)
    uri = "<mesh><uri>package://parts/meshes/box.obj</uri></mesh>"
    link = f"<link name='l'><collision name='c'><geometry>{uri}</geometry></collision></link>"
    world = write(tmp_path, f"<model name='m'><static>1</static>{link}</model>")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert len(read_bodies(world)) == 1


def test_meshes_in_millimetres_or_damaged_are_refused(tmp_path):
    trimesh.creation.box((4000, 1000, 1000)).export(tmp_path / "big.stl")
    mesh = "<mesh><uri>big.stl</uri>{}</mesh>"
    link = "<link name='l'><collision name='c'><geometry>{}</geometry></collision></link>"
    text = f"<model name='m'><static>1</static>{link}</model>"
    with pytest.raises(WorldError, match=r"is 4000 m long .* in millimetres"):
        read_bodies(write(tmp_path, text.format(mesh.format(""))))
    scaled = mesh.format("<scale>0.001 0.001 0.001</scale>")
    (body,) = read_bodies(write(tmp_path, text.format(scaled)))
    assert section_between([body], 0.1, 0.1).bounds() == pytest.approx((-2, -0.5, 2, 0.5), abs=0.01)
    (tmp_path / "bad.stl").write_bytes(b"solid nothing\nfacet\n")
    link = (
        "<link name='l'><collision name='c'><geometry><mesh><uri>bad.stl</uri></mesh></geometry>"
        "</collision></link>"
    )
    with pytest.raises(WorldError, match=r"bad\.stl"):
        read_bodies(write(tmp_path, f"<model name='m'>{link}</model>"))


@pytest.mark.parametrize("version", ["1.3", "one", ""])
def test_a_wrong_version_is_refused(tmp_path, version):
    with pytest.raises(WorldError, match=r"expected 1\.4 to 1\.10"):
        read_bodies(write(tmp_path, "", version))


@pytest.mark.parametrize("version", ["1.4", "1.7", "1.10"])
def test_every_version_is_read(tmp_path, version):
    model = f"<model name='m'><link name='l'>{BOX}</link></model>"
    assert len(read_bodies(write(tmp_path, model, version))) == 1


def test_a_model_inside_a_wall_is_refused(tmp_path):
    wall = (
        "<model name='wall'><static>1</static><link name='l'><collision name='c'><geometry>"
        "<box><size>8 2 3</size></box></geometry></collision></link></model>"
    )
    box = f"<model name='cone'><pose>{{}} 0 0 0 0 0</pose><link name='l'>{BOX}</link></model>"
    with pytest.raises(WorldError, match=r"'cone' at \(2\.00, 0\.00\) lies inside 'wall::l'"):
        load_world(write(tmp_path, wall + box.format(2)))
    load_world(write(tmp_path, wall + box.format(5)))


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (f"<model name='m'><pose>0 0 nan 0 0 0</pose><link name='l'>{BOX}</link></model>", "nan"),
        (
            f"<model name='m'><link name='l'>{BOX.replace('1 1 1', '1e6 1 1')}</link></model>",
            "another unit",
        ),
        ("<model name='m'><pose relative_to='there'/><link name='l'/></model>", "no frame 'there'"),
        (
            f"<model name='m'><link name='a'><pose relative_to='b'/>{BOX}</link>"
            f"<link name='b'><pose relative_to='a'/>{BOX}</link></model>",
            "go round: b -> a -> b",
        ),
        (
            f"<model name='m'><link name='l'>{MASSLESS.replace('0', '-1')}{BOX}</link></model>",
            "<mass> of m::l is -1 kg",
        ),
    ],
)
def test_malformed_values_are_refused(tmp_path, inside, message):
    with pytest.raises(WorldError, match=r"test\.sdf") as caught:
        load_world(write(tmp_path, inside))
    assert message in str(caught.value)


def test_a_model_that_includes_itself_is_refused(tmp_path):
    folder = tmp_path / "loop"
    folder.mkdir()
    (folder / "model.sdf").write_text(
        "<sdf version='1.7'><model name='loop'><include><uri>model://loop</uri></include></model>"
        "</sdf>"
    )
    with pytest.raises(WorldError, match="includes itself"):
        load_world(write(tmp_path, "<include><uri>model://loop</uri></include>"))


def test_joints_weld_links_and_tie_them_to_the_world(tmp_path):
    links = "".join(
        f"<link name='{n}'><pose>{i} 0 0 0 0 0</pose>{BOX}</link>" for i, n in enumerate("abc")
    )
    hinge = "<joint name='{0}{1}' type='revolute'><parent>{0}</parent><child>{1}</child></joint>"
    door = f"<model name='door'>{links}{hinge.format('a', 'b')}</model>"
    ab, c = load_world(write(tmp_path, door)).bodies
    assert (len(ab.parts), ab.mass, ab.is_static) == (2, 2.0, False)
    assert ab.parts[1].body_from_part[0, 3] == pytest.approx(1.0)
    assert len(c.parts) == 1
    tied = door.replace("</model>", f"{hinge.format('world', 'a')}</model>")
    assert [body.is_static for body in load_world(write(tmp_path, tied)).bodies] == [True, False]


def test_poses_in_degrees_quaternions_and_placement_frames(tmp_path):
    for pose in (
        "<pose degrees='true'>1 2 3 0 0 90</pose>",
        "<pose rotation_format='quat_xyzw'>1 2 3 0 0 0.70710678 0.70710678</pose>",
    ):
        text = f"<model name='m'>{pose}<link name='l'>{BOX}</link></model>"
        (body,) = read_bodies(write(tmp_path, text, "1.9"))
        assert place(body) == [1.0, 2.0, 3.0]
        np.testing.assert_allclose(body.world_from_body[:2, :2], [[0, -1], [1, 0]], atol=1e-7)
    text = (
        "<model name='m' placement_frame='l'><pose>5 0 0 0 0 0</pose>"
        f"<link name='l'><pose>1 0 0 0 0 0</pose>{BOX}</link></model>"
    )
    (body,) = read_bodies(write(tmp_path, text, "1.8"))
    np.testing.assert_allclose(place(body), [5.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("shape", "reach"),
    [
        ("<capsule><radius>0.5</radius><length>2</length></capsule>", 0.5),
        ("<ellipsoid><radii>0.5 1 1</radii></ellipsoid>", 0.5),
        ("<cone><radius>1</radius><length>2</length></cone>", 0.5),
        (
            "<polyline><point>-0.5 0</point><point>0.5 0</point><point>0.5 1</point>"
            "<height>1</height></polyline>",
            0.5,
        ),
    ],
)
def test_further_shapes(tmp_path, shape, reach):
    text = f"<collision name='c'><geometry>{shape}</geometry></collision>"
    path = write(tmp_path, f"<model name='m'><link name='l'>{text}</link></model>")
    bounds = section_at(load_world(path), 0.001).bounds()
    assert bounds[2] == pytest.approx(reach, abs=0.02)


def mesh_link(uri):
    return (
        f"<link name='l'>{MASSLESS}<collision name='c'><geometry><mesh><uri>{uri}</uri></mesh>"
        "</geometry></collision></link>"
    )


def test_what_gazebo_takes_is_taken(tmp_path):
    """A bare &, no mass, a scale of 0 in a state, a mesh of nothing: said, and gone on with."""
    world = write_package(tmp_path)
    table = tmp_path / "office" / "models" / "table" / "model.config"
    table.write_text(
        "<model><name>Table</name><sdf version='1.6'>model.sdf</sdf>"
        "<description>Tables & chairs, R&D &amp; more</description></model>"
    )
    assert len(load_world(world).bodies) > 3
    (tmp_path / "none.obj").write_text("# nothing\nv 0 0 0\n")
    scene = load_world(
        write(
            tmp_path,
            f"<model name='still'><static>1</static><link name='l'>{MASSLESS}{BOX}</link></model>"
            f"<model name='loose'><pose>3 0 0 0 0 0</pose><link name='l'>{MASSLESS}{BOX}</link>"
            f"</model><model name='ghost'>{mesh_link('none.obj')}</model>"
            "<state world_name='w'><model name='still'><scale>1 1 0</scale></model></state>",
        )
    )
    assert [body.name for body in scene.bodies] == ["still::l", "loose::l"]
    assert scene.bodies[1].mass == 1.0
    notes = "\n".join(scene.notes)
    assert "the <mass> of loose::l, 0, is 1 kg here" in notes
    assert "none.obj of ghost::l has no triangles" in notes


def test_everything_unusable_is_told_at_once_and_can_be_left_out(tmp_path):
    (tmp_path / "bad.stl").write_bytes(b"solid nothing\nfacet\n")
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "model.config").write_text("<model")
    world = write(
        tmp_path,
        f"<model name='fine'><link name='l'>{BOX}</link></model>"
        f"<model name='a'><pose>0 0 nan 0 0 0</pose><link name='l'>{BOX}</link></model>"
        f"<model name='b'><static>1</static>{mesh_link('bad.stl')}</model>"
        "<include><uri>model://broken</uri></include>"
        "<include><uri>model://nowhere</uri></include>"
        f"<model name='c'><static>1</static>{mesh_link('gone.dae')}</model>",
    )
    with pytest.raises(WorldError) as caught:
        load_world(world)
    message = str(caught.value)
    parts = ["2 files are missing", "model://nowhere", "gone.dae", "3 models are unusable"]
    for part in (*parts, "a: <pose>", "b: ", "bad.stl", "broken/model.config", "--skip-broken"):
        assert part in message, part
    with pytest.raises(WorldError, match="3 models are unusable"):
        load_world(world, skip_missing=True)
    scene = load_world(world, skip_missing=True, skip_broken=True)
    assert [body.name for body in scene.bodies] == ["fine::l"]
    assert sum("left out, because it is unusable" in note for note in scene.notes) == 3


def test_a_broken_visual_is_a_note_as_nobody_touches_it(tmp_path):
    box = "<geometry><box><size>1 1 1</size></box></geometry>"
    sphere = "<geometry><sphere><size>1 1 1</size></sphere></geometry>"
    world = tmp_path / "looks.sdf"
    world.write_text(
        '<sdf version="1.6"><world name="w"><model name="v"><static>1</static><link name="l">'
        f'<collision name="c">{box}</collision><visual name="v">{sphere}</visual>'
        "</link></model></world></sdf>",
        encoding="utf-8",
    )
    scene = load_world(world)
    assert [len(body.parts) for body in scene.bodies] == [1]
    assert any("a visual is left out: <sphere> of v::l has no <radius>" in n for n in scene.notes)
