"""Mutated robots and fleets: each loads, or is refused with a SwarmError. Never anything else.

A few of each run always; many with `FUZZ_EXAMPLES=10000 pytest tests/fuzz --timeout=0`.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings

from swarm_common.errors import SwarmError
from swarm_common.fleet import load_fleet
from swarm_common.records import Pose, Twist
from swarm_common.resources import share_directory
from swarm_common.robot_io import Robot, open_robot
from swarm_sim.scene import Scene
from swarm_sim.world import World, WorldConfig
from tests.fuzz.mutation import mutated
from tests.standins.robots import LIMITS, SIZES, URDF, WHEEL, XACRO, write_packages

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "0"))
FEW, MANY = 25, 60  # examples of slow and of fast inputs, unless told otherwise
FULL = (share_directory() / "robots/turtlebot3_waffle/robot.yaml").read_text(encoding="utf-8")
PARTLY = LIMITS + (
    "description: acme.urdf\nmodel: own\npackages: ['..']\nxacro_args: {a: 1}\n"
    "wheels: {left: [left_wheel_joint], right: [right_wheel_joint]}\n"
    "lidar: {frame: lidar_link, rays: 90, rate: 5.0, yaw: 0.1}\n"
    "footprint: [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]\n"
)
FLEET = """order: mixed
groups:
  - {model: turtlebot3_burger, count: 3, limits: {max_vel_x: 0.2}, mission: loading_route}
  - model: turtlebot3_waffle
    count: 2
    start: {x_min: 0.0, y_min: 0.0, x_max: 4.0, y_max: 4.0, pitch: 1.0, yaw: 0.5}
"""


def of(usual: int) -> settings:
    return settings(
        max_examples=EXAMPLES or usual,
        deadline=None,
        derandomize=not EXAMPLES,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return write_packages(tmp_path_factory.mktemp("workspace"))


def try_robot(path: Path) -> None:
    try:
        robot = open_robot(path)
    except SwarmError:
        return
    drive(robot)


def drive(robot: Robot) -> None:
    """Let a robot that was accepted drive for a moment in either engine."""
    for engine in ("planar", "bullet"):
        try:
            world = World(
                Scene("field", Path("."), ()),
                [robot.spec],
                [Pose(0.0, 0.0, 0.0)],
                WorldConfig(engine=engine),
                models={robot.spec.model: robot.model},
            )
        except SwarmError:
            continue
        try:
            world.step([Twist(0.1, 0.1, 0.1)], [None])
            world.observe()
        finally:
            world.close()


def put(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    return path


@of(MANY)
@given(text=mutated(URDF))
def test_urdf(packages: tuple[Path, Path], text: str) -> None:
    put(packages[0].with_name("robot.yaml"), f"description: {packages[0].name}\n" + LIMITS)
    try_robot(put(packages[0], text))


@of(FEW)
@given(text=mutated(XACRO))
def test_xacro(packages: tuple[Path, Path], text: str) -> None:
    settings_of_xacro(packages[1])
    try_robot(put(packages[1], text))


@of(FEW)
@given(text=mutated(WHEEL, SIZES))
def test_included_xacro(packages: tuple[Path, Path], text: str) -> None:
    settings_of_xacro(packages[1])
    put(packages[1], XACRO)
    folder = packages[1].parents[3] / "vendor" / "acme_parts" / "urdf"
    name = "wheel.xacro" if "acme_wheel" in text or "macro" in text else "sizes.xacro"
    try:
        put(folder / name, text)
        try_robot(packages[1])
    finally:
        put(folder / "wheel.xacro", WHEEL)
        put(folder / "sizes.xacro", SIZES)


@of(MANY)
@given(text=mutated(FULL, PARTLY))
def test_robot_yaml(packages: tuple[Path, Path], text: str) -> None:
    put(packages[0], URDF)
    try_robot(put(packages[0].with_name("robot.yaml"), text))


@of(MANY)
@given(text=mutated(FLEET))
def test_fleet(packages: tuple[Path, Path], text: str) -> None:
    path = put(packages[0].with_name("fleet.yaml"), text)
    try:
        fleet = load_fleet(path)
    except SwarmError:
        return
    assert all(member.limits_in_force for member in fleet.members)


def settings_of_xacro(path: Path) -> None:
    put(
        path.with_name("acme_big.robot.yaml"),
        LIMITS + "lidar: {frame: laser, rays: 90, rate: 5.0}\npackages: [../../../vendor]\n",
    )
