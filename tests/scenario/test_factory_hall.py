"""`swarm-up` for real: world, navigators and missions in the factory hall."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest

from swarm_common.files.resources import share_directory

pytestmark = pytest.mark.timeout(420)  # a busy machine takes its time
QUICKLY = ("--mission", "loading_route", "--headless", "--speed", "max")


def run(start, *flags, limit=250.0):
    """Return the report of a run that ends with exit code 0 and without a contact."""
    report = start(*flags, *QUICKLY).good_report(limit)
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["late_ticks"] == 0
    assert report["min_clearance"] is None or report["min_clearance"] > 0.0
    return report


def run_to_the_end(start, goals, *flags, limit=250.0):
    report = run(start, "--until-done", *flags, limit=limit)
    assert report["goals"] == {"sent": goals, "reached": goals, "failed": 0, "pending": 0}
    return report


@pytest.mark.long  # that the bench moves robots as the graph does is a test that always runs
@pytest.mark.timeout(3200)
@pytest.mark.parametrize(
    "flags",
    [
        ("--swarm-size", "3", "--goals-per-robot", "2", "--until-done", "--seed", "3"),
        ("--swarm-size", "50", "--duration", "40", "--seed", "5"),
    ],
)
def test_robots_move_alike_on_an_idle_and_on_a_busy_machine(start, flags):
    calm = run(start, *flags, limit=1500.0)
    hogs = [subprocess.Popen((sys.executable, "-c", "while 1: 1")) for _ in range(os.cpu_count())]
    try:
        busy = run(start, *flags, limit=1500.0)
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()
    assert len(calm["trajectory_sha256"]) == 64
    assert calm["trajectory_sha256"] == busy["trajectory_sha256"]
    assert calm["makespan"] == busy["makespan"]


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_without_a_mission_the_swarm_waits_for_its_operator(start, number):
    swarm = start("--swarm-size", "2", "--speed", "4")
    swarm.wait_until_active()
    sockets = [c for process in swarm.processes() for c in process.net_connections("udp")]
    assert {socket.laddr.ip for socket in sockets} == {"127.0.0.1"}
    result = swarm.run("commander", "Srobot2", "--goal", "3.0", "3.0", "0.0")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "reached" in result.stdout
    time.sleep(2.0)  # for the robot's last status to arrive
    swarm.popen.send_signal(number)
    assert swarm.good_report(60.0)["goals"] == {"sent": 1, "reached": 1, "failed": 0, "pending": 0}


def test_nothing_is_left_of_a_killed_swarm(start):
    swarm = start("--swarm-size", "2")
    swarm.wait_until(lambda: len(swarm.navigators()) == 2)
    time.sleep(2.0)
    swarm.popen.kill()
    swarm.popen.wait()


def test_a_station_inside_a_wall_is_bad_input(start, tmp_path):
    world = tmp_path / "hall"
    shutil.copytree(share_directory() / "worlds" / "slim_blockage", world)
    sites = world / "sites.yaml"
    text, count = re.subn(r"loader_3: .*", "loader_3: [-8.4, 0.0, 0.0]", sites.read_text("utf-8"))
    assert count == 1
    sites.write_text(text, encoding="utf-8")
    swarm = start("--world", str(world / "world.sdf"), "--swarm-size", "1")
    assert swarm.wait_for_end() == 2
    assert "loader_3" in swarm.output.splitlines()[-1]


@pytest.mark.long  # fewer drive on the graph in tests that always run, twenty in the bench
def test_twenty_robots_drive(start):
    report = run(start, "--swarm-size", "20", "--duration", "15", limit=360.0)
    assert min(robot["distance"] for robot in report["robots"].values()) > 0.5


@pytest.mark.long
def test_twenty_robots_reach_their_first_station(start):
    run_to_the_end(start, 20, "--swarm-size", "20", "--goals-per-robot", "1", limit=360.0)


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("seed", range(5))
def test_five_robots_work_through_the_hall(start, seed):
    run_to_the_end(start, 40, "--swarm-size", "5", "--seed", str(seed), limit=800.0)


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("seed", range(3))
def test_twenty_robots_work_through_the_hall(start, seed):
    run_to_the_end(start, 160, "--swarm-size", "20", "--seed", str(seed), limit=1700.0)
