"""The link to a host is lost, for some seconds or for good."""

import time

import pytest

START = 240.0  # [s] of wall time, on a busy machine that compiles the kernels, too
MISSION = ("--mission", "loading_route", "--goals-per-robot", "2", "--until-done")

pytestmark = [pytest.mark.long, pytest.mark.timeout(1200)]


def running(start_hosts, *flags):
    """Return a swarm that has come to t = 6 s: robots 1 to 3 on host 2, 4 to 6 on host 3."""
    swarm = start_hosts(3)
    swarm.start_world("--swarm-size", "6", *MISSION, *flags)
    swarm.start_robots(2, "1-3")
    swarm.start_robots(3, "4-6")
    swarm.wait_until(6.0, START)
    return swarm


def test_five_seconds_without_link_change_nothing(start_hosts):
    """The world waits: no simulated time passes, so the run is the one without the loss."""
    swarm = running(start_hosts, "--speed", "3")
    swarm.net.set_link(2, "down")
    swarm.wait_for(1, "nothing is heard of", 10.0)
    time.sleep(2.0)
    swarm.net.set_link(2, "up")
    assert [swarm.exit_code(host, 300.0) for host in (1, 2, 3)] == [0, 0, 0]
    report = swarm.report(1)
    assert report["goals"]["reached"] == 12
    assert report["late_ticks"] == 0
    assert report["hosts"][0]["silences"] or report["hosts"][1]["silences"]
    assert swarm.report(2)["silences"]
    swarm.start(1, "--swarm-size", "6", *MISSION, "--no-report", "--headless")
    assert swarm.exit_code(1, 300.0) == 0
    assert swarm.report(1)["trajectory_sha256"] == report["trajectory_sha256"]
    swarm.assert_nothing_is_left()


def test_after_the_wall_limit_the_others_go_on_and_the_lost_rejoin(start_hosts, tmp_path):
    params = tmp_path / "params.yaml"
    params.write_text("/world: {ros__parameters: {wall_limit: 11.0}}", encoding="utf-8")
    swarm = running(start_hosts, "--speed", "3", "--params", str(params))
    swarm.net.set_link(2, "down")
    time.sleep(22.0)  # half of which the world waits
    swarm.net.set_link(2, "up")
    assert [swarm.exit_code(host, 300.0) for host in (1, 2, 3)] == [0, 0, 0]
    report = swarm.report(1)
    assert report["goals"] == {"sent": 12, "reached": 12, "failed": 0, "pending": 0}
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["late_ticks"] > 3 * 16  # more than a robot takes for lost messages
    swarm.assert_nothing_is_left()


def test_lost_for_good(start_hosts):
    swarm = running(start_hosts)
    swarm.net.set_link(2, "down")
    assert [swarm.exit_code(host, 300.0) for host in (1, 2, 3)] == [3, 3, 0]
    report = swarm.report(1)
    assert "Srobot1 to Srobot3 are lost" in swarm.said(1)
    assert "nothing was heard of the world's host" in swarm.said(2)
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    standing = {host["robots"][0]: host["standing"] for host in report["hosts"]}
    assert standing == {"Srobot1": "lost", "Srobot4": "left"}
    for number in (4, 5, 6):
        robot = report["robots"][f"Srobot{number}"]
        assert robot["goals_reached"] + robot["goals_failed"] == 2
    swarm.assert_nothing_is_left()
