"""A centre in the bench: goals are reached, messages are counted, robots without orders stop."""

import dataclasses

import numpy as np
import pytest

from swarm_bench.runs.episode import RunOptions, build, nav_config
from swarm_bench.runs.harness import Harness, run
from swarm_bench.runs.scenario import load_scenario
from swarm_central.reservation import ReservationCentre
from swarm_common.model.errors import ConfigError
from swarm_run.loop import InjectedFaults

SCENARIO = """
world: doorway
mission: change_rooms
robots: 4
time_limit: {4: 200}
"""


def options(folder, method="central-mapf", **changes):
    path = folder / "short.yaml"
    path.write_text(SCENARIO, encoding="utf-8")
    scenario = dataclasses.replace(load_scenario(str(path)), **changes)
    return RunOptions(scenario=scenario, robots=4, seed=0, method=method)


@pytest.mark.parametrize("radio", [{}, {"loss": 0.3, "delay": 0.3}])
def test_all_goals_without_a_contact(tmp_path, radio):
    result = run(options(tmp_path, **radio))
    assert result.is_flawless
    assert result.centre["bytes_up_per_robot_second"] == pytest.approx(390.0)
    assert 0.0 < result.centre["bytes_down_per_robot_second"] < 1000.0
    assert result.centre["longest_decision_ms"] > 0.0
    assert result.as_json()["centre"]["plans"] > 10


def test_robots_stand_within_what_they_were_given_while_the_centre_is_dead(tmp_path):
    episode = build(options(tmp_path))
    episode.centre.outage = (50, 150)
    harness = Harness(options(tmp_path), episode=episode)
    places = []
    while harness.advance():
        if episode.world.tick in (56, 75, 150):
            places.append(np.array(episode.world.poses)[:, :2].copy())
    assert np.allclose(places[1], places[2], atol=1e-3)
    moved = np.hypot(*(places[0] - places[1]).T)
    assert moved.max() < 0.3  # no farther than a lookahead, with its pieces
    assert harness.is_over  # it goes on once the centre is back
    assert episode.world.verdict.robot_robot == 0
    episode.world.close()


def test_others_get_past_a_robot_that_died(tmp_path):
    faults = InjectedFaults(dead={3: 60})
    result = Harness(options(tmp_path), faults=faults).run()
    assert result.goals_reached == result.goals_sent == 3
    assert result.robot_robot == 0


def test_lacam_plans_as_well(tmp_path):
    chosen = dataclasses.replace(options(tmp_path), central={"planner": "lacam"})
    result = run(chosen)
    assert result.is_flawless
    assert result.centre["failed_plans"] < result.centre["plans"]
    assert result.conditions["central.planner"] == "lacam"


def test_a_robot_that_was_not_heard_at_first_joins_later(tmp_path):
    episode = build(options(tmp_path))
    hears = episode.centre.team.observe

    def deaf_to_the_first(tick, states):
        hears(tick, [report for report in states if report.robot_id != 1 or tick > 80])

    episode.centre.team.observe = deaf_to_the_first
    result = Harness(options(tmp_path), episode=episode).run()
    assert result.goals_reached == result.goals_sent


def under_reservation(folder, **parameters):
    return dataclasses.replace(options(folder, "central-reservation"), parameters=parameters)


@pytest.mark.parametrize("radio", [{}, {"loss": 0.3, "delay": 0.3}])
def test_our_navigators_reach_all_goals_under_a_centre(tmp_path, radio):
    result = run(options(tmp_path, "central-reservation", **radio))
    assert result.is_flawless
    assert result.centre["commands"] == 4
    assert result.centre["plans"] > 10


def test_led_robots_stand_within_what_they_hold_while_the_centre_is_dead(tmp_path):
    chosen = under_reservation(tmp_path)
    episode = build(chosen)
    episode.centre.outage = (60, 160)
    harness = Harness(chosen, episode=episode)
    places = []
    while harness.advance():
        if episode.world.tick == 161:  # another one is started in its place
            episode.centre.team = ReservationCentre(
                nav_config(chosen, episode.world.specs[0]), episode.world.specs, episode.setup.grid,
                episode.setup.scene.sites, first_command=70,
            )  # fmt: skip
        if episode.world.tick in (62, 110, 160):
            places.append(np.array(episode.world.poses)[:, :2].copy())
        if episode.world.tick == 160:
            told = [driver.status() for driver in episode.drivers]
    assert np.allclose(places[1], places[2], atol=1e-3)
    assert np.hypot(*(places[0] - places[1]).T).max() < 0.8  # a lookahead, with its pieces
    assert "for the centre" in {status.detail for status in told if status.state == "waiting"}
    assert harness.is_over
    assert episode.world.verdict.robot_robot == 0
    episode.world.close()


def test_with_fallback_robots_go_on_alone_and_come_back_under_the_centre(tmp_path):
    chosen = under_reservation(tmp_path, **{"traffic.coordination": "central-with-fallback"})
    episode = build(chosen)
    episode.centre.outage = (60, 160)
    harness = Harness(chosen, episode=episode)
    led = {}
    while harness.advance():
        heard = [driver.report().heard > 0 for driver in episode.drivers]
        led[episode.world.tick] = sum(heard)
    assert led[50] == 4
    assert led[100] == 0
    assert max(led[tick] for tick in led if tick > 170) == 4
    assert harness.is_over
    assert episode.world.verdict.robot_robot == 0
    episode.world.close()


def test_robots_go_alone_without_a_centre_or_are_refused(tmp_path):
    chosen = under_reservation(tmp_path, **{"traffic.coordination": "central-with-fallback"})
    episode = build(chosen)
    episode.centre = None
    result = Harness(chosen, episode=episode).run()
    assert result.is_flawless
    parameters = {"traffic.coordination": "central"}
    chosen = dataclasses.replace(options(tmp_path, "ours"), parameters=parameters)
    with pytest.raises(ConfigError, match="central-reservation"):
        build(chosen)


def test_a_crowd_comes_back_under_the_centre():
    """Robots barred each other on their ways to the roadmap, and stood for ever."""
    chosen = RunOptions(
        scenario=load_scenario("crossing"), robots=16, seed=0, method="central-with-fallback"
    )
    episode = build(chosen)
    episode.centre.outage = (200, 499)
    assert Harness(chosen, episode=episode).run().is_flawless


@pytest.mark.long
def test_no_robot_stands_short_of_its_station_or_beside_a_bend():
    """One did, and all others waited for it: it took 1,172 and then 1,302 s."""
    hall = dataclasses.replace(load_scenario("slim_blockage"), time_limit={20: 900.0})
    assert run(
        RunOptions(scenario=hall, robots=20, seed=3, method="central-reservation")
    ).is_flawless


def test_a_team_of_ones_own_decides(tmp_path):
    one = dataclasses.replace(load_scenario("circle"), time_limit={1: 60.0}, robots=(1,))
    settings = RunOptions(scenario=one, robots=1, seed=0, method="tests.fakes.teams:Straight")
    result = run(settings)
    assert result.is_flawless
    assert result.centre["own"] == 1.0
