"""Wheels that turn as their robot moves."""

import io

import numpy as np
import pytest
import trimesh
from viser.transforms import SO3

from swarm_describe.robots.loading import load_robot, open_robot
from swarm_describe.robots.source import robot_names
from swarm_sim.physics.drive import Wheels
from swarm_view.scene.bodies import AWAY, Bodies
from swarm_view.scene.fleet import NEAR_ROBOTS, DrawnFleet
from swarm_view.scene.robot_mesh import RobotMesh, robot_mesh

WAFFLE = "turtlebot3_waffle"
BATCHED = ("batched_positions", "batched_wxyzs")


class Batch:
    """What viser would draw."""

    def __init__(self, glb, batched_wxyzs, batched_positions):
        self.glb = glb
        self.sent = 0
        self.is_removed = False
        self.batched_wxyzs, self.batched_positions = batched_wxyzs, batched_positions

    def __setattr__(self, name, value):
        if name in BATCHED:
            self.sent += 1
            value = np.array(value)
        super().__setattr__(name, value)

    def remove(self):
        self.is_removed = True


class Scene:
    """A viser scene, and the server that has it."""

    def __init__(self):
        self.batches: dict[str, Batch] = {}
        self.scene = self

    def add_batched_glb(self, name, glb, *, batched_wxyzs, batched_positions, **_):
        self.batches[name] = Batch(glb, batched_wxyzs, batched_positions)
        return self.batches[name]

    def add_batched_meshes_simple(self, name, *_, **values):
        self.batches[name] = Batch(b"", values["batched_wxyzs"], values["batched_positions"])
        return self.batches[name]


@pytest.fixture(scope="module")
def mesh_of():
    known: dict[str, RobotMesh] = {}

    def find(name):
        if name not in known:
            known[name] = robot_mesh(open_robot(name).urdf)
        return known[name]

    return find


@pytest.mark.parametrize("name", robot_names())
def test_wheels_turn_as_those_of_the_world(name, mesh_of):
    wheels, mesh = Wheels(load_robot(name)), mesh_of(name)
    for motion in ([0.2, 0.0, 0.0], [0.0, 0.0, 0.7], [0.1, 0.0, -0.4]):
        drawn = sorted(float(wheel.turns @ motion) for wheel in mesh.wheels)
        assert drawn == pytest.approx(sorted(wheels.rates(motion[0], motion[2], 0.0)), rel=0.02)
    if load_robot(name).is_omni:
        drawn = [float(wheel.turns @ (0.1, 0.3, -0.4)) for wheel in mesh.wheels]
        assert sorted(drawn) == pytest.approx(sorted(wheels.rates(0.1, -0.4, 0.3)), rel=0.02)


def test_a_nearby_robots_wheels_are_where_they_belong(mesh_of):
    scene, mesh = Scene(), mesh_of(WAFFLE)
    bodies = Bodies(scene, "/r", mesh, np.array([0, 2]), 8)
    poses = np.array([[0.0, 0.0, 0.0], [9.0, 9.0, 0.0], [1.0, 2.0, np.pi / 2]])
    bodies.move(poses)
    assert list(scene.batches) == ["/r"]
    assert bodies.look_at(np.array([2, 1]))
    assert not bodies.look_at(np.array([1, 2]))
    poses[2, 1] += 0.1
    bodies.move(poses)
    assert scene.batches["/r"].batched_positions[:, 2].tolist() == [0.0, AWAY]
    assert scene.batches["/r_body"].batched_positions[0] == pytest.approx([1.0, 2.1, 0.0])
    wheels = scene.batches["/r_wheel0"]
    assert sorted(wheels.batched_positions[:2, 0]) == pytest.approx([0.856, 1.144], abs=1e-3)
    assert wheels.batched_positions[:2, 1] == pytest.approx([2.1, 2.1])
    assert (wheels.batched_positions[2:, 2] == AWAY).all()
    # Whatever was ahead of the axle has gone down by the angle of the way.
    spoke = SO3(wheels.batched_wxyzs[0].astype(float)).apply(np.array([1.0, 0.0, 0.0]))
    assert spoke[1:] == pytest.approx([np.cos(0.1 / 0.033), -np.sin(0.1 / 0.033)], abs=1e-3)


