import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from visualization_msgs.msg import Marker

from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_common.model.shapes import (
    Box,
    Cylinder,
    Hull,
    Plane,
    quaternion_of,
    transform_from_xyz_rpy,
)
from swarm_common.model.zones import KeepoutZone, SpeedMask, Zones
from swarm_describe.worlds.reader import load_world
from swarm_sim.ros.viewing.markers import shape_marker
from swarm_sim.ros.viewing.scene_publisher import scene_markers


@pytest.mark.parametrize("seed", range(20))
def test_quaternion_is_that_of_the_matrix(seed):
    turn = Rotation.random(rng=seed)
    found = np.array(quaternion_of(turn.as_matrix()))
    assert abs(found @ turn.as_quat()) == pytest.approx(1.0)


def test_bodies_stations_and_circuits_have_markers_of_their_size_and_place():
    scene = load_world("slim_blockage")
    markers = scene_markers(scene)
    spaces = [marker.ns for marker in markers]
    walls = [part for body in scene.bodies for part in body.parts if isinstance(part.shape, Box)]
    assert spaces.count("body") == len(walls)
    assert {m.text for m in markers if m.ns == "station"} == set(scene.sites.stations)
    assert spaces.count("circuit") == len(scene.sites.circuits)
    assert len({(marker.ns, marker.id) for marker in markers}) == len(markers)
    place = transform_from_xyz_rpy(1.0, 2.0, 3.0, 0.0, 0.0, 0.5)
    box = shape_marker(Box((1.0, 2.0, 3.0)), place)
    assert (box.type, box.scale.y, box.pose.position.z) == (Marker.CUBE, 2.0, 3.0)
    drum = shape_marker(Cylinder(0.5, 2.0), place)
    assert (drum.scale.x, drum.scale.z) == (1.0, 2.0)
    hull = Hull(((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)), ((0, 2, 1), (0, 1, 3)))
    assert len(shape_marker(hull, place).points) == 6
    assert shape_marker(Plane(), place) is None
    assert Pose(box.pose.position.x, box.pose.position.y, 0.0) == Pose(1.0, 2.0, 0.0)


def test_zones_are_flat_coloured_areas():
    keepout = KeepoutZone("k", ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)))
    mask = SpeedMask(Grid(np.array([[50, 0]], np.int8), 0.5, 3.0, 0.0), True, 0.0, 1.0)
    scene = load_world("slim_blockage")
    sites = dataclasses.replace(scene.sites, zones=Zones(keepout=(keepout,), speed_mask=mask))
    markers = {m.ns: m for m in scene_markers(dataclasses.replace(scene, sites=sites))}
    for space, area, x in (("keepout", 2.0, (0.0, 2.0)), ("speed_limit", 0.25, (3.0, 3.5))):
        marker = markers[space]
        assert marker.type == Marker.TRIANGLE_LIST
        points = np.array([(p.x, p.y) for p in marker.points])
        a, b = (points[k::3] - points[2::3] for k in (0, 1))
        assert np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2 == pytest.approx(area)
        assert (points[:, 0].min(), points[:, 0].max()) == x
