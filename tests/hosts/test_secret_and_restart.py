"""Who is given robots: only who knows the secret, and only in the run that goes on."""

import psutil
import pytest

from tests.fakes.hosts.host_swarm import SECRET

START = 240.0  # [s] of wall time, on a busy machine that compiles the kernels, too


@pytest.mark.long  # what is sealed with another secret is tested without processes, too
@pytest.mark.timeout(600)
def test_without_the_secret_nobody_is_given_robots(start_hosts):
    swarm = start_hosts(2)
    swarm.start_world("--swarm-size", "1", "--duration", "3", "--speed", "max")
    swarm.wait_for(1, f"SWARM_SECRET={SECRET} swarm-up --role robots --robots 1-1", START)
    robots = ("--role", "robots", "--robots", "1", "--connect", swarm.net.address(1))
    swarm.start(2, *robots, secret="")
    assert swarm.exit_code(2, START) == 2
    assert "needs the secret of the world's host" in swarm.said(2)
    swarm.start(2, *robots, secret="one that somebody made up")
    assert swarm.exit_code(2, START) == 2
    assert "has another secret" in swarm.said(2)
    assert "has Srobot1" not in swarm.said(1)
    swarm.start(2, *robots)
    swarm.wait_for(1, "has Srobot1", START)
    lines = [" ".join(psutil.Process(pid).cmdline()) for pid in swarm.net.pids()]
    assert lines
    assert not [line for line in lines if SECRET in line]
    assert [swarm.exit_code(host, START) for host in (1, 2)] == [0, 0]
    files = [path for host in (1, 2) for path in swarm.run(host).rglob("*") if path.is_file()]
    assert not [path for path in files if SECRET.encode() in path.read_bytes()]
    swarm.assert_nothing_is_left()


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_world_that_crashed_is_started_again_at_once(start_hosts, tmp_path):
    """Its old robots' host is still there when the new run begins, and a new one comes."""
    swarm = start_hosts(3)
    flags = ("--swarm-size", "2", "--mission", "loading_route", "--goals-per-robot", "1")
    swarm.start_world(*flags, "--until-done")
    swarm.start_robots(2, "1-2")
    swarm.wait_until(2.0, START)
    swarm.kill(1)
    swarm.start_world(*flags, "--until-done")
    swarm.wait_for(1, "the world is up", START)
    assert swarm.exit_code(2, START) == 3
    assert "another run has begun on the world's host" in swarm.said(2)
    swarm.start_robots(3, "1-2")
    assert [swarm.exit_code(host, START) for host in (1, 3)] == [0, 0]
    report = swarm.report(1)
    assert report["goals"]["reached"] == 2
    assert len(report["hosts"]) == 1
    swarm.assert_nothing_is_left()
