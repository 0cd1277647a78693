"""A robot that is told to drive and never moves is named, once."""

from pathlib import Path

import numpy as np

from swarm_common.model.records import Pose, Twist
from swarm_common.model.shapes import Box, Part
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.scene import Body, Scene
from swarm_sim.world.verdict import Standstill
from swarm_sim.world.world import World, WorldConfig


def test_it_is_told_once_of_those_that_stand_and_do_not_turn():
    watch = Standstill(2)
    for _ in range(100):
        watch.observe(np.array([[0.3, 0.0, 0.0], [0.0, 0.0, -0.3]]))
    assert [robot for robot, _ in watch.new(np.array([3.0, 0.01]))] == [1]
    assert not list(watch.new(np.array([3.0, 0.01])))
    watch.add()
    watch.observe(np.zeros((3, 3)))
    assert not list(watch.new(np.array([3.0, 0.01, 0.0])))
    watch = Standstill(1)
    for _ in range(1000):
        watch.observe(np.array([[0.0, 1.0, 0.0]]))
    assert not list(watch.new(np.zeros(1)))


def test_the_world_says_what_it_was_taken_for():
    spec = load_robot("turtlebot3_burger")
    wall = np.eye(4)
    wall[:3, 3] = (0.14, 0.0, 0.5)
    scene = Scene(
        "hall", Path("."), (Body("wall", wall, (Part(Box((0.1, 4.0, 1.0)), np.eye(4)),)),)
    )
    world = World(scene, [spec], [Pose(0.0, 0.0, 0.0)], WorldConfig(engine="bullet"))
    found: list[str] = []
    for _ in range(150):
        world.step([Twist(0.2)], [None])
        found += world.motionless()
    world.close()
    (sentence,) = found
    assert "Srobot1 does not move: it was told to drive 2.0 m, and went 0.0" in sentence
    assert "It was taken for: drive differential; wheels wheel_left_joint (left)" in sentence
