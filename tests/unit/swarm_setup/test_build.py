"""Interface packages as sources: dependencies, order, cache keys."""

import errno
import os
import re
import subprocess
import sys

import pytest

from swarm_common.files.resources import share_directory
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_setup import build
from swarm_setup.rosidl import install, packages

MANIFEST = """<?xml version="1.0"?>
<package format="3"><name>{name}</name>{depends}</package>
"""


def write_package(root, name, *depends, field="bool ready"):
    folder = root / name
    (folder / "msg").mkdir(parents=True)
    text = "".join(f"<depend>{other}</depend>" for other in depends)
    (folder / "package.xml").write_text(MANIFEST.format(name=name, depends=text))
    (folder / "msg" / "State.msg").write_text(f"{field}\n")
    return folder


def test_packages_come_after_their_dependencies(tmp_path):
    found = packages.load_packages(share_directory("interfaces") / "interfaces")
    names = [package.name for package in found]
    own = {"simulation_interfaces", "swarm_interfaces"}
    assert set(names) == own | {"geographic_msgs", "map_msgs", "nav2_msgs", "tf2_msgs"}
    assert names.index("geographic_msgs") < names.index("nav2_msgs")
    write_package(tmp_path, "a_msgs", "b_msgs", "std_msgs")
    write_package(tmp_path, "b_msgs", "c_msgs")
    write_package(tmp_path, "c_msgs")
    assert [p.name for p in packages.load_packages(tmp_path)] == ["c_msgs", "b_msgs", "a_msgs"]


def test_everything_that_basic_navigator_imports_is_defined():
    found = packages.load_packages(share_directory("interfaces") / "interfaces")
    nav2 = next(package for package in found if package.name == "nav2_msgs")
    actions = {path.stem for path in nav2.files if path.suffix == ".action"}
    services = {path.stem for path in nav2.files if path.suffix == ".srv"}
    assert actions >= {
        "AssistedTeleop",
        "BackUp",
        "ComputePathThroughPoses",
        "ComputePathToPose",
        "DockRobot",
        "DriveOnHeading",
        "FollowGPSWaypoints",
        "FollowPath",
        "FollowWaypoints",
        "NavigateThroughPoses",
        "NavigateToPose",
        "SmoothPath",
        "Spin",
        "UndockRobot",
        "Wait",
    }
    assert services >= {
        "ClearCostmapAroundPose",
        "ClearCostmapAroundRobot",
        "ClearCostmapExceptRegion",
        "ClearEntireCostmap",
        "GetCostmap",
        "LoadMap",
        "ManageLifecycleNodes",
    }


def test_circular_dependency_is_an_error(tmp_path):
    write_package(tmp_path, "a_msgs", "b_msgs")
    write_package(tmp_path, "b_msgs", "a_msgs")
    with pytest.raises(ConfigError, match="depend on each other: a_msgs, b_msgs"):
        packages.load_packages(tmp_path)


def test_malformed_manifest_is_named(tmp_path):
    folder = write_package(tmp_path, "a_msgs")
    (folder / "package.xml").write_text("<package>")
    with pytest.raises(ConfigError, match=r"a_msgs/package\.xml is malformed"):
        packages.load_package(folder)


def test_package_without_definitions_is_an_error(tmp_path):
    folder = write_package(tmp_path, "a_msgs")
    (folder / "msg" / "State.msg").unlink()
    with pytest.raises(ConfigError, match="defines no message, service or action"):
        packages.load_package(folder)


def test_key_depends_on_content_only(tmp_path):
    first = packages.load_package(write_package(tmp_path / "1", "a_msgs"))
    second = packages.load_package(write_package(tmp_path / "2", "a_msgs"))
    changed = packages.load_package(write_package(tmp_path / "3", "a_msgs", field="int8 ready"))
    key = packages.content_key([first], "gcc 12")
    assert packages.content_key([second], "gcc 12") == key
    assert packages.content_key([changed], "gcc 12") != key
    assert packages.content_key([first], "gcc 13") != key


def test_categories_have_the_numbers_of_the_published_standard():
    """simulation_interfaces 1.x and 2.x; a client of another build filters by these."""
    folder = share_directory("interfaces") / "interfaces" / "simulation_interfaces" / "msg"
    text = (folder / "EntityCategory.msg").read_text(encoding="utf-8")
    numbers = dict(re.findall(r"^uint8 CATEGORY_(\w+) *= *(\d+)", text, re.MULTILINE))
    assert numbers == {
        "OBJECT": "0", "ROBOT": "1", "HUMAN": "2", "DYNAMIC_OBJECT": "4", "STATIC_OBJECT": "5",
    }  # fmt: skip


def test_a_build_of_another_process_is_waited_for_and_named(tmp_path, capfd):
    script = (
        "import fcntl, sys, time; file = open(sys.argv[1], 'w');"
        " fcntl.flock(file, fcntl.LOCK_EX); print(flush=True); time.sleep(1.0)"
    )
    command = [sys.executable, "-c", script, str(tmp_path / "lock")]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as other:
        other.stdout.readline()
        with build._lock(tmp_path):
            assert other.wait(10.0) == 0
    assert "another process builds the interface packages" in capfd.readouterr().err
    with build._lock(tmp_path):
        pass
    assert capfd.readouterr().err == ""


def built_tree(folder, contents, *modules):
    for part in ("lib", "include", "share", "python/mine_msgs"):
        (folder / part).mkdir(parents=True)
    for file in ("lib/libmine_msgs__c.so", *(f"python/mine_msgs/{name}.py" for name in modules)):
        (folder / file).write_text(contents, encoding="utf-8")
    return folder


def test_an_update_leaves_a_swarm_that_runs_what_it_has_loaded(tmp_path):
    """Libraries were written into while processes had them mapped: they ended by SIGSEGV."""
    environment = install.Environment(tmp_path / "venv", tmp_path / "venv" / "site-packages")
    first = built_tree(tmp_path / "1", "old", "__init__", "gone")
    install.install("mine_msgs", "1", first, environment)
    library = environment.prefix / "lib" / "libmine_msgs__c.so"
    package = environment.site_packages / "mine_msgs"
    with library.open("rb") as loaded, (package / "__init__.py").open("rb") as imported:
        second = built_tree(tmp_path / "2", "new and longer", "__init__", "come")
        install.install("mine_msgs", "2", second, environment)
        assert (loaded.read(), imported.read()) == (b"old", b"old")
    assert library.read_text(encoding="utf-8") == "new and longer"
    assert sorted(file.name for file in package.iterdir()) == ["__init__.py", "come.py"]
    assert [file.name for file in library.parent.iterdir()] == [library.name]
    assert environment.installed() == {"mine_msgs": "2"}


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS])
def test_an_environment_of_somebody_else_is_named(tmp_path, monkeypatch, number):
    """shutil.copytree gathers what fails into an error of its own: it was a traceback."""
    environment = install.Environment(tmp_path / "venv", tmp_path / "venv" / "site-packages")
    tree = built_tree(tmp_path / "1", "new", "__init__")

    def refuse(source, target):
        raise OSError(number, os.strerror(number), str(target))

    monkeypatch.setattr(install.shutil, "copy2", refuse)
    with pytest.raises(SwarmError, match=r"no permission to install mine_msgs into .*/venv: "):
        install.install("mine_msgs", "1", tree, environment)
