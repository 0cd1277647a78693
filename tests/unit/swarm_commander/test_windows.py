"""`swarm-up --rviz` over fakes: opens the windows, or says how to get them."""

import json
import os
import sys
import time

import pytest

from tests.fakes.programs import run_program

RVIZ = '#!/bin/sh\necho "$@" >> "$RVIZ_LOG"\nexit ${RVIZ_CODE:-0}\n'


def up(folder, *flags, **variables):
    command = (sys.executable, "-m", "tests.fakes.plain.up", "--swarm-size", "3")
    mission = ("--mission", "loading_route", "--until-done", "--run-dir", str(folder / "run"))
    return run_program(
        (*command, *mission, *flags, "--no-report"), {"ROS_DOMAIN_ID": "87"} | variables, cwd=folder
    )


@pytest.fixture
def rviz(tmp_path):
    """A program named rviz2 that notes how it was called."""
    program = tmp_path / "bin" / "rviz2"
    program.parent.mkdir()
    program.write_text(RVIZ)
    program.chmod(0o755)
    return {
        "PATH": f"{program.parent}:{os.environ['PATH']}",
        "RVIZ_LOG": str(tmp_path / "rviz.log"),
    }


def calls(tmp_path, count):
    deadline = time.monotonic() + 5.0
    log = tmp_path / "rviz.log"
    while not log.is_file() or len(log.read_text().splitlines()) < count:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return sorted(log.read_text().splitlines())


def test_a_window_for_each_robot_that_was_named(tmp_path, rviz):
    result = up(tmp_path, "--rviz", "Srobot1,Srobot3", **rviz)
    assert result.returncode == 0, result.stdout
    folder = tmp_path / "run" / "rviz"
    for call, name in zip(calls(tmp_path, 2), ("Srobot1", "Srobot3"), strict=True):
        assert call.startswith(f"-d {folder / name}.rviz --ros-args -r /tf:=/{name}/tf")
        assert "event-fd" not in call


def test_without_names_the_window_is_that_of_the_swarm(tmp_path, rviz):
    up(tmp_path, "--rviz", **rviz)
    assert "swarm.rviz" in calls(tmp_path, 1)[0]


def test_the_merged_window_comes_with_the_relay_of_frames(tmp_path, rviz):
    result = up(tmp_path, "--rviz", "merged", **rviz)
    assert result.returncode == 0, result.stdout
    call = calls(tmp_path, 1)[0]
    assert "merged.rviz --ros-args -r __node:=rviz_merged" in call
    config = json.loads((tmp_path / "run" / "config" / "rviz_frames.json").read_text())
    assert config["command"][-1] == "swarm_commander.viewers.frame_relay"


def test_a_window_that_fails_is_reported_and_the_run_goes_on(tmp_path, rviz):
    result = up(tmp_path, "--rviz", RVIZ_CODE="7", **rviz)
    assert result.returncode == 3
    assert "the rviz_swarm process ended: exit code 7" in result.stdout
    assert "3 of 3" in result.stdout


def test_without_rviz_the_run_goes_on_and_says_how_to_get_it(tmp_path):
    result = up(tmp_path, "--rviz")
    assert result.returncode == 0, result.stdout
    assert "apt install ros-jazzy-rviz2" in result.stdout
    assert "--viewer" in result.stdout
