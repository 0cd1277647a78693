"""Building interface packages: skipped where provided, cached by content, tools named."""

import json
import os
import sys

import pytest

from swarm_commander.cli.main import setup
from swarm_setup import build as interfaces_build
from swarm_setup.rosidl import install, toolchain
from swarm_setup.rosidl.compile import BuildError, Library, Toolchain, build_all
from swarm_setup.rosidl.packages import load_package
from tests.unit.swarm_setup.test_build import write_package


@pytest.fixture
def environment(tmp_path, monkeypatch):
    """An empty environment and an empty cache, with one package to build: demo_msgs."""
    there = install.Environment(tmp_path / "env", tmp_path / "env" / "site-packages")
    write_package(tmp_path / "share" / "interfaces", "demo_msgs")
    monkeypatch.setenv("SWARM_SHARE", str(tmp_path / "share"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(install.Environment, "current", lambda: there)
    return there


@pytest.fixture
def builds(monkeypatch):
    """Replaces the build by one that writes empty trees; lists what was built."""
    built: list[str] = []

    def pretend(missing, trees, ready, tools, *, quiet):
        for package in missing:
            built.append(package.name)
            for part in ("lib", "include", "share", f"python/{package.name}"):
                (trees[package.name] / part).mkdir(parents=True)
            (trees[package.name] / "python" / package.name / "__init__.py").touch()

    monkeypatch.setattr(interfaces_build, "_build", pretend)
    return built


def test_the_same_definitions_are_not_built_again(environment, builds, tmp_path, monkeypatch):
    assert interfaces_build.ensure_interfaces(quiet=True) == ["demo_msgs"]
    assert interfaces_build.ensure_interfaces(quiet=True) == []
    assert builds == ["demo_msgs"]
    interfaces_build.ensure_interfaces(quiet=True)
    other = install.Environment(tmp_path / "other", tmp_path / "other" / "site-packages")
    monkeypatch.setattr(install.Environment, "current", lambda: other)
    assert interfaces_build.ensure_interfaces(quiet=True) == ["demo_msgs"]
    assert builds == ["demo_msgs"]
    assert (other.site_packages / "demo_msgs" / "__init__.py").exists()


def test_changed_definition_is_built_again(environment, builds, tmp_path):
    interfaces_build.ensure_interfaces(quiet=True)
    folder = tmp_path / "share" / "interfaces" / "demo_msgs"
    (folder / "msg" / "State.msg").write_text("int32 changed\n")
    assert interfaces_build.ensure_interfaces(quiet=True) == ["demo_msgs"]
    assert builds == ["demo_msgs", "demo_msgs"]


def test_removed_installation_is_restored(environment, builds):
    interfaces_build.ensure_interfaces(quiet=True)
    (environment.site_packages / "demo_msgs" / "__init__.py").unlink()
    assert interfaces_build.ensure_interfaces(quiet=True) == ["demo_msgs"]
    assert builds == ["demo_msgs"]


def test_package_of_a_full_ros_is_left_alone(environment, builds, tmp_path, monkeypatch):
    ros = tmp_path / "ros"
    (ros / "python" / "demo_msgs").mkdir(parents=True)
    (ros / "python" / "demo_msgs" / "__init__.py").touch()
    index = ros / "share" / "ament_index" / "resource_index" / "packages"
    index.mkdir(parents=True)
    (index / "demo_msgs").touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(ros))
    monkeypatch.syspath_prepend(str(ros / "python"))
    assert interfaces_build.ensure_interfaces(quiet=True) == []
    assert builds == []


def a_ros(tmp_path, version, monkeypatch):
    """Source a ROS that has demo_msgs."""
    ros = tmp_path / "ros"
    for folder in (ros / "share/demo_msgs", ros / interfaces_build.INDEX, ros / "python/demo_msgs"):
        folder.mkdir(parents=True, exist_ok=True)
    (ros / "share/demo_msgs/package.xml").write_text(f"<version>{version}</version>")
    (ros / interfaces_build.INDEX / "demo_msgs").touch()
    (ros / "python/demo_msgs/__init__.py").touch()
    monkeypatch.setattr(interfaces_build, "RELEASES", {"demo_msgs": ((1, 5), (2, 1))})
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(ros))
    monkeypatch.syspath_prepend(str(ros / "python"))
    return ros


@pytest.mark.parametrize(
    ("version", "is_fit"), [("1.0.1", False), ("1.5.1", True), ("2.0.0", False), ("2.1.0", True)]
)
def test_a_package_of_another_release_is_told_of_at_the_start(
    version, is_fit, environment, tmp_path, monkeypatch
):
    """With 1.5.1 installed, where 2.x was expected, one SpawnEntity ended the world."""
    ros = a_ros(tmp_path, version, monkeypatch)
    if is_fit:
        assert interfaces_build.foreign_interfaces() == {"demo_msgs": ros}
        return
    with pytest.raises(interfaces_build.SwarmError, match=r"1\.5 and later 1\.x or 2\.1"):
        interfaces_build.ensure_interfaces(quiet=True)


