"""World and robots on two hosts: the same run as on one, and one clear error if they disagree."""

from collections.abc import Callable

import pytest

from tests.fakes.hanging import hang_one
from tests.fakes.hosts.host_swarm import HostSwarm

START = 240.0  # [s] of wall time, on a busy machine that compiles the kernels, too

StartHosts = Callable[[int], HostSwarm]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_run_on_two_hosts_and_a_host_that_asks_for_other_robots(start_hosts):
    """One start for several questions: each takes seconds of imports."""
    swarm = start_hosts(2)
    flags = ("--swarm-size", "2", "--seed", "3", "--duration", "6", "--speed", "max")
    swarm.start_world(*flags, "--names", "ann,agv{}")
    swarm.wait_for(1, "the world is up", START)
    swarm.start_robots(2, "1-3")
    assert swarm.exit_code(2, START) == 2
    assert "--robots asks for agv3, but the world has 2 robots" in swarm.said(2)
    swarm.start_robots(2, "1-2", "--seed", "3", "--swarm-size", "2")
    swarm.wait_for(1, "has ann and agv2", START)
    for host in (1, 2):
        assert swarm.net.bound_addresses(host) == {swarm.net.address(host)}
    assert swarm.exit_code(1, START) == 0
    assert swarm.exit_code(2, START) == 0
    swarm.assert_nothing_is_left()
    report = swarm.report(1)
    assert report["sim_time"] == pytest.approx(6.0)
    assert report["late_ticks"] == 0
    (host,) = report["hosts"]
    assert host["robots"] == ["ann", "agv2"]
    assert host["standing"] == "left"
    ours = swarm.report(2)
    assert ours["active"] == 2
    assert "time is up" in ours["ending"]


@pytest.mark.long
@pytest.mark.timeout(1200)
@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (("--seed", "4"), "--seed is 4 here, but 0 on the world's host"),
        (("--world", "playground"), "--world is playground here, but slim_blockage on the"),
        (("--swarm-size", "5"), "--swarm-size is 5 here, but 1 on the world's host"),
    ],
)
def test_hosts_that_disagree(start_hosts, flags, words):
    swarm = start_hosts(2)
    swarm.start_world("--swarm-size", "1")
    swarm.wait_for(1, "the world is up", START)
    swarm.start_robots(2, "1", *flags)
    assert swarm.exit_code(2, START) == 2
    assert words in swarm.said(2)
    swarm.interrupt(1)
    assert swarm.exit_code(1, 30.0) == 0
    swarm.assert_nothing_is_left()


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_refused_parameter_is_named_in_the_file_of_the_worlds_host(start_hosts, tmp_path):
    params = tmp_path / "mine.yaml"
    params.write_text("/**:\n  ros__parameters: {vx_samples: 1}\n", encoding="utf-8")
    swarm = start_hosts(2)
    swarm.start_world("--swarm-size", "1", "--params", str(params))
    swarm.wait_for(1, "the world is up", START)
    swarm.start_robots(2, "1")
    assert swarm.exit_code(2, START) == 2
    said = " ".join(swarm.said(2).split())
    assert f"{params} on the world's host: /**: vx_samples is 1" in said
    swarm.interrupt(1)
    swarm.exit_code(1, 30.0)
    swarm.assert_nothing_is_left()


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_robot_has_one_host(start_hosts):
    swarm = start_hosts(3)
    swarm.start_world("--swarm-size", "3")
    swarm.start_robots(2, "1-2")
    swarm.wait_for(1, "has Srobot1 and Srobot2", START)
    swarm.start_robots(3, "2-3")
    assert swarm.exit_code(3, START) == 2
    assert "Srobot2 is on" in swarm.said(3)
    swarm.interrupt(2)
    assert swarm.exit_code(2, 30.0) == 0
    swarm.interrupt(1)
    swarm.exit_code(1, 30.0)
    swarm.assert_nothing_is_left()


@pytest.mark.long
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("side", [1, 2])
def test_ctrl_c_on_one_side_ends_both(start_hosts, side):
    swarm = start_hosts(2)
    swarm.start_world("--swarm-size", "2", "--mission", "loading_route", "--speed", "2")
    swarm.start_robots(2, "1-2")
    swarm.wait_until(2.0, START)
    swarm.interrupt(side)
    codes = [swarm.exit_code(1, 30.0), swarm.exit_code(2, 30.0)]
    assert codes == ([0, 0] if side == 1 else [1, 0])  # the goals of robots that left are missed
    swarm.assert_nothing_is_left()
    assert swarm.report(1)["collisions"] == {"robot_robot": 0, "robot_world": 0}


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_mission_on_two_hosts_goes_as_on_one(start_hosts):
    mission = ("--swarm-size", "4", "--mission", "loading_route", "--goals-per-robot", "2")
    swarm = start_hosts(3)
    swarm.start_world(*mission, "--until-done")
    swarm.start_robots(2, "1,3")
    swarm.start_robots(3, "2,4", "--pack", "2")
    assert [swarm.exit_code(host, 300.0) for host in (1, 2, 3)] == [0, 0, 0]
    spread = swarm.report(1)
    swarm.start(1, *mission, "--until-done", "--no-report", "--headless")
    assert swarm.exit_code(1, 300.0) == 0
    alone = swarm.report(1)
    assert spread["goals"]["reached"] == alone["goals"]["reached"] == 8
    assert spread["trajectory_sha256"] == alone["trajectory_sha256"]
    swarm.assert_nothing_is_left()


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_navigator_that_hangs_at_the_start_is_started_anew(start_hosts):
    swarm = start_hosts(2)
    swarm.start_world("--swarm-size", "3", "--duration", "6", "--speed", "max")
    swarm.wait_for(1, "the world is up", START)
    swarm.start_robots(2, "1-3")
    hang_one(swarm.net.pids, START)
    swarm.wait_for(2, "did not become active: its navigator is restarted", START)
    assert [swarm.exit_code(host, START) for host in (1, 2)] == [0, 0]
    assert swarm.report(1)["sim_time"] == pytest.approx(6.0)
    assert swarm.report(2)["active"] == 3
    swarm.assert_nothing_is_left()