def test_only_robots_near_a_camera_cost_more(mesh_of):
    scene = Scene()
    fleet = DrawnFleet(scene)
    names = [f"Srobot{i}" for i in range(1, 41)]
    fleet.assemble(names, dict.fromkeys(names, open_robot(WAFFLE).urdf))
    poses = np.column_stack([0.5 * np.arange(40.0), np.zeros(40), np.zeros(40)])
    assert not fleet.look_from([], poses)
    assert not fleet.look_from([np.array([0.0, 0.0, 20.0])], poses)
    assert not any("wheel" in name for name in scene.batches)
    assert fleet.look_from([np.array([0.0, 0.0, 20.0]), np.array([10.0, 0.0, 3.0])], poses)
    fleet.move(poses)
    apart = np.flatnonzero(scene.batches["/robots/0"].batched_positions[:, 2] == AWAY)
    assert len(apart) == NEAR_ROBOTS
    assert np.abs(poses[apart, 0] - 10.0).max() < 4.5
    assert fleet.look_from([np.array([0.0, 0.0, 20.0])], poses)
    fleet.move(poses)
    body = scene.batches["/robots/0_body"]
    assert (body.batched_positions[:, 2] == AWAY).all()
    assert (scene.batches["/robots/0"].batched_positions[:, 2] == 0.0).all()
    fleet.assemble([], {})
    assert all(batch.is_removed for batch in scene.batches.values())


def test_no_part_is_moved_twice_and_far_robots_are_simpler(mesh_of):
    for name in robot_names():
        mesh = mesh_of(name)
        for glb in (mesh.glb, mesh.body or mesh.glb, *(wheel.glb for wheel in mesh.wheels)):
            graph = trimesh.load_scene(io.BytesIO(glb), file_type="glb").graph
            for node in graph.nodes_geometry:
                np.testing.assert_array_equal(graph[node][0], np.eye(4), name)
    for name in robot_names():
        mesh = mesh_of(name)
        vertices, faces = mesh.shape
        whole = trimesh.load_scene(io.BytesIO(mesh.glb), file_type="glb").bounds
        assert len(faces) <= 250, name
        np.testing.assert_allclose(vertices.min(axis=0), whole[0], atol=0.003)
        np.testing.assert_allclose(vertices.max(axis=0), whole[1], atol=0.003)


def test_what_hangs_on_a_swivel_or_off_the_ground_is_no_wheel():
    def link(name, radius):
        visual = f"<visual><geometry><sphere radius='{radius}'/></geometry></visual>"
        return f"<link name='{name}'>{visual}</link>"

    def joint(child, place, axis, parent="base"):
        return (
            f"<joint name='{child}_joint' type='continuous'><parent link='{parent}'/>"
            f"<child link='{child}'/><origin xyz='{place}'/><axis xyz='{axis}'/></joint>"
        )

    text = (
        "<robot name='r'>"
        + link("base", 0.1)
        + link("wheel", 0.1)
        + link("swivel", 0.01)
        + link("caster", 0.1)
        + link("brush", 0.05)
        + joint("wheel", "0 0.2 0", "0 -1 0")
        + joint("swivel", "-0.2 0 0", "0 0 1")
        + joint("caster", "0 0 0", "0 1 0", "swivel")
        + joint("brush", "0.2 0 0.3", "0 1 0")
        + "</robot>"
    )
    mesh = robot_mesh(text)
    assert len(mesh.wheels) == 1
    assert mesh.wheels[0].turns == pytest.approx([-10.0, 0.0, 2.0], rel=0.05)
