"""Any triangles are a shape: what a plane cuts is on the map, and the LiDAR sees it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarm_common.model.engines import BULLET, check_engine
from swarm_common.model.grid import OCCUPIED
from swarm_common.model.records import LidarSpec, Pose, Twist
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.scene import Scene
from swarm_sim.maps.raster import draw_grid
from swarm_sim.maps.spawn import wall_distance
from swarm_sim.maps.world_check import differences
from swarm_sim.scene.section import section_between
from swarm_sim.sensing.lidar import LidarGroup
from swarm_sim.world.world import World, WorldConfig
from tests.oracles.triangles import body_of, hits, raw

FloatArray = NDArray[np.float64]
HEIGHT = 0.132
NEAR = 0.006  # [m] sheet and detail
WAFFLE = load_robot("turtlebot3_waffle")
NOBODY: FloatArray = np.zeros((0, 2))


def box(x, y, z):
    mesh = trimesh.creation.box((x, y, z))
    mesh.apply_translation((0.0, 0.0, z / 2.0))
    return mesh


def with_faces(mesh, faces):
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def double_faced(mesh):
    return with_faces(mesh, np.vstack([mesh.faces, mesh.faces[:, ::-1]]))


def upright_quads(corners, height=2.0):
    """Return a closed line of single sheets."""
    vertices, faces = [], []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        k = len(vertices)
        vertices += [(*a, 0.0), (*b, 0.0), (*b, height), (*a, height)]
        faces += [(k, k + 1, k + 2), (k, k + 2, k + 3)]
    return trimesh.Trimesh(vertices, faces, process=False)


def room(half):
    return upright_quads([(-half, -half), (half, -half), (half, half), (-half, half)])


def soup(rng, count, size=0.4):
    middles = rng.uniform((-2.0, -2.0, 0.0), (2.0, 2.0, 0.4), (count, 3))
    corners = middles[:, None] + rng.normal(0.0, size, (count, 3, 3))
    return trimesh.Trimesh(
        corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3), process=False
    )


def section(mesh):
    return section_between([body_of(mesh)], HEIGHT, HEIGHT)


def drawn(mesh, resolution=0.05):
    return draw_grid(section(mesh), NOBODY, resolution)


def occupied(grid):
    return int((grid.cells == OCCUPIED).sum())


def seen(cut, origins, rays=360):
    """Return the points (n, 2) that a LiDAR's rays hit."""
    spec = LidarSpec(
        x=0.0, y=0.0, z=HEIGHT, rays=rays, angle_min=0.0123, angle_increment=2.0 * np.pi / rays,
        range_min=0.0, range_max=100.0, rate=5.0, sigma=0.0,
    )  # fmt: skip
    group = LidarGroup(spec, range(len(origins)), cut, [])
    poses = np.column_stack([origins, np.zeros(len(origins))])
    ranges = group.cast(poses)
    angles = spec.angle_min + spec.angle_increment * np.arange(rays)
    reached = np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)
    points = origins[:, None] + reached
    kept: FloatArray = points[np.isfinite(points).all(axis=-1)]
    return kept


def gaps_to_triangles(points, bodies):
    at = np.column_stack([points, np.full(len(points), HEIGHT)])
    distances: FloatArray = trimesh.proximity.closest_point(raw(bodies), at)[1]
    return distances


def check(bodies, origins, resolution=0.05):
    """Compare section, LiDAR and map with the triangles."""
    cut = section_between(bodies, HEIGHT, HEIGHT)
    outside = origins[wall_distance(origins, cut) > 0.01]
    real = hits(raw(bodies), outside, HEIGHT, 180)
    assert (wall_distance(real, cut) <= NEAR).all(), "a triangle is missing"
    measured = seen(cut, outside)
    if len(measured):
        assert gaps_to_triangles(measured, bodies).max() <= NEAR, "the LiDAR sees nothing real"
    grid = draw_grid(cut, NOBODY, resolution)
    for x, y in real:
        row, column = grid.cell_of(float(x), float(y))
        around = grid.cells[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2]
        assert (around == OCCUPIED).any(), f"the map lacks ({x}, {y})"


def ring(radius, count=8):
    angles = 0.1 + 2.0 * np.pi * np.arange(count) / count
    return np.vstack([[0.01, 0.02], radius * np.column_stack([np.cos(angles), np.sin(angles)])])


