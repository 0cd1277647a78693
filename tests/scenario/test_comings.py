"""Robots with names of the user's own come and go, driven by swarm-commander as a user would."""

import pytest

FLEET = """names: [amr_beta, amr_alpha, 'agv{:02}']
groups:
  - {model: turtlebot3_waffle, count: 2}
"""


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_robots_come_and_go_by_the_names_of_the_run(start, tmp_path):
    fleet = tmp_path / "fleet.yaml"
    fleet.write_text(FLEET, encoding="utf-8")
    swarm = start("--fleet", str(fleet), "--speed", "4", "--headless", "--no-report")
    swarm.wait_until_active()
    unknown = swarm.run("commander", "amr_gamma")
    assert unknown.returncode == 2
    assert "there are amr_alpha, amr_beta" in unknown.stderr
    refused = swarm.run("commander", "spawn", "--robot", "turtlebot9")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "did you mean" in refused.stderr
    refused = swarm.run("commander", "spawn", "crate")
    assert refused.returncode == 2
    assert "expected amr_beta and amr_alpha, or agv03 to agv65535" in refused.stderr
    assert "for an object 'crate' give --box" in refused.stderr
    burger = ("--robot", "turtlebot3_burger", "--pose", "3", "3", "0")
    spawned = swarm.run("commander", "spawn", *burger)
    assert spawned.stdout.startswith("agv03 is there"), spawned.stderr
    restarted = swarm.run("commander", "restart", "amr_alpha")
    assert restarted.returncode == 0, restarted.stderr
    assert "amr_alpha is active again" in restarted.stdout
    driven = swarm.run("commander", "agv03", "--goal", "4", "3", "0")
    assert driven.returncode == 0, driven.stdout + driven.stderr
    removed = swarm.run("commander", "remove", "agv03", "amr_beta")
    assert removed.returncode == 0, removed.stderr
    left = swarm.run("commander", "list").stdout
    assert [line.split()[0] for line in left.splitlines()] == ["amr_alpha"]
    swarm.popen.terminate()
    report = swarm.good_report()
    assert list(report["robots"]) == ["amr_beta", "amr_alpha", "agv03"]
    assert report["robots"]["agv03"]["goals_reached"] == 1
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["failures"] == []
    values = (swarm.run_dir / "params" / "agv03.yaml").read_text(encoding="utf-8")
    assert "turtlebot3_burger" in values
    files = {path.name for path in swarm.run_dir.rglob("*")}
    assert {"agv03.yaml", "amr_beta.rviz", "amr_alpha.json"} <= files
    assert not any("Srobot" in name for name in files)
