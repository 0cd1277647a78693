"""Which ros2 runs, and in which environment."""

import os
from pathlib import Path

from swarm_ros2.command_line import clean_environment, find_real_ros2


def write_script(folder, text):
    folder.mkdir()
    script = folder / "ros2"
    script.write_text(text)
    script.chmod(0o755)
    return script


def test_our_own_script_is_passed_over(tmp_path):
    ours = write_script(tmp_path / "venv", "#!/usr/bin/python3\nfrom swarm_ros2.cli import main\n")
    real = write_script(tmp_path / "ros", "#!/usr/bin/python3\n# EASY-INSTALL-ENTRY-SCRIPT\n")
    path = os.pathsep.join([str(ours.parent), str(tmp_path / "missing"), str(real.parent)])
    assert find_real_ros2({"PATH": path}) == real
    assert find_real_ros2({"PATH": str(ours.parent)}) is None


def test_a_file_that_cannot_be_run_is_passed_over(tmp_path):
    real = write_script(tmp_path / "ros", "#!/bin/sh\n")
    real.chmod(0o644)
    assert find_real_ros2({"PATH": str(real.parent)}) is None


def test_wheel_libraries_do_not_reach_the_real_ros2():
    environ = {
        "LD_LIBRARY_PATH": "/venv/lib:/opt/ros/jazzy/lib:/venv/lib/python3.11/site-packages/x.libs",
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
        "ROS_DOMAIN_ID": "7",
    }
    assert clean_environment(environ, Path("/venv")) == {
        "LD_LIBRARY_PATH": "/opt/ros/jazzy/lib",
        "ROS_DOMAIN_ID": "7",
    }
    only_ours = {"LD_LIBRARY_PATH": "/venv/lib"}
    assert clean_environment(only_ours, Path("/venv")) == {}
