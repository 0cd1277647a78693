"""More robots than every DDS participant may know of: hubs, with the robots on other hosts."""

from collections.abc import Callable

import pytest

from tests.fakes.hosts.host_swarm import HostSwarm

START = 480.0  # [s] of wall time, on a busy machine

StartHosts = Callable[[int], HostSwarm]


@pytest.mark.long
@pytest.mark.timeout(1500)
def test_forty_robots_on_two_hosts(start_hosts):
    swarm = start_hosts(3)
    flags = ("--mission", "loading_route", "--speed", "max", "--duration", "12")
    swarm.start_world("--swarm-size", "40", *flags)
    swarm.start_robots(2, "1-20")
    swarm.start_robots(3, "21-40")
    assert [swarm.exit_code(host, START) for host in (1, 2, 3)] == [0, 0, 0], swarm.said(1)
    swarm.assert_nothing_is_left()
    report = swarm.report(1)
    assert report["late_ticks"] == 0
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["goals"]["sent"] == 40
    assert sum(robot["distance"] > 0.5 for robot in report["robots"].values()) > 20
    assert [swarm.report(host)["active"] for host in (2, 3)] == [20, 20]
