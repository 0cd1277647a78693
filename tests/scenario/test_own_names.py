"""swarm-up with names of the user's own; what commands make of them is in test_comings.py."""

import pytest

TOUR = "retries: 3\nroute:\n  - {stations: [south_west, north_east], order: random, pause: 0.2}\n"


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_names_change_no_trajectory(start, tmp_path):
    mission = tmp_path / "tour.yaml"
    mission.write_text(TOUR, encoding="utf-8")
    flags = ("--world", "hall_12", "--swarm-size", "3", "--mission", str(mission))
    flags += ("--goals-per-robot", "1", "--until-done", "--headless", "--no-report")
    reports = []
    for own in ((), ("--names", "c,a,b")):
        reports.append(start(*flags, *own).good_report())
    usual, own_names = reports
    assert list(own_names["robots"]) == ["c", "a", "b"]
    assert own_names["trajectory_sha256"] == usual["trajectory_sha256"]
    assert list(own_names["robots"].values()) == list(usual["robots"].values())
