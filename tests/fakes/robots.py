"""Robot packages in the form that real ones have, written for a test."""

import shutil
from pathlib import Path

PACKAGES = Path(__file__).with_name("packages")
PACKAGE = """<?xml version="1.0"?>
<package format="3"><name>{name}</name><version>0.0.1</version>
  <description>For a test</description><maintainer email="a@example.com">a</maintainer>
  <license>Apache-2.0</license></package>
"""

LIMITS = "max_vel_x: 0.5\nmax_vel_theta: 1.5\nacc_lim_x: 1.0\nacc_lim_theta: 2.0\n"

# A plain URDF: base_link as its root, a caster that swivels, missing inertials, names behind a
# placeholder, a mesh as its body, Gazebo Classic's plugins.
URDF = (PACKAGES / "acme_description/urdf/acme.urdf").read_text(encoding="utf-8")

XACRO = (PACKAGES / "acme_description/urdf/acme_big.urdf.xacro").read_text(encoding="utf-8")

WHEEL = (PACKAGES / "acme_parts/urdf/wheel.xacro").read_text(encoding="utf-8")

SIZES = (PACKAGES / "acme_parts/urdf/sizes.xacro").read_text(encoding="utf-8")


def write_packages(workspace: Path) -> tuple[Path, Path]:
    """Write a workspace with two packages; return the paths of a URDF and of a xacro."""
    import trimesh

    own, parts = workspace / "acme" / "acme_description", workspace / "vendor" / "acme_parts"
    for folder in (own, parts):
        shutil.copytree(PACKAGES / folder.name, folder)
        (folder / "meshes").mkdir()
        (folder / "package.xml").write_text(PACKAGE.format(name=folder.name), encoding="utf-8")
    trimesh.creation.box((400.0, 200.0, 60.0)).export(own / "meshes" / "body.stl")
    wheel = trimesh.creation.cylinder(radius=0.06, height=0.04, sections=24)
    wheel.apply_transform(trimesh.transformations.rotation_matrix(1.5707963, (1.0, 0.0, 0.0)))
    wheel.export(parts / "meshes" / "wheel.obj")
    return own / "urdf" / "acme.urdf", own / "urdf" / "acme_big.urdf.xacro"
