"""Models and worlds in the cache of Gazebo Fuel: the version that is named, or the newest."""

import pytest

from swarm_common.model.errors import ConfigError
from swarm_describe.files.fuel import name_in_fuel
from swarm_describe.files.model_paths import ModelPaths
from swarm_describe.worlds.world_file import find_world

GZ, IGN = "fuel.gazebosim.org", "fuel.ignitionrobotics.org"
OWN = "fuel.example.com"


@pytest.fixture(name="home")
def home_fixture(tmp_path):
    for cache, server, name, versions in (
        (".gz/fuel", GZ, "acme/models/rack", ("2", "9", "10", "tmp")),
        (".ignition/fuel", IGN, "acme/models/rack", ("3",)),
        (".ignition/fuel", IGN, "open robotics/models/Tall Shelf", ("1",)),
        (".gz/fuel", GZ, "acme/models/box%20cart", ("4",)),
        (".gz/fuel", OWN, "acme/models/rack", ("30",)),
    ):
        for version in versions:
            meshes = tmp_path / cache / server / name / version / "meshes"
            meshes.mkdir(parents=True)
            (meshes / "a.dae").touch()
    return tmp_path


@pytest.mark.parametrize(
    ("uri", "found"),
    [
        (f"https://{GZ}/1.0/acme/models/rack", f".gz/fuel/{GZ}/acme/models/rack/10"),
        (f"https://{GZ}/1.0/acme/models/rack/", f".gz/fuel/{GZ}/acme/models/rack/10"),
        (f"https://{GZ}/1.0/acme/models/rack/tip", f".gz/fuel/{GZ}/acme/models/rack/10"),
        (f"http://{GZ}/1.0/ACME/models/Rack/2", f".gz/fuel/{GZ}/acme/models/rack/2"),
        (f"https://{IGN}/1.0/acme/models/rack", f".gz/fuel/{GZ}/acme/models/rack/10"),
        (f"https://{GZ}/1.0/acme/models/rack/3", f".ignition/fuel/{IGN}/acme/models/rack/3"),
        (
            f"https://{GZ}/1.0/acme/models/rack/9/files/meshes/a.dae",
            f".gz/fuel/{GZ}/acme/models/rack/9/meshes/a.dae",
        ),
        (
            f"https://{GZ}/1.0/acme/models/rack/tip/files/../../meshes/a.dae",
            f".gz/fuel/{GZ}/acme/models/rack/10/meshes/a.dae",
        ),
        (
            f"https://{GZ}/1.0/Open%20Robotics/models/tall%20shelf",
            f".ignition/fuel/{IGN}/open robotics/models/Tall Shelf/1",
        ),
        (f"https://{GZ}/1.0/acme/models/Box cart", f".gz/fuel/{GZ}/acme/models/box%20cart/4"),
        (f"https://{OWN}/1.0/acme/models/rack", f".gz/fuel/{OWN}/acme/models/rack/30"),
        (f"https://{GZ}/1.0/acme/models/rack/11", None),
        (f"https://{GZ}/1.0/acme/models/shelf", None),
    ],
)  # fmt: skip
def test_versions(home, uri, found):
    path = ModelPaths(home / "beside", {}, home).find(uri, home / "here")
    assert path == (None if found is None else home / found)


def test_a_cache_elsewhere(home):
    paths = ModelPaths(home, {"GZ_FUEL_CACHE_PATH": str(home / ".gz" / "fuel")}, home / "nobody")
    assert paths.find(f"https://{GZ}/1.0/acme/models/rack", home) is not None
    assert name_in_fuel("model://rack") is None


def test_worlds_of_fuel(home, monkeypatch):
    monkeypatch.setenv("HOME", str(home))
    uri = f"https://{GZ}/1.0/openrobotics/worlds/Depot"
    with pytest.raises(ConfigError, match="gz fuel download -u"):
        find_world(uri)
    for version in ("9", "10"):
        folder = home / ".gz/fuel" / GZ / "openrobotics/worlds/depot" / version
        folder.mkdir(parents=True)
        (folder / "depot.sdf").touch()
    assert find_world(uri) == folder / "depot.sdf"
    assert find_world(f"{uri}/9").parent.name == "9"
    (folder / "other.world").touch()
    with pytest.raises(ConfigError, match="several worlds"):
        find_world(uri)
    with pytest.raises(ConfigError, match="is no world of Gazebo Fuel"):
        find_world(f"https://{GZ}/1.0/acme/models/rack")
