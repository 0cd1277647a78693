"""Our reading of URDF beside yourdfpy's, to the bit."""

from __future__ import annotations

import io
import random
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yourdfpy

from swarm_common.robot_io import description, robot_names
from swarm_common.shapes import Box, Cylinder, Sphere
from swarm_common.urdf_elements import Geometry, MeshFile, read_joints, read_links
from swarm_common.urdf_tree import read_tree
from tests.standins.robots import write_packages


def texts(folder: Path) -> dict[str, str]:
    """Return descriptions by name: our robots, and a foreign one with meshes."""
    own = {name: description(name) for name in robot_names()}
    return own | {"foreign": write_packages(folder)[0].read_text(encoding="utf-8")}


def turned(root: ET.Element) -> None:
    """Put every origin somewhere else, so that nothing hides behind zeros."""
    numbers = random.Random(1)
    for origin in root.iter("origin"):
        for name in ("xyz", "rpy"):
            origin.set(name, " ".join(f"{numbers.uniform(-3.0, 3.0)}" for _ in range(3)))


def plain(geometry: Geometry) -> tuple[str, list[float]]:
    match geometry:
        case Box(size):
            return "box", list(size)
        case Cylinder(radius, length):
            return "cylinder", [radius, length]
        case Sphere(radius):
            return "sphere", [radius]
        case MeshFile(filename, scale):
            return filename, list(scale)
    raise AssertionError(geometry)


def plain_of_theirs(geometry: Any) -> tuple[str, list[float]]:
    if geometry.box is not None:
        return "box", geometry.box.size.tolist()
    if geometry.cylinder is not None:
        return "cylinder", [geometry.cylinder.radius, geometry.cylinder.length]
    if geometry.sphere is not None:
        return "sphere", [geometry.sphere.radius]
    scale = 1.0 if geometry.mesh.scale is None else geometry.mesh.scale
    return geometry.mesh.filename, np.broadcast_to(scale, 3).tolist()


def origin(matrix: np.ndarray | None) -> bytes:
    return (np.eye(4) if matrix is None else matrix).tobytes()


@pytest.mark.parametrize("is_turned", [False, True])
def test_it_reads_what_yourdfpy_reads(tmp_path: Path, is_turned: bool) -> None:
    for name, text in texts(tmp_path).items():
        root = read_tree(text, name)
        if is_turned:
            turned(root)
        theirs = yourdfpy.URDF.load(
            io.BytesIO(ET.tostring(root)), build_scene_graph=False, load_meshes=False
        ).robot
        for link, their in zip(read_links(root), theirs.links, strict=True):
            assert link.name == their.name
            assert (link.inertial is None) == (their.inertial is None)
            if link.inertial is not None:
                assert link.inertial.mass == (their.inertial.mass or 0.0)
                assert origin(link.inertial.link_from_inertial) == origin(their.inertial.origin)
                if their.inertial.inertia is not None:
                    assert link.inertial.inertia.tobytes() == their.inertial.inertia.tobytes()
            for own, each in zip(link.collisions, their.collisions, strict=True):
                assert plain(own.geometry) == plain_of_theirs(each.geometry)
                assert origin(own.link_from_shape) == origin(each.origin)
        for joint, their in zip(read_joints(root), theirs.joints, strict=True):
            assert (joint.name, joint.type) == (their.name, their.type)
            assert (joint.parent, joint.child) == (their.parent, their.child)
            assert origin(joint.parent_from_child) == origin(their.origin)
            assert joint.axis.tobytes() == their.axis.tobytes()
            assert joint.velocity == getattr(their.limit, "velocity", None)


@pytest.mark.parametrize(
    "geometry", ["", "<geometry/>", "<geometry><cone/></geometry>", "<geometry><box/></geometry>"]
)
def test_a_collision_without_a_shape_is_refused(geometry: str) -> None:
    text = f'<robot name="r"><link name="a"><collision>{geometry}</collision></link></robot>'
    with pytest.raises((ValueError, KeyError)):
        read_links(read_tree(text, "r.urdf"))