def test_a_ros_that_is_sourced_after_our_setup_is_used_or_told_of(
    environment, builds, tmp_path, monkeypatch
):
    """What we had installed was taken for what is imported, and the world ended."""
    monkeypatch.syspath_prepend(str(environment.site_packages))
    monkeypatch.setattr(sys, "prefix", str(environment.prefix))
    (environment.prefix / interfaces_build.INDEX).mkdir(parents=True)
    (environment.prefix / interfaces_build.INDEX / "demo_msgs").touch()
    assert interfaces_build.ensure_interfaces(quiet=True) == ["demo_msgs"]
    assert interfaces_build.foreign_interfaces() == {}
    ros = a_ros(tmp_path, "1.5.1", monkeypatch)
    assert interfaces_build.foreign_interfaces() == {"demo_msgs": ros}
    assert interfaces_build.ensure_interfaces(quiet=True) == []
    a_ros(tmp_path, "1.0.1", monkeypatch)
    with pytest.raises(interfaces_build.SwarmError, match=r"1\.0 in .* does not have all"):
        interfaces_build.ensure_interfaces(quiet=True)


@pytest.mark.parametrize(("tool", "package"), [("gcc", "gcc"), ("g++", "g++")])
def test_missing_compiler_names_the_package(tool, package, tmp_path):
    for name in {"gcc", "g++"} - {tool}:
        (tmp_path / name).write_text("#!/bin/sh\n")
        (tmp_path / name).chmod(0o755)
    with pytest.raises(
        toolchain.MissingToolError, match=f"sudo apt install {package}".replace("+", r"\+")
    ):
        toolchain.find_toolchain({"PATH": str(tmp_path)})


def test_command_ends_with_2_without_a_compiler(environment, monkeypatch, capsys):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(sys, "argv", ["swarm-setup"])
    with pytest.raises(SystemExit) as end:
        setup()
    assert end.value.code == 2
    assert "sudo apt install gcc" in capsys.readouterr().err


def test_what_cannot_be_built_says_why(environment, builds, monkeypatch, tmp_path):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied", str(environment.prefix))

    monkeypatch.setattr(install.shutil, "copy2", refuse)
    with pytest.raises(interfaces_build.SwarmError, match="use a virtual environment"):
        interfaces_build.ensure_interfaces(quiet=True)
    source = tmp_path / "broken.c"
    source.write_text("int main( {")
    library = Library("demo_msgs", "lib/libx.so", "$ORIGIN", (source,), (), ())
    tools = Toolchain("gcc", "g++", (), ())
    with pytest.raises(BuildError, match="error: expected"):
        build_all([library], tmp_path, tools, jobs=1, done=lambda: None)


def test_prefixes_start_here_and_what_is_there_is_remembered(tmp_path):
    (tmp_path / "share").mkdir()
    path = os.pathsep.join([str(tmp_path), str(tmp_path / "missing")])
    prefixes = toolchain.ros_prefixes({"AMENT_PREFIX_PATH": path})
    assert prefixes[1:] == (tmp_path,)
    there = install.Environment(tmp_path, tmp_path / "site-packages")
    assert there.installed() == {}
    package = load_package(write_package(tmp_path / "src", "demo_msgs"))
    (there.site_packages / package.name).mkdir(parents=True)
    (there.site_packages / package.name / "__init__.py").touch()
    there.remember(package.name, "abc")
    assert there.installed() == {"demo_msgs": "abc"}


@pytest.mark.parametrize(
    ("interface", "type_name", "digest"),
    [
        # Hashes of the released Jazzy packages: other ROS 2 programs must understand ours.
        (
            "nav2_msgs/action/NavigateToPose",
            "nav2_msgs/action/NavigateToPose_FeedbackMessage",
            "9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478b6559feed9a50bdfd82b3",
        ),
        (
            "tf2_msgs/msg/TFMessage",
            "tf2_msgs/msg/TFMessage",
            "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
        ),
    ],
)
def test_types_are_those_of_jazzy(interface, type_name, digest):
    for prefix in toolchain.ros_prefixes(os.environ):
        file = prefix / "share" / f"{interface}.json"
        if file.exists():
            hashes = json.loads(file.read_text())["type_hashes"]
            found = {entry["type_name"]: entry["hash_string"] for entry in hashes}
            assert found[type_name] == f"RIHS01_{digest}"
            return
    pytest.fail(f"{interface} is not installed")
