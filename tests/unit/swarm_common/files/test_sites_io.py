"""Reading of sites.yaml."""

import pytest

from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose
from swarm_common.model.sites import SpawnArea, SpawnAreas, SpawnCircle, area_count

GOOD = """
stations:
  loader_1: [1.0, 2.0, 0.5]
  home: [0, 0, 0]
circuits:
  ring: [[0, 0], [1, 0], [1, 1]]
spawn: {x_min: 0, y_min: 1, x_max: 2, y_max: 3, pitch: 0.8}
"""


def load(folder, text):
    path = folder / "sites.yaml"
    path.write_text(text)
    return load_sites(path)


def test_everything_is_read_in_file_order(tmp_path):
    path = tmp_path / "sites.yaml"
    path.write_text(GOOD)
    sites = load_sites(path)
    assert list(sites.stations) == ["loader_1", "home"]
    assert sites.stations["loader_1"] == Pose(1.0, 2.0, 0.5)
    assert sites.circuits["ring"] == ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))
    assert isinstance(sites.spawn, SpawnArea)
    assert (sites.spawn.x_max, sites.spawn.pitch, sites.spawn.yaw) == (2.0, 0.8, 0.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stations: {a: [1, 2]}\n", "stations.a"),
        ("stations: {a: [1, 2, .nan]}\n", "expected a number"),
        ("circuits: {r: [[0, 0], [1, 1]]}\n", "at least 3 points"),
        ("spawn: {x_min: 3, y_min: 0, x_max: 1, y_max: 1}\n", "is empty"),
        ("spawn: {x_min: 0, y_min: 0, x_max: 1, y_max: 1, pich: 1}\n", "did you mean 'pitch'"),
        ("spawns: {ring: {x: 0, y: 0, radius: -1}}\n", "spawns.ring.radius is -1"),
        ("spawns: {ring: {x: 0, radius: 1}}\n", "spawns.ring lacks y"),
        ("stations: {a: [1, 2, 90]}\n", "stations.a[2] is 90; expected a number from -2 pi to 2"),
        ("spawn: {x_min: 0, y_min: 0, x_max: 1, y_max: 1, yaw: -90}\n", "in radians"),
        ("stations:\n\ta: 1\n", "line 2"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, message):
    with pytest.raises(ConfigError, match=r"sites\.yaml") as caught:
        load(tmp_path, text)
    assert message in str(caught.value)


def test_stations_that_charge_are_named(tmp_path):
    path = tmp_path / "sites.yaml"
    path.write_text(GOOD + "charging: [home]\n")
    sites = load_sites(path)
    assert sites.chargers == {"home": Pose(0.0, 0.0, 0.0)}
    assert sites.work_stations == ("loader_1",)
    path.write_text(GOOD)
    assert load_sites(path).chargers == {}


@pytest.mark.parametrize(
    ("charging", "words"),
    [("[hom]", "charging"), ("home", "expected a list of stations"), ("{home: true}", "a list")],
)
def test_a_charging_station_that_is_none_is_refused(tmp_path, charging, words):
    with pytest.raises(ConfigError, match=words):
        load(tmp_path, GOOD + f"charging: {charging}\n")


def test_several_areas_circles_and_places_are_read(tmp_path):
    path = tmp_path / "sites.yaml"
    path.write_text(
        "spawn: {x_min: 0, y_min: 0, x_max: 1, y_max: 1}\n"
        "spawns:\n"
        "  ring: {x: 1, y: 2, radius: 3}\n"
        "  rooms:\n"
        "    - {x_min: 0, y_min: 0, x_max: 1, y_max: 1, yaw: 0.5}\n"
        "    - {x_min: 5, y_min: 0, x_max: 6, y_max: 1}\n"
        "places: [[0, 1, 2], [3, 4, 5]]\n"
    )
    sites = load_sites(path)
    assert sites.spawn_named("") == sites.spawn
    assert sites.spawn_named("ring") == SpawnCircle(1.0, 2.0, 3.0)
    rooms = sites.spawn_named("rooms")
    assert isinstance(rooms, SpawnAreas)
    assert [area.x_min for area in rooms.areas] == [0.0, 5.0]
    assert (area_count(rooms), area_count(sites.spawn), area_count(None)) == (2, 1, 1)
    assert sites.places == (Pose(0.0, 1.0, 2.0), Pose(3.0, 4.0, 5.0))
    with pytest.raises(UnknownNameError, match="did you mean 'ring'"):
        sites.spawn_named("rign")
