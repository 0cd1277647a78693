"""Worlds of hostile meshes: loaded with map = LiDAR = contacts, or refused with one clear message.

Each world has meshes in files as exporters really leave them: faces given twice, turned round,
missing, torn apart, crossing, flat, far too small, in inches; on floors, under tilted poses and
mirrored scales. Its triangles, as the file has them, are the oracle (`swarm_sim.maps.world_check`,
compared with rays of trimesh in tests/unit/swarm_sim/test_mesh_soups.py).

A few always; 20,000 with `FUZZ_EXAMPLES=20000 pytest tests/fuzz/test_hostile_worlds.py
--timeout=0`.
"""

import numpy as np
import trimesh
from hypothesis import example, given
from hypothesis import strategies as st

from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import OCCUPIED
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.reader import load_world
from swarm_sim.maps.draw_map import draw_world, reach_of
from swarm_sim.maps.spawn import spawn_poses
from swarm_sim.maps.world_check import differences
from swarm_sim.scene.section import section_between
from tests.fuzz.byte_mutation import FUZZ
from tests.oracles.triangles import hits, raw

SPEC = load_robot("turtlebot3_burger")
SCAN = SPEC.lidar.z
RAYS = 36
KINDS = (
    "box", "cylinder", "sphere", "torus", "sheet", "room", "soup", "terrain", "needle", "needles",
    "scraps",
)  # fmt: skip
WOUNDS = ("none", "double", "turned", "some turned", "holes", "torn", "jitter", "rounded", "again")
FORMATS = ("stl", "obj", "ply", "dae", "off")


def made(kind, rng):
    """Return a mesh of about a metre."""
    size = rng.uniform(0.1, 2.0, 3)
    if kind == "box":
        return trimesh.creation.box(size)
    if kind == "cylinder":
        return trimesh.creation.cylinder(size[0] / 2, size[1], sections=int(rng.integers(3, 40)))
    if kind == "sphere":
        return trimesh.creation.icosphere(int(rng.integers(0, 3)), size[0] / 2)
    if kind == "torus":
        return trimesh.creation.torus(0.3 + size[0], 0.05 + size[1] / 8, 16, 8)
    if kind == "terrain":
        x, y = (v.ravel() for v in np.meshgrid(np.linspace(-1, 1, 8), np.linspace(-1, 1, 8)))
        cells = np.arange(64).reshape(8, 8)
        a, b, c, d = (v.ravel() for v in (cells[:-1, :-1], cells[:-1, 1:], cells[1:, 1:],
                                          cells[1:, :-1]))  # fmt: skip
        faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
        return trimesh.Trimesh(np.column_stack([x, y, rng.normal(0, 0.1, 64)]), faces)
    if kind == "soup":
        count = int(rng.integers(1, 40))
        corners = rng.uniform(-1, 1, (count, 1, 3)) + rng.normal(0, 0.3, (count, 3, 3))
        return of_triangles(corners)
    if kind == "needle":
        return of_triangles(np.array([[[0, 0, 0], [2, 1e-4, 0], [2, 0, 1e-3]]]) * rng.uniform(1, 2))
    if kind == "needles":
        roots, tips = rng.uniform(-1, 1, (2, int(rng.integers(1, 6)), 3))
        spread = rng.normal(0, 10.0 ** rng.uniform(-8, -2), (2, *tips.shape))
        return of_triangles(np.stack([roots, tips + spread[0], tips + spread[1]], axis=1))
    if kind == "scraps":
        count = int(rng.integers(1, 12))
        corners = rng.normal(0, 1, (count, 1, 3)) + rng.normal(0, 1, (count, 3, 3)) * (
            10.0 ** rng.uniform(-7, 0, (count, 3, 3))
        )
        return of_triangles(corners)
    half = size[0]
    points = [(-half, -half), (half, -half), (half, half), (-half, half)]
    sides = list(zip(points, [*points[1:], points[0]], strict=True))
    sides = sides[: 1 if kind == "sheet" else int(rng.integers(2, 5))]
    quads = [[(*a, -1.0), (*b, -1.0), (*b, 1.0), (*a, 1.0)] for a, b in sides]
    return of_triangles(
        np.array([[q[i] for i in t] for q in quads for t in ((0, 1, 2), (0, 2, 3))])
    )


def of_triangles(corners):
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    return trimesh.Trimesh(corners.reshape(-1, 3), faces, process=False)


