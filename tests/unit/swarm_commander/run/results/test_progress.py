"""What a terminal and a log file show of runs of any size."""

import io

import msgspec
import pytest
from rich.console import Console

from swarm_commander.run.results.progress import SHOWN_NOTES, Progress
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.results.status_table import LINES, status_table
from swarm_common.process.messages import RobotRemoved, RobotSpawned, StatusReported


def swarm(count):
    statistics = RunStatistics.of(
        [f"Srobot{number}" for number in range(1, count + 1)], has_mission=True
    )
    for number, robot in enumerate(statistics.robots.values()):
        robot.active = True
        robot.state = ("driving", "holding", "waiting", "idle")[number % 4]
        robot.detail, robot.goal, robot.reached = "for Srobot2", "loader_1", number % 3
    return statistics


def test_twenty_robots_have_a_line_each_where_the_screen_has_room():
    statistics = swarm(20)
    statistics.sim_time = 75.0
    statistics.robots["Srobot7"].since = 12.0
    statistics.robots["Srobot7"].detail = "before something with a long name, which is cut"
    statistics.waits.note("Srobot7", "Srobot12", 12.0)
    lines = [str(line) for line in status_table(statistics, 30)]
    assert len(lines) == 20
    assert lines[6].split()[:7] == ["Srobot7", "waiting", "63", "s", "loader_1", "0", "goals"]
    assert "for Srobot12" in lines[6]
    assert len(status_table(statistics, 15)) <= 15


def reported(robot, time, state):
    usual = dict.fromkeys(
        ("wait_time", "pushes", "retreats", "deadlocks_resolved", "replans", "goals_reached",
         "number_of_recoveries", "goals_failed", "hold_time"), 0
    )  # fmt: skip
    return StatusReported(
        robot=robot, sim_time=time, state=state, detail="", goal_map=(1.0, 2.0), **usual
    )


def test_a_line_shows_the_battery_of_a_robot_that_has_one():
    statistics = swarm(2)
    for name, battery in (("Srobot1", 0.634), ("Srobot2", None)):
        event = msgspec.structs.replace(reported(name, 1.0, "charging"), battery=battery)
        statistics.apply(event)
    with_battery, without = (line.plain for line in status_table(statistics, 15))
    assert " 63%" in with_battery
    assert "%" not in without


def test_a_removed_robot_is_gone_since_it_went_and_an_idle_one_idle_since_it_came():
    statistics = RunStatistics.of(["Srobot1"], has_mission=False)
    statistics.apply(RobotSpawned("Srobot2", 2, "waffle", (0.0, 0.0, 0.0), 30.0))
    for robot in statistics.robots:
        statistics.apply(reported(robot, 47.0, "idle"))
    statistics.sim_time = 91.0
    lines = [" ".join(str(line).split()[:4]) for line in status_table(statistics)]
    assert lines == ["Srobot1 idle 91 s", "Srobot2 idle 61 s"]
    statistics.apply(RobotRemoved("Srobot2", 80.0))
    assert " ".join(str(status_table(statistics)[1]).split()[:4]) == "Srobot2 gone 11 s"


@pytest.mark.parametrize(("count", "first"), [(13, "Srobot1-2 "), (100, "Srobot1-10 ")])
def test_a_large_swarm_has_a_line_per_group(count, first):
    statistics = swarm(count)
    statistics.robots["Srobot3"].died = True
    lines = [str(line) for line in status_table(statistics)]
    assert len(lines) <= LINES + 2
    assert lines[0].startswith(first)
    assert sum(line.count("X") for line in lines[:LINES]) == 1
    assert max(map(len, lines)) < 100


def progress(*, is_terminal):
    output, now = io.StringIO(), [0.0]
    console = Console(file=output, force_terminal=is_terminal, width=120, height=40)
    return Progress(console, swarm(100), lambda: now[0]), output, now


def test_a_log_file_gets_a_plain_line_now_and_then():
    shown, output, now = progress(is_terminal=False)
    shown.start()
    for second in range(11):
        now[0] = float(second)
        shown._statistics.sim_time = 3.0 * second
        shown.update()
    shown.stop()
    lines = output.getvalue().splitlines()
    assert len(lines) == 3
    assert "\x1b" not in output.getvalue()


@pytest.mark.parametrize("is_terminal", [True, False])
def test_many_breaches_are_counted_not_printed(is_terminal):
    shown, output, _ = progress(is_terminal=is_terminal)
    shown.start()
    for number in range(300):
        shown.breach("missed goals", f"missed {number}")
    shown.update()
    shown.stop()
    text = output.getvalue()
    assert f"missed {SHOWN_NOTES - 1}" in text
    assert f"missed {SHOWN_NOTES}" not in text
    assert ("and 292 more missed goals" if is_terminal else "more missed goals follow") in text


def test_a_first_start_says_that_it_compiles_and_how_far_it_is():
    stream = io.StringIO()
    now = iter(range(0, 100, 10))
    progress = Progress(Console(file=stream, width=200), swarm(2), lambda: float(next(now)))
    progress.phase("starting navigators")
    progress.compiling(37, 112)
    progress.update()
    progress.phase("running")
    progress.update()
    first, second = stream.getvalue().splitlines()
    assert first.startswith(
        "starting navigators (first start: compiling, 37 of 112 kernels are ready) | active"
    )
    assert second.startswith("running | active")
