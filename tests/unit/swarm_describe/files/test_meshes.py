"""Meshes are in metres: by the unit that COLLADA states, and by the scale of who names them."""

import numpy as np
import pytest
import trimesh
import yourdfpy

from swarm_common.model.errors import DescriptionError
from swarm_describe.files.meshes import load_hull, load_mesh
from swarm_view.scene.visuals import visuals

DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="box"><mesh>
<source id="p"><float_array id="pa" count="12">-15 -12 -4 15 -12 -4 0 12 -4 0 0 4</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="vs"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#vs" offset="0"/>
<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#box"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
SIZE = (0.30, 0.24, 0.08)  # [m]
ONE = (1.0, 1.0, 1.0)


def test_the_unit_of_collada_counts_for_robots_worlds_and_the_viewer(tmp_path):
    path, urdf = tmp_path / "box.dae", tmp_path / "r.urdf"
    path.write_text(DAE)
    urdf.write_text(
        f'<robot name="r"><link name="l"><visual><geometry><mesh filename="{path}"/></geometry>'
        "</visual></link></robot>"
    )
    robot = yourdfpy.URDF.load(str(urdf), load_meshes=False, build_scene_graph=False).robot
    for points in (
        load_mesh(path, ONE).vertices,
        np.array(load_hull(path, ONE).vertices),
        visuals(robot)[0].mesh.vertices,
    ):
        assert np.ptp(points, axis=0) == pytest.approx(SIZE)


def test_a_robots_mesh_in_millimetres_is_refused_with_the_cure(tmp_path):
    path = tmp_path / "box.stl"
    trimesh.creation.box((300.0, 240.0, 80.0)).export(path)
    with pytest.raises(DescriptionError, match=r"box.stl: .*300 m long .*scale 1 1 1.*0\.001 0"):
        load_hull(path, ONE)
    hull = load_hull(path, (0.001, 0.001, 0.001))
    assert np.ptp(np.array(hull.vertices), axis=0) == pytest.approx(SIZE)
