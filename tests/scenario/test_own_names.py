"""swarm-up with names of the user's own, and what commands make of them."""

import pytest

FLEET = """names: [amr_beta, amr_alpha, 'agv{:02}']
groups:
  - {model: turtlebot3_burger, count: 2}
"""
TOUR = "retries: 3\nroute:\n  - {stations: [south_west, north_east], order: random, pause: 0.2}\n"


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_names_change_no_trajectory(start, tmp_path):
    mission = tmp_path / "tour.yaml"
    mission.write_text(TOUR, encoding="utf-8")
    flags = ("--world", "hall_12", "--swarm-size", "4", "--mission", str(mission))
    flags += ("--until-done", "--headless", "--no-report")
    reports = []
    for own in ((), ("--names", "d,c,b,a")):
        reports.append(start(*flags, *own).good_report())
    usual, own_names = reports
    assert list(own_names["robots"]) == ["d", "c", "b", "a"]
    assert own_names["trajectory_sha256"] == usual["trajectory_sha256"]
    assert list(own_names["robots"].values()) == list(usual["robots"].values())


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_commands_take_the_names_of_the_run(start, tmp_path):
    fleet = tmp_path / "fleet.yaml"
    fleet.write_text(FLEET, encoding="utf-8")
    swarm = start("--fleet", str(fleet), "--speed", "4", "--headless", "--no-report")
    swarm.wait_until_active()
    unknown = swarm.run("commander", "amr_gamma")
    assert unknown.returncode == 2
    assert "there are amr_alpha, amr_beta" in unknown.stderr
    refused = swarm.run("commander", "spawn", "crate")
    assert refused.returncode == 2
    assert "expected amr_beta and amr_alpha, or agv03 to agv65535" in refused.stderr
    assert "for an object 'crate' give --box" in refused.stderr
    spawned = swarm.run("commander", "spawn", "--pose", "3", "3", "0")
    assert spawned.stdout.startswith("agv03 is there"), spawned.stderr
    restarted = swarm.run("commander", "restart", "amr_alpha")
    assert restarted.returncode == 0, restarted.stderr
    assert "amr_alpha is active again" in restarted.stdout
    driven = swarm.run("commander", "agv03", "--goal", "4", "3", "0")
    assert driven.returncode == 0, driven.stdout + driven.stderr
    swarm.popen.terminate()
    swarm.wait_for_end()
    report = swarm.report()
    assert list(report["robots"]) == ["amr_beta", "amr_alpha", "agv03"]
    assert report["robots"]["agv03"]["goals_reached"] == 1
    files = {path.name for path in swarm.run_dir.rglob("*")}
    assert {"agv03.yaml", "amr_beta.rviz", "amr_alpha.json"} <= files
    assert not any("Srobot" in name for name in files)
