"""The checkout in a colcon workspace: it builds, and hides no package of ROS 2's."""

import ast
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from swarm_ros2.launcher import PROGRAMS
from swarm_setup.rosidl.packages import load_packages

pytest.importorskip("colcon_core")
ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "colcon" / "swarm_commander"


def colcon(*words, cwd):
    command = (sys.executable, "-m", "colcon", *words)
    environ = os.environ | {"COLCON_LOG_PATH": str(cwd / "log")}
    done = subprocess.run(
        command, cwd=cwd, env=environ, capture_output=True, text=True, check=False, timeout=250
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_only_our_own_packages_are_found(tmp_path):
    """Our parts of nav2_msgs and others would have hidden those of ROS 2."""
    lines = colcon("list", "--base-paths", str(ROOT), cwd=tmp_path).splitlines()
    found = {line.split("\t")[0] for line in lines}
    assert found == {"swarm_commander", "swarm_interfaces"}
    foreign = {package.name for package in load_packages(ROOT / "interfaces")} - found
    assert len(foreign) == 5
    assert all((ROOT / "interfaces" / name / "COLCON_IGNORE").exists() for name in foreign)


@pytest.mark.slow
def test_the_package_builds_passes_its_tests_and_has_its_programs(tmp_path):
    """What apt gives it is stood in for by this environment, where swarm-setup built it."""
    colcon("build", "--base-paths", str(PACKAGE), cwd=tmp_path)
    place = tmp_path / "install" / "swarm_commander"
    programs = {path.name for path in (place / "lib" / "swarm_commander").iterdir()}
    assert programs == {name for own in PROGRAMS.values() for name in own}
    assert (place / "share/swarm_commander/launch/swarm.launch.py").is_file()
    assert (place / "share/ament_index/resource_index/packages/swarm_commander").is_file()
    colcon("test", "--return-code-on-test-failure", "--base-paths", str(PACKAGE), cwd=tmp_path)
    summary = colcon("test-result", "--all", cwd=tmp_path).splitlines()[-1]
    assert summary == "Summary: 2 tests, 0 errors, 0 failures, 0 skipped"


def test_programs_and_launch_file_are_those_of_the_project():
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    named = {name.replace("-", "_"): target for name, target in scripts.items() if name != "ros2"}
    assert {name: to for own in PROGRAMS.values() for name, to in own.items()} == named
    launch = ast.parse((PACKAGE / "launch" / "swarm.launch.py").read_text())
    names = {node.name for node in launch.body if isinstance(node, ast.FunctionDef)}
    assert "generate_launch_description" in names
