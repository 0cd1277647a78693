"""What a start spares is spared, and nothing else changes."""

import gc
import subprocess
import sys

import pytest

from swarm_common.process.quick_start import without_collector

KERNEL = """
import sys
from swarm_common.process.quick_start import load_numba
load_numba()
from swarm_nav.planning import distance_kernels
import numpy as np
occupied = np.zeros((9, 9), np.bool_)
occupied[4, 4] = True
assert distance_kernels.face_distance(occupied)[4, 0] == 3.5
assert "scipy.linalg" not in sys.modules
import scipy.linalg.cython_blas
"""
# Processes, and what is slow to import and of no use to them at their start.
OTHERS = ("matplotlib", "PIL", "scipy.linalg", "yourdfpy", "trimesh", "viser")
UNUSED = {
    "swarm_commander.cli.up_command": ("rclpy", "numba", "scipy", "shapely", "pybullet"),
    "swarm_sim.ros.node": ("rich", "typer"),
    "swarm_nav.launch.fork_server_main": ("rich", "typer", "psutil", "shapely", "pybullet"),
    "swarm_commander.cli.commander_command": ("numba", "shapely", "swarm_describe.robots"),
    "swarm_commander.mission.runner": ("rich", "typer", "numba", "scipy", "shapely", "pybullet"),
}
# rclpy's own end would wait for threads that the fork server keeps from being there.
IMPORTED = "import os, sys, {}; print(*sys.modules, flush=True); os._exit(0)"


def test_kernels_run_without_scipy_and_scipy_can_be_imported_after():
    subprocess.run([sys.executable, "-c", KERNEL], check=True, timeout=300)


def test_the_collector_is_off_within_and_on_again_after_a_failure():
    def fail():
        with without_collector():
            assert not gc.isenabled()
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert gc.isenabled()
    gc.unfreeze()


@pytest.mark.parametrize("process", UNUSED)
def test_a_process_starts_without_what_it_does_not_use(process):
    command = [sys.executable, "-c", IMPORTED.format(process)]
    modules = subprocess.run(command, check=True, timeout=300, capture_output=True, text=True)
    assert not set(modules.stdout.split()) & {*OTHERS, *UNUSED[process]}