def test_a_box_with_faces_on_both_sides_is_a_box():
    plain = box(4.0, 0.2, 1.0)
    turned = with_faces(plain, plain.faces[:, ::-1])
    assert occupied(drawn(plain)) == 320
    for mesh in (double_faced(plain), turned, double_faced(double_faced(plain))):
        np.testing.assert_array_equal(drawn(mesh).cells, drawn(plain).cells)
        check([body_of(mesh)], ring(3.0))
    front, back = box(4.0, 0.2, 1.0), box(4.0, 0.2, 1.0).subdivide()
    mesh = trimesh.util.concatenate([front, with_faces(back, back.faces[:, ::-1])])
    np.testing.assert_array_equal(drawn(mesh).cells, drawn(front).cells)


@pytest.mark.parametrize("half", [3.0, 3.025, 2.9999, 3.002])
@pytest.mark.parametrize("resolution", [0.02, 0.05, 0.1])
@pytest.mark.parametrize("is_double", [False, True])
def test_a_room_of_four_sheets(half, resolution, is_double):
    mesh = double_faced(room(half)) if is_double else room(half)
    grid = draw_grid(section(mesh), NOBODY, resolution)
    side = round(2.0 * half / resolution)
    assert occupied(grid) >= 4 * side - 4
    assert grid.cells[grid.cell_of(0.0, 0.0)] != OCCUPIED
    check([body_of(mesh)], ring(1.0), resolution)


@pytest.mark.parametrize("offset", np.linspace(0.0, 0.05, 11).tolist())
@pytest.mark.parametrize("angle", [0.0, 0.003, 0.5, np.pi / 4.0])
def test_a_sheet_at_every_offset_to_the_grid(offset, angle):
    sheet = upright_quads([(-2.0, offset), (2.0, offset)])
    sheet.apply_transform(trimesh.transformations.rotation_matrix(angle, (0, 0, 1)))
    corner = box(0.2, 0.2, 1.0)
    corner.apply_translation((-3.0, -3.0, 0.0))
    bodies = [body_of(sheet), body_of(corner, "corner::link")]
    check(bodies, np.array([[0.0, 1.0], [0.0, -1.0], [1.3, 0.7]]))
    grid = draw_grid(section_between(bodies, HEIGHT, HEIGHT), NOBODY)
    for share in np.linspace(-1.99, 1.99, 200):
        x, y = (
            share * np.cos(angle) - offset * np.sin(angle),
            (share * np.sin(angle) + offset * np.cos(angle)),
        )
        row, column = grid.cell_of(float(x), float(y))
        assert (grid.cells[row - 1 : row + 2, column - 1 : column + 2] == OCCUPIED).any()


def test_solids_that_cross_touch_or_hold_each_other():
    cross = trimesh.util.concatenate([box(4.0, 0.2, 1.0), box(0.2, 4.0, 1.0)])
    check([body_of(cross)], ring(3.0))
    assert occupied(drawn(cross)) == 2 * 320 - 16
    inner = box(2.0, 2.0, 0.8)
    hall = trimesh.util.concatenate([box(3.0, 3.0, 1.0), with_faces(inner, inner.faces[:, ::-1])])
    grid = drawn(hall)
    assert grid.cells[grid.cell_of(0.0, 0.0)] != OCCUPIED
    assert grid.cells[grid.cell_of(1.25, 0.0)] == OCCUPIED


def test_a_long_needle_is_there_up_to_its_tip():
    """Its last 0.4 m are narrower than the lattice on which shadows are joined."""
    needle = trimesh.Trimesh(
        [(13.17, 2.335, 0.1001), (-35.8419, 2.141046, 0.21573), (-35.8418, 2.14104, 0.215736)],
        [(0, 1, 2)],
        process=False,
    )
    body = body_of(needle)
    section = section_between([body], 0.005, 0.192)
    tip = max(float(outline[:, 0].max()) for outline in section.outlines())
    assert tip == pytest.approx(13.17, abs=0.01)


