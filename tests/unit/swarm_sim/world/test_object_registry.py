"""Things that come, go and are put elsewhere while the world runs, and what is refused."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from swarm_common.model.beacon import BEACON_DTYPE
from swarm_common.model.records import Pose, Twist
from swarm_describe.worlds.scene import Body
from swarm_sim.maps.draw_map import draw_world
from swarm_sim.ros.build import build
from swarm_sim.ros.settings import RobotEntry, Settings
from swarm_sim.world.model_reader import ModelRequest, read_model
from swarm_sim.world.object_placement import upright
from swarm_sim.world.object_registry import ObjectRegistry
from swarm_sim.world.object_source import is_object
from swarm_sim.world.request_checks import Reason, RefusedError
from swarm_sim.world.robot_registry import RobotRegistry

WAFFLE = "turtlebot3_waffle"
CRATE = (
    '<link name="l"><inertial><mass>1</mass></inertial><collision name="c">'
    "<geometry><box><size>0.4 0.4 0.4</size></box></geometry>"
    "<surface><friction><ode><mu>0.3</mu></ode></friction></surface></collision></link>"
)
FIELD = (
    '<sdf version="1.7"><world name="w"><model name="wall"><static>true</static>'
    '<pose>6 0 0.5 0 0 0</pose><link name="l"><collision name="c"><geometry><box>'
    "<size>0.2 4 1</size></box></geometry></collision></link></model>"
    f'<model name="old"><pose>0 3 0.2 0 0 0</pose>{CRATE}</model></world></sdf>'
)


def model(content, name="crate", extra=""):
    return f'<sdf version="1.7"><model name="{name}">{extra}{content}</model></sdf>'


def urdf(size="0.4 0.4 0.4", extra=""):
    return (
        f'<robot name="parcel"><link name="l"><collision><geometry><box size="{size}"/></geometry>'
        f'</collision><inertial><mass value="3"/></inertial></link>{extra}</robot>'
    )


def make_world(folder, engine="planar", lidar=False):
    file = folder / "field.sdf"
    file.write_text(FIELD, encoding="utf-8")
    robots = (RobotEntry("Srobot1", WAFFLE),)
    settings = Settings(world=str(file), robots=robots, engine=engine, with_lidar=lidar)
    _, world = build(settings)
    world.place(0, Pose(0.0, 0.0, 0.0))
    return world


@pytest.fixture
def world(tmp_path):
    return make_world(tmp_path)


@pytest.fixture
def objects(world):
    return ObjectRegistry(world)


def put(objects, x, y, text="", name="", z=None):
    place = upright(x, y, z or 0.0, 0.0)
    body = read("", text or model(CRATE), objects)
    return objects.spawn(name, False, body, place, is_floored=z is None)


def read(uri, text, objects):
    body = read_model(ModelRequest(uri, text, False, objects.folder))
    assert isinstance(body, Body)
    return body


def refused(do):
    with pytest.raises(RefusedError) as caught:
        do()
    return caught.value


def drive(world, seconds, speed):
    for _ in range(round(10 * seconds)):
        world.observe()
        world.step([Twist(speed, 0.0, 0.0)], [None])


@pytest.mark.parametrize("engine", ["planar", "bullet"])
def test_a_thing_is_seen_touched_moved_and_gone(engine, tmp_path):
    world = make_world(tmp_path, engine, lidar=True)
    objects = ObjectRegistry(world)
    assert put(objects, 1.2, 0.0) == "crate"
    (seen,) = world.observe()
    front = 1.0 - world.specs[0].lidar.x
    assert seen.scan.ranges[0] == pytest.approx(front, abs=0.06)
    drive(world, 6.0, 0.26)
    assert [collision.obstacle for collision in world.collisions] == ["crate"]
    assert (objects.place_of("crate")[0, 3] > 1.3) == (engine == "bullet")  # it is pushed
    objects.move("crate", upright(3.0, 2.0, 0.2, 0.5))
    drive(world, 0.5, 0.0)
    np.testing.assert_allclose(objects.place_of("crate")[:3, 3], (3.0, 2.0, 0.2), atol=0.01)
    objects.remove("crate")
    assert objects.names == ["old::l"]
    world.place(0, Pose(2.3, 2.0, 0.0))
    drive(world, 3.0, 0.26)  # through where it was
    assert len(world.collisions) == 1
    assert not (world.observe()[0].scan or seen.scan).ranges[0] < 0.5
    world.close()


@pytest.mark.parametrize("engine", ["planar", "bullet"])
def test_a_static_thing_stands(engine, tmp_path):
    world = make_world(tmp_path, engine)
    objects = ObjectRegistry(world)
    put(objects, 0.8, 0.0, model(CRATE, "block", "<static>true</static>"))
    drive(world, 5.0, 0.26)
    assert [collision.obstacle for collision in world.collisions] == ["block"]
    np.testing.assert_allclose(objects.place_of("block")[:2, 3], (0.8, 0.0), atol=1e-9)
    assert world.poses[0, 0] < 0.6
    world.close()


def test_things_that_can_be_pushed_stand_on_others_and_fall_when_these_go(tmp_path):
    world = make_world(tmp_path, "bullet")
    objects = ObjectRegistry(world)
    put(objects, 3.0, 0.0, name="lower")
    put(objects, 3.0, 0.0, name="upper", z=0.6)
    drive(world, 1.0, 0.0)
    assert objects.place_of("upper")[2, 3] == pytest.approx(0.6, abs=0.02)
    objects.remove("lower")
    drive(world, 1.0, 0.0)
    assert objects.place_of("upper")[2, 3] == pytest.approx(0.2, abs=0.02)
    world.close()


def test_sdf_models_count_from_their_own_frame(objects, world):
    link = CRATE.replace('<link name="l">', '<link name="l"><pose>0 0 0.2 0 0 0</pose>')
    put(objects, 2.0, 1.0, model(link, extra="<pose>9 9 9 0 0 0</pose>"), z=0.0)
    assert objects.place_of("crate")[:3, 3].tolist() == [2.0, 1.0, 0.0]
    (body,) = [body for body in world.objects() if body.name == "crate"]
    np.testing.assert_allclose(body.parts[0].body_from_part[:3, 3], (0.0, 0.0, 0.2))


def test_urdf_files_and_model_folders(objects, tmp_path):
    (tmp_path / "parcel.urdf").write_text(urdf(), encoding="utf-8")
    folder = tmp_path / "models" / "bin"
    folder.mkdir(parents=True)
    (folder / "model.config").write_text("<model><sdf>bin.sdf</sdf></model>", encoding="utf-8")
    (folder / "bin.sdf").write_text(model(CRATE, "bin"), encoding="utf-8")
    for number, uri in enumerate((f"file://{tmp_path}/parcel.urdf", "model://bin", str(folder))):
        assert is_object(uri, "", False, objects.folder)
        place = upright(2.0 + number, 1.0, 0.0, 0.0)
        objects.spawn("", False, read(uri, "", objects), place, is_floored=True)
    assert objects.spawned == ["parcel", "bin", "bin_1"]
    assert put(objects, 2.0, -1.0, urdf(), "box") == "box"


def test_what_is_a_robot_is_no_thing(tmp_path, objects):
    wheels = urdf(extra='<joint name="j" type="continuous"/>')
    (tmp_path / "cart.urdf").write_text(wheels, encoding="utf-8")
    for uri in (WAFFLE, "turtlebot9", str(tmp_path / "cart.urdf"), ""):
        assert not is_object(uri, "", False, objects.folder)
    assert not is_object(str(tmp_path / "parcel.urdf"), "", True, objects.folder)
    assert refused(lambda: put(objects, 2.0, 0.0, wheels)).reason is Reason.BAD_FORMAT


def test_bad_input_changes_nothing(objects, world, tmp_path):
    mesh = "<link name='l'><collision name='c'><geometry><mesh><uri>model://no/a.stl</uri></mesh>"
    mesh += "</geometry></collision></link>"
    plane = CRATE.replace("<box><size>0.4 0.4 0.4</size></box>", "<plane/>")
    put(objects, 3.0, 0.0)
    cases: list[tuple[Callable[[], object], Reason, str]] = [
        (
            lambda: put(objects, 2.0, 0.0, name="crate"),
            Reason.NAME_TAKEN,
            "'crate_1' would be free",
        ),
        (lambda: put(objects, 2.0, 0.0, name="wall::l"), Reason.NAME_TAKEN, "wall::l"),
        (lambda: put(objects, 2.0, 0.0, name="Srobot7"), Reason.NAME_INVALID, "Srobot7"),
        (lambda: put(objects, 2.0, 0.0, "<sdf"), Reason.BAD_MODEL, "line 1"),
        (lambda: put(objects, 2.0, 0.0, "<html/>"), Reason.BAD_FORMAT, "<html>"),
        (lambda: put(objects, 2.0, 0.0, '<sdf version="3"/>'), Reason.BAD_MODEL, "version '3'"),
        (lambda: put(objects, 2.0, 0.0, FIELD), Reason.BAD_MODEL, "0 <model>"),
        (lambda: put(objects, 2.0, 0.0, model("")), Reason.BAD_MODEL, "no link"),
        (lambda: put(objects, 2.0, 0.0, model(mesh)), Reason.MISSING_FILES, "model://no/a.stl"),
        (lambda: put(objects, 2.0, 0.0, model(plane)), Reason.BAD_MODEL, "a plane"),
        (lambda: put(objects, 2.0, 0.0, urdf("0.4 nan 0.4")), Reason.BAD_MODEL, "nan"),
        (lambda: put(objects, 0.2, 0.0), Reason.BAD_PLACE, "Srobot1 stands"),
        (lambda: put(objects, 6.0, 0.0, name="x"), Reason.BAD_PLACE, "inside 'wall::l'"),
        (lambda: put(objects, 3.3, 0.0, name="x"), Reason.BAD_PLACE, "inside 'crate'"),
        (lambda: put(objects, 2.0, 0.0, z=0.05, name="x"), Reason.BAD_PLACE, "on it, its z is 0.2"),
        (lambda: put(objects, math.nan, 0.0, name="x"), Reason.BAD_PLACE, "not finite"),
        (lambda: objects.remove("nothing"), Reason.UNKNOWN, "there are old::l, crate"),
        (lambda: objects.move("box", np.eye(4)), Reason.UNKNOWN, "no thing 'box'"),
        (lambda: objects.move("crate", upright(0, 0, 0.2, 0)), Reason.BAD_PLACE, "Srobot1 stands"),
    ]
    for do, reason, words in cases:
        error = refused(do)
        assert error.reason is reason, error
        assert words in str(error)
    missing = str(tmp_path / "no.sdf")
    error = refused(lambda: read(missing, "", objects))
    assert error.reason is Reason.NO_MODEL
    assert objects.names == ["old::l", "crate"]
    world.step([None], [None])


def test_the_space_that_a_robot_holds_is_taken(objects, world):
    beacon = np.zeros(1, BEACON_DTYPE)[0]
    beacon["radius"], beacon["held_size"] = 0.29, 2
    beacon["held"][:2] = (0.0, 0.0), (2.0, 0.0)
    world.step([None], [beacon])
    assert "about to drive" in str(refused(lambda: put(objects, 2.4, 0.0)))
    high = model(CRATE, "lamp", "<static>true</static>")
    assert put(objects, 2.0, 0.0, high, z=2.0) == "lamp"  # robots pass beneath
    assert put(objects, 2.6, 0.0) == "crate"


def test_all_go_home_unless_something_is_there(world, objects):
    robots = RobotRegistry(world, draw_world(world.scene, 0.2), [Pose(0.0, 0.0, 0.0)], "")
    objects.move("old::l", upright(3.0, 3.0, 0.2, 0.0))
    put(objects, 0.1, 3.0, name="usurper")
    assert "'usurper' would be inside 'old::l'" in str(refused(objects.check_homes))
    objects.remove("usurper")
    world.place(0, Pose(2.0, 2.0, 0.0))
    put(objects, 0.1, 0.0, name="block")
    assert "taken by 'block'" in str(refused(robots.send_home))
    objects.remove("block")
    objects.check_homes()
    robots.send_home()
    objects.send_home()
    np.testing.assert_allclose(objects.place_of("old::l")[:2, 3], (0.0, 3.0))
    assert world.poses[0, :2].tolist() == [0.0, 0.0]
