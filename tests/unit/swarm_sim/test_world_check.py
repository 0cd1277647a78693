"""What is made of a world is compared with its triangles, and who hides something is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from swarm_common.errors import WorldError
from swarm_sim import mesh_section, world_check
from swarm_sim.scene import Body, Box, Cylinder, Part, Scene, Sphere, transform_from_xyz_rpy
from swarm_sim.sdf import load_world, world_names
from swarm_sim.world_check import checked, differences, picture
from tests.oracles.triangles import body_of
from tests.unit.swarm_sim.gazebo_package import write_package
from tests.unit.swarm_sim.test_mesh_soups import double_faced, room, soup

REACH = (0.005, 0.192)
SCANS = (0.132, 0.182)


def found(scene: Scene) -> list[world_check.Difference]:
    return list(differences(scene, SCANS, REACH, with_physics=True))


def scene_of(*bodies: Body) -> Scene:
    return Scene("test", Path("test.sdf"), bodies)


@pytest.mark.parametrize("world", world_names())
def test_the_worlds_that_ship_are_as_their_files_have_them(world: str) -> None:
    assert found(load_world(world)) == []


def test_a_package_with_meshes_is(tmp_path: Path) -> None:
    assert found(load_world(write_package(tmp_path))) == []


def test_every_shape_at_every_tilt() -> None:
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
def test_soups(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = soup(rng, int(rng.integers(1, 60)))
    bodies = [body_of(double_faced(mesh), "soup::link"), body_of(room(4.0), "room::link")]
    assert found(scene_of(*bodies)) == []


def test_who_is_left_out_or_invented_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_bodies_that_the_physics_engine_lacks_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(body_of(room(3.0), "room::link"))
    monkeypatch.setattr("swarm_sim.bullet_probe.pieces_of", lambda body: ())
    (difference,) = found(scene)
    assert (difference.body, difference.what) == ("room::link", "the physics engine lacks it")


def test_a_world_is_looked_at_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    scene = load_world("hall_12")
    checked(scene, SCANS, REACH, with_physics=True)
    monkeypatch.setattr(world_check, "differences", lambda *_, **__: pytest.fail("looked again"))
    checked(scene, SCANS, REACH, with_physics=True)
