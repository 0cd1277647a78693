"""Test of `colcon test`: the installed package is whole, and it is the one that is found."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import swarm_common
from swarm_common.files.resources import share_directory
from swarm_describe.robots.source import find_robot
from swarm_describe.worlds.world_file import find_world

PREFIX = Path(os.environ["AMENT_PREFIX_PATH"].split(os.pathsep)[0])


def test_modules_and_data_are_those_of_the_install_space() -> None:
    """Not those of the checkout, nor of another installation."""
    assert PREFIX in Path(swarm_common.__file__).parents
    assert PREFIX in share_directory().parents
    assert PREFIX in find_world("slim_blockage").parents
    assert PREFIX in find_robot("turtlebot3_waffle").settings.parents


def test_a_program_runs() -> None:
    """One that needs the data, as `ros2 run` starts it."""
    program = PREFIX / "lib" / "swarm_commander" / "swarm_up"
    done = subprocess.run((program, "--list"), capture_output=True, text=True, check=True)
    assert "slim_blockage" in done.stdout
