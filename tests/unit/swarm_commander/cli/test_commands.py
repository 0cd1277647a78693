"""What all commands have in common: --version, --help, signals, no silent wait."""

import importlib
import os
import signal
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import typer
from swarm_interfaces.msg import RobotStatus

from swarm_commander.cli import command_node, commander_command, doctor
from swarm_common.files.resources import run_folders
from swarm_common.middleware import ros_env
from swarm_common.model.errors import ConfigError, NoSwarmError
from swarm_common.model.records import Pose
from swarm_describe.robots.fleet import fleet_names
from swarm_describe.robots.source import robot_names
from swarm_mission.mission import mission_names
from swarm_run.command_line import run_app
from swarm_run.domain import DomainLock, check_swarm
from swarm_run.listing import listing, world_names
from swarm_run.robots.swarm_watch import SwarmPatience
from tests.fakes.foreign_robots import ACCELERATIONS, fast_wheels, two_wheels
from tests.fakes.run_folder import make_run

ROOT = Path(__file__).parents[4]
SCRIPTS = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["scripts"]
OURS = sorted(name for name in SCRIPTS if name != "ros2")
FREE_DOMAIN = 231


@pytest.fixture(autouse=True)
def handlers():
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def call(monkeypatch, name, *words):
    module, _, function = SCRIPTS[name].partition(":")
    monkeypatch.setattr(sys, "argv", [name, *words])
    with pytest.raises(SystemExit) as ending:
        getattr(importlib.import_module(module), function)()
    return ending.value.code


@pytest.mark.parametrize("name", OURS)
def test_every_command_says_its_version(monkeypatch, capsys, name):
    assert call(monkeypatch, name, "--version") == 0
    assert capsys.readouterr().out.startswith(f"{name} 0.")


def test_the_help_of_swarm_setup_sets_nothing_up(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "ensure_interfaces", pytest.fail)
    assert call(monkeypatch, "swarm-setup", "--help") == 0
    assert "Usage: swarm-setup" in capsys.readouterr().out


def test_the_list_has_a_line_with_words_for_each_name():
    lines = listing().splitlines()
    for name in (*world_names(), *mission_names(), *robot_names(), *fleet_names()):
        (line,) = [line for line in lines if line.split()[:1] == [name]]
        assert len(line.split()) > 2


def test_a_robot_is_described_with_where_each_value_is_from(monkeypatch, capsys, tmp_path):
    path = two_wheels(*fast_wheels(), settings=ACCELERATIONS).write(tmp_path)
    assert call(monkeypatch, "swarm-up", "--describe", str(path)) == 0
    lines = capsys.readouterr().out.splitlines()
    about = {line.split()[0]: " ".join(line.split()[1:]) for line in lines[1:]}
    assert about["drive"].startswith("differential guessed: two wheels on the ground")
    assert about["wheel_radius"] == "0.05 m collision shapes of the wheels"
    assert about["acc_lim_x"] == "1 m/s² own.robot.yaml"
    assert about["lidar.frame"] == "laser ray sensor on link laser"
    assert about["max_vel_x"].startswith("missing the velocity limit 100 rad/s of joint left_wheel")
    assert call(monkeypatch, "swarm-up", "--describe", "turtlebot3_wafle") == 2
    assert "did you mean 'turtlebot3_waffle'" in capsys.readouterr().err


def test_a_port_is_checked_without_a_viewer(monkeypatch, capsys):
    assert call(monkeypatch, "swarm-up", "--port", "99999") == 2
    assert "--port is 99999" in capsys.readouterr().err


def test_a_file_that_ends_too_early_is_no_silent_ctrl_c(monkeypatch, capsys):
    app = typer.Typer()

    @app.command()
    def command():
        raise EOFError("ran out of input")

    monkeypatch.setattr(sys, "argv", ["command"])
    assert run_app("command", lambda: app) == 3
    assert "EOFError: ran out of input" in capsys.readouterr().err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_command_without_a_traceback(monkeypatch, capsys, number):
    app = typer.Typer()

    @app.command()
    def command():
        try:
            os.kill(os.getpid(), number)
        finally:
            raise RuntimeError("what a library says when its context is gone")

    monkeypatch.setattr(sys, "argv", ["command"])
    assert run_app("command", lambda: app) == 128 + number
    assert capsys.readouterr().err == ""


def test_a_swarm_is_waited_for_while_it_starts_or_is_looked_for_and_named_once():
    said: list[str] = []
    patience = SwarmPatience(7, lambda: True, said.append)
    for waited in (0.0, 10.0, 100.0):
        patience.check(waited)
    assert said == ["the swarm in ROS domain 7 is starting; waiting for it"]
    with pytest.raises(ConfigError, match="has not come up within 300 s"):
        patience.check(301.0)
    states = iter([True, False])
    patience = SwarmPatience(7, lambda: next(states), print)
    patience.check(0.0)
    with pytest.raises(NoSwarmError, match="ROS domain 7"):
        patience.check(0.1)
    patience = SwarmPatience(7, lambda: None, print)
    patience.check(4.0)
    with pytest.raises(NoSwarmError):
        patience.check(6.0)


def test_without_a_swarm_nobody_waits(monkeypatch):
    monkeypatch.setattr(ros_env, "bound_address", lambda: ros_env.LOOPBACK)
    with pytest.raises(NoSwarmError, match="ROS domain 231"):
        check_swarm(FREE_DOMAIN)
    lock = DomainLock(FREE_DOMAIN)
    try:
        check_swarm(FREE_DOMAIN)
    finally:
        lock.release()
    monkeypatch.setattr(ros_env, "bound_address", lambda: "192.0.2.1")  # perhaps on another host
    check_swarm(FREE_DOMAIN)


def test_the_way_to_a_goal_that_somebody_else_gave_is_not_told():
    stop = SimpleNamespace(pose_map=Pose(1.0, 2.0, 0.0))
    driver: Any = SimpleNamespace(order=SimpleNamespace(stop=stop))
    status = RobotStatus()
    status.goal.x, status.goal.y = 1.0, 2.0
    assert commander_command._is_own(driver, status)
    status.goal.x = 4.0
    assert not commander_command._is_own(driver, status)


def test_tab_offers_robots_stations_and_subcommands_of_the_latest_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command_node.robots() == command_node.stations() == []
    make_run(tmp_path / "runs" / "latest", robots=2, seconds=0)
    assert command_node.robots() == ["Srobot1", "Srobot2"]
    assert command_node.stations() == ["dock", "shop"]
    assert {"Srobot1", "spawn", "restart"} <= set(command_node.first_words())
    assert run_folders() == ["runs/latest"]
