"""A package in the form that real ones have: a Gazebo world, models with configs, and meshes."""

import shutil
from pathlib import Path

import shapely
import trimesh

from tests.fakes.robots import PACKAGES

CONFIG = """<?xml version="1.0"?>
<model><name>{name}</name><version>1.0</version>
<sdf version="1.4">model-1_4.sdf</sdf><sdf version="1.6">model.sdf</sdf>
<description>for tests</description></model>
"""


def write_package(folder: Path) -> Path:
    """Write the package; return its world file."""
    models = folder / "office" / "models"
    shutil.copytree(PACKAGES / "office", folder / "office")
    for name in ("table", "barrier", "bay"):
        (models / name / "meshes").mkdir()
        (models / name / "model.config").write_text(CONFIG.format(name=name))
        (models / name / "model-1_4.sdf").write_text("<sdf version='1.4'><broken/></sdf>")
    profile = shapely.Polygon(
        [(-0.4, 0), (0.4, 0), (0.1, 0.5), (0.1, 1.1), (-0.1, 1.1), (-0.1, 0.5)]
    )
    barrier = trimesh.creation.extrude_polygon(profile, 4.0)
    barrier.apply_transform([[1, 0, 0, 0], [0, 0, 1, -2], [0, 1, 0, 0], [0, 0, 0, 1]])
    barrier.export(models / "barrier" / "meshes" / "barrier.dae")
    corner = shapely.Polygon([(0, 0), (2, 0), (2, 0.2), (0.2, 0.2), (0.2, 2), (0, 2)])
    curb = trimesh.creation.extrude_polygon(corner, 0.2)
    curb.export(models / "bay" / "meshes" / "curb.stl")
    return folder / "office" / "worlds" / "office.world"
