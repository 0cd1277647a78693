"""The short version of the storms: one navigator killed or restarted, the world ended or stopped.

What takes longest runs with `-m long`.
"""

import signal
import time

import pytest

from tests.fakes.real_swarm import check_is_true

pytestmark = pytest.mark.timeout(600)

TO_THE_END = ("--mission", "loading_route", "--until-done", "--speed", "8", "--drive", "planar")
TO_THE_END += ("--headless", "--no-report", "--duration", "900")
FEW = ("--swarm-size", "3", "--goals-per-robot", "2")
STOPPED = 20.0  # [s] of wall time


def test_a_killed_navigator_is_started_anew_and_all_goals_are_reached(start):
    swarm = start(*FEW, *TO_THE_END)
    swarm.wait_until(lambda: swarm.sim_time() > 5.0)
    assert swarm.send("Srobot2", signal.SIGKILL)
    report = swarm.good_report(300.0)
    check_is_true(0, report)
    assert report["goals"] == {"sent": 6, "reached": 6, "failed": 0, "pending": 0}
    assert report["restarts"] == report["robots"]["Srobot2"]["restarts"] == 1
    assert "Srobot2 died: killed by SIGKILL" in report["incidents"][0]


@pytest.mark.long
def test_a_navigator_that_hangs_is_replaced_and_all_goals_are_reached(start):
    swarm = start(*FEW, *TO_THE_END)
    swarm.wait_until(lambda: swarm.sim_time() > 5.0)
    assert swarm.send("Srobot1", signal.SIGSTOP)
    report = swarm.good_report(300.0)
    check_is_true(0, report)
    assert report["goals"]["reached"] == 6
    assert report["robots"]["Srobot1"]["restarts"] == 1


@pytest.mark.long
def test_a_robot_that_comes_back_from_silence_gets_its_goals_again(start):
    """Also if only the others have forgotten it: then DDS does not bring them together again."""
    swarm = start(*FEW, *TO_THE_END, "--no-restart")
    swarm.wait_until(lambda: swarm.sim_time() > 5.0)
    assert swarm.send("Srobot1", signal.SIGSTOP)
    time.sleep(STOPPED)
    assert swarm.send("Srobot1", signal.SIGCONT)
    report = swarm.good_report(300.0)
    check_is_true(0, report)
    assert report["goals"] == {"sent": 6, "reached": 6, "failed": 0, "pending": 0}


@pytest.mark.long
def test_a_run_that_was_stopped_as_a_whole_goes_on(start):
    """As by `docker pause`: mission and robots had forgotten each other, robots were "lost"."""
    swarm = start(*FEW, *TO_THE_END)
    swarm.wait_until(lambda: swarm.sim_time() > 5.0)
    processes = swarm.processes()
    for number in (signal.SIGSTOP, signal.SIGCONT):
        for process in processes:
            process.send_signal(number)
        time.sleep(STOPPED if number == signal.SIGSTOP else 0.0)
    report = swarm.good_report(300.0)
    check_is_true(0, report)
    assert report["goals"] == {"sent": 6, "reached": 6, "failed": 0, "pending": 0}
    assert any("the mission process ended" in incident for incident in report["incidents"])


@pytest.mark.long
@pytest.mark.parametrize("component", ["mission", "fork_server"])
def test_the_mission_goes_on_with_a_new_process(start, component):
    swarm = start(*FEW, *TO_THE_END)
    swarm.wait_until(lambda: swarm.sim_time() > 5.0)
    assert swarm.send(component, signal.SIGKILL)
    report = swarm.good_report(300.0)
    check_is_true(0, report)
    assert report["goals"] == {"sent": 6, "reached": 6, "failed": 0, "pending": 0}
    assert report["restarts"] >= 1


@pytest.mark.parametrize(
    "number",
    [
        signal.SIGTERM,
        *(pytest.param(n, marks=pytest.mark.long) for n in (signal.SIGSTOP, signal.SIGKILL)),
    ],
)
def test_without_a_world_to_the_end_the_exit_code_is_three(start, number):
    swarm = start("--swarm-size", "2", "--mission", "loading_route", "--headless", "--no-report")
    swarm.wait_until(lambda: swarm.sim_time() > 1.0)
    begin = time.monotonic()
    assert swarm.send("world", number)
    code = swarm.wait_for_end(60.0)
    assert time.monotonic() - begin < 50.0, "30 s to find it out, 20 s to end it all"
    report = swarm.report()
    check_is_true(code, report)
    assert code == 3
    assert report["has_verdict"] == (number == signal.SIGTERM)
    assert "the world process" in report["failures"][0]