def test_hairs_are_felt_though_single_precision_gives_them_no_width():
    hairs = trimesh.Trimesh(
        [
            (-0.9639002680778503, -4.752672737911343, 0.45087549090385437),
            (-0.9638999104499817, -4.752664231359958, 0.45087501406669617),
            (0.05002235993742943, -26.279579002857208, -0.7456051707267761),
            (0.8588606715202332, 6.193722728639841, 0.8018251061439514),
            (0.8588610887527466, 6.193720968663692, 0.8018245100975037),
            (-0.2384219914674759, -33.45083179056644, -0.8039329051971436),
        ],
        [(1, 0, 2), (4, 5, 3)],
        process=False,
    )
    cos, sin = -0.014224174744686464, -0.9998988313088643
    lying = np.array([[cos, 0, sin, -1], [0, 1, 0, -2], [-sin, 0, cos, 0], [0, 0, 0, 1]])
    body = replace(body_of(hairs), world_from_body=lying)
    scene = Scene("hairs", Path("."), (body,))
    assert list(differences(scene, [0.1], (0.005, 0.192), with_physics=True)) == []


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31), count=st.integers(1, 150), copies=st.integers(0, 2))
def test_random_soups(seed, count, copies):
    rng = np.random.default_rng(seed)
    mesh = soup(rng, count, float(rng.uniform(0.05, 0.6)))
    for _ in range(copies):
        mesh = double_faced(mesh)
    if rng.random() < 0.5:
        mesh.vertices = np.round(mesh.vertices, 1)  # onto cell corners, and flat triangles
    check([body_of(mesh)], rng.uniform(-3.0, 3.0, (12, 2)), float(rng.choice([0.02, 0.05, 0.1])))


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31), count=st.integers(1, 6))
def test_random_solids(seed, count):
    rng = np.random.default_rng(seed)
    meshes = []
    for _ in range(count):
        mesh = [box(0.5, 0.7, 0.6), trimesh.creation.icosphere(2, 0.4), trimesh.creation.torus(
            0.5, 0.15, 16, 8)][rng.integers(3)]  # fmt: skip
        mesh.apply_transform(trimesh.transformations.random_rotation_matrix(rng.random(3)))
        mesh.apply_translation(rng.uniform((-1.5, -1.5, 0.0), (1.5, 1.5, 0.3)))
        if rng.random() < 0.5:
            mesh = double_faced(mesh)
        if rng.random() < 0.3:
            mesh = with_faces(mesh, mesh.faces[rng.random(len(mesh.faces)) < 0.9])
        meshes.append(mesh)
    check([body_of(trimesh.util.concatenate(meshes))], rng.uniform(-3.0, 3.0, (12, 2)))


WALLS = {
    "double-faced": double_faced(box(0.2, 4.0, 1.0)),
    "inside out": with_faces(box(0.2, 4.0, 1.0), box(0.2, 4.0, 1.0).faces[:, ::-1]),
    "a sheet": upright_quads([(0.0, -2.0), (0.0, 2.0)]),
    "holed": with_faces(box(0.2, 4.0, 1.0), box(0.2, 4.0, 1.0).faces[1:]),
}


@pytest.mark.parametrize("engine", ["planar", "bullet"])
@pytest.mark.parametrize("kind", WALLS)
@pytest.mark.parametrize("yaw", [0.0, np.pi], ids=["from the west", "from the east"])
def test_a_blind_robot_driven_into_a_mesh_is_one_collision(engine, kind, yaw):
    scene = Scene("wall", Path("."), (body_of(WALLS[kind], "wall::link"),))
    start = Pose(-0.6 * np.cos(yaw), 0.3, yaw)
    world = World(scene, [WAFFLE], [start], WorldConfig(engine=engine, with_lidar=False), 0)
    for _ in range(50):
        world.step([Twist(0.26)], [None])
    (collision,) = world.verdict.collisions
    assert collision.obstacle == "wall::link"
    assert abs(world.ground_truth()[0][0].x) > 0.04  # it has not gone through
    world.close()


def test_contacts_do_not_need_the_section(monkeypatch):
    """The verdict is that of the triangles, even if no outline knew of the mesh."""
    check_engine(BULLET, "its contacts")
    nothing = section_between([], 0.0, 1.0)
    for module in ("fixed_bodies", "surroundings"):
        monkeypatch.setattr(
            f"swarm_sim.physics.bullet.{module}.section_between", lambda *_: nothing
        )
    scene = Scene("wall", Path("."), (body_of(WALLS["double-faced"], "wall::link"),))
    config = WorldConfig(engine="bullet", with_lidar=False)
    world = World(scene, [WAFFLE], [Pose(-0.6, 0.3, 0.0)], config, 0)
    for _ in range(50):
        world.step([Twist(0.26)], [None])
    assert [c.obstacle for c in world.verdict.collisions] == ["wall::link"]
    world.close()
