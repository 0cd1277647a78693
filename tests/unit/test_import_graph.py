"""Files import downwards only: no circle of files, and no import that changes another library."""

import graphlib
import subprocess
import sys
import tomllib
from pathlib import Path

import grimp

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PACKAGES = PROJECT["tool"]["importlinter"]["root_packages"]
# Everything of Python, numba and rclpy that we could change, compared by identity.
UNCHANGED = """
import importlib, pkgutil, sys
from importlib import _bootstrap_external as loaders, machinery
import numba, numba.core.caching as caching, numba.core.dispatcher as dispatcher
import numba.np.arraymath, rclpy.executors, rclpy.node, rclpy.parameter_service, rclpy.time_source

owners = [loaders, machinery, numba, caching, dispatcher]
owners += [rclpy, rclpy.executors, rclpy.node, rclpy.parameter_service, rclpy.time_source]
owners += [kind for owner in owners[:] for kind in vars(owner).values() if isinstance(kind, type)]

def state():
    return [(owner, name, value) for owner in owners for name, value in vars(owner).items()
            if callable(value)]

before = state()
hooks = [*sys.meta_path], [*sys.path_hooks]
import swarm_common
for found in pkgutil.walk_packages(swarm_common.__path__, "swarm_common."):
    importlib.import_module(found.name)
import swarm_nav.behaviour.navigator, swarm_sim.world.world
changed = [(owner, name) for (owner, name, value) in before if vars(owner).get(name) is not value]
assert not changed, changed
from swarm_common.process import compiled_code  # its finder is that of our compiled modules
others = [each for each in sys.meta_path if type(each).__module__ != compiled_code.__name__]
assert hooks == (others, sys.path_hooks)
"""


def test_no_files_import_each_other_in_a_circle():
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    # Raises CycleError, which names the files of the circle.
    graphlib.TopologicalSorter(
        {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    ).prepare()


def test_importing_our_packages_changes_no_other_library():
    done = subprocess.run(
        [sys.executable, "-c", UNCHANGED], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
