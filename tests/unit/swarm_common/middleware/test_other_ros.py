"""A shell that has sourced another ROS 2: its packages and middleware are set aside, and told."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from swarm_common.middleware.other_ros import (
    libraries_of_others,
    own_first,
    set_aside,
    unusable_packages,
    without,
)

COMMAND = "import sys; from {module} import {function}; sys.exit({function}())"
COMMANDS = (
    ("swarm_commander.cli.main", "swarm_up", ("--help",)),
    ("swarm_commander.cli.main", "teleop", ("--help",)),
    ("swarm_ros2.cli", "main", ("interface", "package", "std_srvs")),
)


def sourced(folder, *parts):
    packages = folder.joinpath(*parts)
    (packages / "rclpy").mkdir(parents=True)
    (packages / "rclpy" / "__init__.py").write_text("raise ImportError('for another Python')")
    (folder / "share" / "ament_index").mkdir(parents=True)
    return packages


@pytest.mark.parametrize(
    "parts",
    [("lib", "python3.10", "site-packages"), ("local", "lib", "python3.10", "dist-packages")],
)
def test_packages_for_another_python_are_unusable(tmp_path, parts):
    folder = f"{sourced(tmp_path, *parts)}"
    assert unusable_packages({"PYTHONPATH": f"/somewhere:{folder}"}, "3.11") == [folder]
    assert unusable_packages({"PYTHONPATH": folder}, "3.10") == []


def test_what_is_set_aside_is_not_imported_from(tmp_path, monkeypatch, capsys):
    """Python leaves the slash at a folder's end out of sys.path."""
    folder = str(sourced(tmp_path, "lib", "python2.7", "site-packages"))
    monkeypatch.setenv("PYTHONPATH", f"{folder}/:{tmp_path}")
    monkeypatch.setenv("LD_LIBRARY_PATH", "")
    monkeypatch.setattr(sys, "path", [folder, "", *sys.path])
    set_aside("swarm-up")
    assert folder not in sys.path
    assert os.environ["PYTHONPATH"] == str(tmp_path)
    assert f"swarm-up: not used: {folder}/ on PYTHONPATH" in capsys.readouterr().err


def test_other_folders_stay_and_search_paths_keep_their_order(tmp_path):
    own = tmp_path / "lib" / "python3.10" / "site-packages"  # not of a ROS 2
    own.mkdir(parents=True)
    assert unusable_packages({"PYTHONPATH": f"{own}::{tmp_path}"}, "3.11") == []
    assert unusable_packages({}, "3.11") == []
    assert without("/a:/b:/c", ["/b"]) == "/a:/c"
    assert own_first("/opt/ros/lib:/env/lib:/x:/env/more", Path("/env")) == (
        "/env/lib:/env/more:/opt/ros/lib:/x"
    )
    assert own_first("", Path("/env")) == ""


@pytest.mark.parametrize(("module", "function", "words"), COMMANDS)
def test_commands_run_beside_a_foreign_ros(tmp_path, module, function, words):
    """They ended with rcl's exit code 102, or with a traceback of the other rclpy."""
    packages = sourced(tmp_path, "lib", "python2.7", "site-packages")
    environment = os.environ | {
        "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
        "PYTHONPATH": f"{packages}:{os.environ.get('PYTHONPATH', '')}".rstrip(":"),
        "LD_LIBRARY_PATH": f"{tmp_path / 'lib'}:{os.environ.get('LD_LIBRARY_PATH', '')}",
        "PATH": str(Path(sys.executable).parent),
    }
    code = COMMAND.format(module=module, function=function)
    done = subprocess.run(
        [sys.executable, "-c", code, *words],
        env=environment, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert done.stderr.count(f"not used: {packages} on PYTHONPATH") == 1
    assert done.stderr.count("not used: RMW_IMPLEMENTATION=rmw_cyclonedds_cpp") == 1


def test_libraries_of_another_environment_are_told_from_ours(tmp_path):
    packages = Path("lib", "python3.11", "site-packages", "ros_rclpy.libs")
    ours, other = tmp_path / "ours" / packages, tmp_path / "other" / packages
    ours.mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "ours")
    kept = f"{tmp_path / 'link' / packages}:{tmp_path / 'ours' / 'lib'}:/usr/lib"
    folders = f"{other}/:{other.parents[2]}::{kept}"
    assert libraries_of_others(folders, {ours}) == [f"{other}/", str(other.parents[2])]
    assert libraries_of_others(kept, {ours}) == []
    assert libraries_of_others("", set()) == []


@pytest.mark.parametrize("is_lib_first", [False, True])
@pytest.mark.parametrize("bootstrapped", [{"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}, {}])
def test_a_program_of_another_environment_starts_a_command(tmp_path, bootstrapped, is_lib_first):
    """Its libraries were loaded in place of ours: a world ended with an undefined symbol."""
    libraries = tmp_path / "lib" / "python3.11" / "site-packages" / "ros_rcl_interfaces.libs"
    libraries.mkdir(parents=True)
    message = tmp_path / "lib" / "libsimulation_interfaces__rosidl_generator_py.so"
    for file in (libraries / "librcl.so", message):
        file.write_text("not a library")
    environment = {k: v for k, v in os.environ.items() if k != "_ROS_WHEELS_BOOTSTRAP_COMPLETE"}
    folders = [str(libraries), str(tmp_path / "lib")]  # ROS 2 from pip has them in any order
    path = os.pathsep.join(reversed(folders) if is_lib_first else folders)
    environment |= bootstrapped | {"LD_LIBRARY_PATH": path}
    code = (
        "from swarm_common.middleware import other_ros; other_ros.set_aside('swarm-up');"
        "import rclpy, simulation_interfaces.srv as s;"
        "s.SpawnEntity.__class__.__import_type_support__(); print('loaded')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout == "loaded\n"
    assert done.stderr.count(f"not used: the ROS 2 libraries of {tmp_path} on") == 1