def wounded(mesh, wound, rng):
    """Return a mesh as a bad exporter leaves it."""
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    if wound == "double":
        faces = np.vstack([faces, faces[:, ::-1]])
    elif wound == "turned":
        faces = faces[:, ::-1]
    elif wound == "some turned":
        chosen = rng.random(len(faces)) < 0.5
        faces[chosen] = faces[chosen][:, ::-1]
    elif wound == "holes":
        faces = faces[rng.random(len(faces)) < 0.8]
    elif wound == "torn":
        return of_triangles(vertices[faces])
    elif wound == "jitter":
        corners = vertices[faces]
        return of_triangles(corners + rng.normal(0.0, 10.0 ** rng.uniform(-7, -2), corners.shape))
    elif wound == "rounded":
        vertices = np.round(vertices, 1)
    elif wound == "again":
        faces = np.vstack([faces] * int(rng.integers(2, 4)))
    return trimesh.Trimesh(vertices, faces, process=False)


def write(folder, seed, kinds):
    """Write a world of meshes."""
    rng = np.random.default_rng(seed)
    models = []
    for index, (kind, wound, form) in enumerate(kinds):
        mesh = wounded(made(kind, rng), wound, rng)
        file = folder / f"{index}.{form}"
        data = mesh.export(file_type=form) if len(mesh.faces) else b"solid nothing\nendsolid\n"
        data = data.encode() if isinstance(data, str) else data
        if form == "dae" and rng.random() < 0.5:
            data = data.replace(b"</asset>", b'<unit name="inch" meter="0.0254"/></asset>')
        file.write_bytes(data)
        x, y, z = rng.uniform((-3, -3, -0.5), (3, 3, 1.0)).round(int(rng.integers(0, 3)))
        roll, pitch, yaw = rng.uniform(-3.2, 3.2, 3) * (rng.random(3) < 0.4)
        scale = rng.choice([1.0, 1.0, 1.0, -1.0, 0.5, 39.37, 0.001, 0.0], 3)
        models.append(
            f"<model name='m{index}'><static>1</static>"
            f"<pose>{x} {y} {z} {roll} {pitch} {yaw}</pose>"
            f"<link name='l'><collision name='c'><geometry><mesh><uri>{file.name}</uri>"
            f"<scale>{scale[0]} {scale[1]} {scale[2]}</scale></mesh></geometry></collision></link>"
            "</model>"
        )
    if rng.random() < 0.3:
        models.append(
            f"<model name='slab'><static>1</static><pose>0 0 {rng.uniform(-0.02, 0.1)} 0 0 0</pose>"
            "<link name='l'><collision name='c'><geometry><box><size>9 9 0.05</size></box>"
            "</geometry></collision></link></model>"
        )
    path = folder / "hostile.world"
    path.write_text(f"<sdf version='1.7'><world name='w'>{''.join(models)}</world></sdf>")
    return path


def check(scene):
    reach = reach_of([SPEC])
    assert [str(found) for found in differences(scene, [SCAN], reach, with_physics=True)] == []
    grid = draw_world(scene, SCAN, reach=reach)
    origins = np.random.default_rng(0).uniform(-4.0, 4.0, (3, 2))
    if not scene.fixed or not len(section_between(scene.fixed, SCAN, SCAN).names):
        return
    for x, y in hits(raw(scene.fixed), origins, SCAN, RAYS):
        row, column = grid.cell_of(float(x), float(y))
        around = grid.cells[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2]
        assert (around == OCCUPIED).any(), f"the map lacks ({x}, {y})"


@FUZZ
@example(  # all obstacles lie beside the default starts
    seed=579,
    kinds=[("box", "none", "stl"), ("sheet", "none", "stl"), ("sheet", "some turned", "stl")],
)
@given(
    seed=st.integers(0, 2**31),
    kinds=st.lists(
        st.tuples(st.sampled_from(KINDS), st.sampled_from(WOUNDS), st.sampled_from(FORMATS)),
        min_size=1,
        max_size=3,
    ),
)
def test_loaded_as_it_is_or_refused(tmp_path_factory, seed, kinds):
    folder = tmp_path_factory.getbasetemp() / "hostile"
    folder.mkdir(exist_ok=True)
    path = write(folder, seed, kinds)
    refusal = ""
    try:
        scene = load_world(path)
    except SwarmError as error:
        refusal = str(error)
        scene = load_world(path, skip_missing=True, skip_broken=True)
    assert not refusal or str(path) in refusal
    check(scene)
    refusal = ""
    try:
        spawn_poses(scene, SPEC, 2)
    except SwarmError as error:
        refusal = str(error)
    assert not refusal or "room for" in refusal
