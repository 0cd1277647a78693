"""swarm-up with robots that come and go, driven by swarm-commander as a user would."""

import pytest


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_robots_come_and_go_while_a_swarm_runs(start):
    swarm = start("--swarm-size", "2", "--speed", "4", "--headless", "--no-report")
    swarm.wait_until_active()
    refused = swarm.run("commander", "spawn", "--robot", "turtlebot9")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "did you mean" in refused.stderr
    burger = ("--robot", "turtlebot3_burger", "--pose", "3", "3", "0")
    spawned = swarm.run("commander", "spawn", *burger)
    assert spawned.stdout.startswith("Srobot3 is there"), spawned.stderr
    driven = swarm.run("commander", "Srobot3", "--goal", "4", "3", "0")
    assert driven.returncode == 0, driven.stdout + driven.stderr
    removed = swarm.run("commander", "remove", "Srobot3", "Srobot1")
    assert removed.returncode == 0, removed.stderr
    left = swarm.run("commander", "list").stdout
    assert [line.split()[0] for line in left.splitlines()] == ["Srobot2"]
    swarm.popen.terminate()
    report = swarm.good_report()
    assert list(report["robots"]) == ["Srobot1", "Srobot2", "Srobot3"]
    assert report["robots"]["Srobot3"]["goals_reached"] == 1
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["failures"] == []
    values = (swarm.run_dir / "params" / "Srobot3.yaml").read_text(encoding="utf-8")
    assert "turtlebot3_burger" in values
