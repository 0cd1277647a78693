"""Reading of the people in a world, and the check of their paths."""

import json

import pytest

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_describe.worlds.actors import WalkerSpec, load_actors
from swarm_describe.worlds.reader import load_world
from swarm_sim.maps.check import check_walkers

LINE = [[0.0, 0.0], [2.0, 0.0]]


def actors_of(folder, walkers):
    path = folder / "actors.yaml"
    path.write_text(json.dumps({"walkers": walkers}))
    return load_actors(path)


def test_a_walker_needs_only_a_path_through_no_wall(tmp_path):
    path = tmp_path / "actors.yaml"
    path.write_text(
        "walkers:\n  - path: [[0, 0], [2, 0], [2, 1]]\n"
        "  - {name: Ann, path: [[0, 0], [0, 3]], speed: 1.0, start: 1.5, pause: 0}\n"
    )
    first, second = load_actors(path).walkers
    assert first == WalkerSpec(name="walker_1", path=((0.0, 0.0), (2.0, 0.0), (2.0, 1.0)))
    assert (second.name, second.speed, second.start, second.pause) == ("Ann", 1.0, 1.5, 0.0)
    hall = load_world("hall_12")
    inside = WalkerSpec(name="Ann", path=((0.0, 0.0), (5.0, 0.0)))
    check_walkers(hall, [inside])
    outside = WalkerSpec(name="Bob", path=((0.0, 0.0), (8.0, 0.0)))
    with pytest.raises(ConfigError, match=r"Bob: its path .* does not fit"):
        check_walkers(hall, [inside, outside])


@pytest.mark.parametrize(
    ("item", "message"),
    [
        ({"path": [[0, 0]]}, "expected 2 or more"),
        ({"path": [[0, 0], [0, 0.05]]}, "repeats the one before"),
        ({"path": [[0, 0], [1, 0], [0, 0]]}, "repeats the one before"),
        ({"path": LINE, "speed": 0}, "speed is 0; expected a number, more than 0 and at most 2"),
    ],
)
def test_impossible_walkers_are_refused(item, message, tmp_path):
    with pytest.raises(ConfigError, match=message) as caught:
        actors_of(tmp_path, [item])
    assert str(caught.value).startswith(f"{tmp_path / 'actors.yaml'}, line 1: walkers")


def test_unknown_keys_and_repeated_names_are_refused(tmp_path):
    with pytest.raises(UnknownNameError, match="did you mean 'speed'"):
        actors_of(tmp_path, [{"path": LINE, "sped": 1}])
    with pytest.raises(ConfigError, match="'walker_2' occurs twice"):
        actors_of(tmp_path, [{"path": LINE, "name": "walker_2"}, {"path": LINE}])
    with pytest.raises(ConfigError, match="expected a list"):
        actors_of(tmp_path, {"path": LINE})


def test_a_world_brings_its_people(tmp_path):
    source = load_world("hall_12").directory / "world.sdf"
    (tmp_path / "world.sdf").write_text(source.read_text())
    assert load_world(tmp_path).walkers == ()
    (tmp_path / "actors.yaml").write_text("walkers:\n  - path: [[0, 0], [2, 0]]\n")
    assert [walker.name for walker in load_world(tmp_path).walkers] == ["walker_1"]
