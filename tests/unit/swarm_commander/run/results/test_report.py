import io
import json
import math
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from swarm_commander.run.processes.usage import UsageMeter
from swarm_commander.run.results.progress import goals_text, summary_line, summary_table
from swarm_commander.run.results.report import RunTimes, compose_report, exit_code, write_report
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.results.status_table import status_table
from swarm_common.model.breaches import Collision, MissedGoal, breach_lines
from swarm_common.process import messages as say
from swarm_report.document import merits
from swarm_run.spec import RunSpec

ROBOTS = ("Srobot1", "Srobot2")
VERDICT: dict[str, Any] = {
    "sim_time": 100.0,
    "robot_robot": 0,
    "robot_world": 0,
    "min_clearance": 0.12345,
    "late_ticks": 0,
    "real_time_factor": 8.0,
    "trajectory_sha256": "00",
    "robots": {name: {"distance": 20.0, "collisions": 0, "min_clearance": 0.2} for name in ROBOTS},
}
KEYS = {
    "schema", "swarm_size", "world", "robot", "seed", "sim_time", "wall_time",
    "real_time_factor", "active_after_wall", "goals", "collisions", "min_clearance", "makespan",
    "throughput_per_minute", "hold_time", "late_ticks", "restarts", "cpu_ms_per_robot_second",
    "rss_mb", "private_mb", "memory_mb", "trajectory_sha256", "robots", "near_misses",
    "wait_time", "worst_wait",
    "goal_duration", "fairness", "pushes", "retreats", "deadlocks_resolved", "replans",
    "recoveries", "breaches",
}  # fmt: skip


def statistics_of(*events, has_mission=True):
    statistics = RunStatistics.of(ROBOTS, has_mission)
    for event in events:
        statistics.apply(event)
    return statistics


def goal(robot, outcome, sim_time):
    if outcome == "reached":
        return say.GoalReached(robot, "a", sim_time, sim_time - 10.0)
    return say.GoalMissed(MissedGoal(robot, "a", sim_time, "error 208: closed"))


def status(robot, **values):
    usual = {
        "state": "driving", "detail": "", "hold_time": 0.0, "wait_time": 0.0,
        "goals_reached": 0, "goals_failed": 0, "goal_map": None, "sim_time": 1.0, "pushes": 0,
        "retreats": 0, "deadlocks_resolved": 0, "replans": 0, "number_of_recoveries": 0,
    }  # fmt: skip
    return say.StatusReported(robot, **usual | values)


def report_of(statistics, verdict=None):
    return compose_report(
        RunSpec(swarm_size=2, seed=4),
        statistics,
        VERDICT if verdict is None else verdict,
        UsageMeter(),
        RunTimes(wall_time=15.0, active_after_wall=2.0, restarts=1),
    )


def test_the_report_has_what_tools_outside_rely_on():
    report = report_of(
        statistics_of(goal("Srobot1", "reached", 50.0), goal("Srobot2", "failed", 80.0))
    )
    assert set(report) >= KEYS
    assert report["goals"] == {"sent": 1, "reached": 1, "failed": 1, "pending": 0}
    assert (report["wall_time"], report["restarts"]) == (15.0, 1)
    assert report["makespan"] == 80.0
    assert report["throughput_per_minute"] == 0.75
    assert report["min_clearance"] == 0.1235
    assert set(report["cpu_ms_per_robot_second"]) == {
        "world", "navigators", "onlookers", "total",
    }  # fmt: skip
    assert report["robots"]["Srobot1"] == {
        "goals_reached": 1, "goals_failed": 0, "hold_time": 0.0, "wait_time": 0.0,
        "worst_goal_duration": 40.0, "finish_time": 50.0, "distance": 20.0, "collisions": 0,
        "near_misses": None,
        "min_clearance": 0.2, "pushes": 0, "retreats": 0, "deadlocks_resolved": 0, "replans": 0,
        "recoveries": 0, "restarts": 0,
    }  # fmt: skip
    assert report["breaches"]["missed_goals"] == [
        {"robot": "Srobot2", "goal": "a", "sim_time": 80.0, "reason": "error 208: closed"}
    ]


def test_inputs_turned_away_by_all_processes_are_summed_by_kind():
    """A forged input leaves a trace."""
    events = (say.InputsRejected({"odom": 2, "goal": 1}, {}), say.InputsRejected({"goal": 40}, {}))
    assert report_of(statistics_of(*events))["rejected"] == {"goal": 41, "odom": 2}
    assert report_of(statistics_of())["rejected"] == {}


def test_the_document_names_every_field():
    text = (Path(__file__).resolve().parents[5] / "docs" / "report.md").read_text("utf-8")
    report = report_of(statistics_of())
    for part in (report, report["robots"]["Srobot1"], report["breaches"], report["goals"]):
        assert [name for name in part if f"`{name}`" not in text] == []


def test_waits_and_counters_are_summed_over_the_robots():
    counts = {"pushes": 3, "retreats": 1, "deadlocks_resolved": 2, "replans": 7}
    report = report_of(
        statistics_of(
            status("Srobot1", hold_time=4.0, wait_time=1.5, number_of_recoveries=1, **counts),
            status("Srobot2", hold_time=2.0, wait_time=8.0, **counts),
        )
    )
    assert (report["hold_time"], report["wait_time"], report["worst_wait"]) == (6.0, 9.5, 10.0)
    assert {name: report[name] for name in counts} == {n: 2 * c for n, c in counts.items()}
    assert report["recoveries"] == 1
    assert report["robots"]["Srobot2"]["wait_time"] == 8.0


def test_fairness_is_the_longest_over_the_median_time_of_a_goal():
    times = [("Srobot1", 20.0), ("Srobot1", 30.0), ("Srobot2", 90.0)]
    events = [goal(robot, "reached", time) for robot, time in times]
    report = report_of(statistics_of(*events, goal("Srobot2", "failed", 500.0)))
    assert report["goal_duration"] == {"median": 20.0, "worst": 80.0}
    assert report["fairness"] == 4.0
    assert report_of(statistics_of())["fairness"] is None


CRASH = {"robots": ["Srobot2"], "obstacle": "wall_3", "x": 1.234, "y": 5.0, "sim_time": 7.25}


def test_breaches_are_told_with_robots_place_and_time():
    events = (say.CollisionBegan(Collision.from_json(CRASH)), goal("Srobot1", "failed", 80.0))
    driving = status("Srobot2", state="waiting", detail="for Srobot1", goal_map=(1.0, 2.0))
    sent = say.GoalSent("Srobot2", "loader_4")
    breaches = report_of(statistics_of(*events, sent, driving))["breaches"]
    told = [
        "collision of Srobot2 and wall_3 at (1.23, 5.00), t = 7.2 s",
        "Srobot1 missed a at t = 80.0 s: error 208: closed",
    ]
    assert breach_lines(breaches, had_to_finish=False) == told
    rest = "Srobot2 did not get to loader_4: waiting for Srobot1"
    assert breach_lines(breaches, had_to_finish=True) == [*told, rest]


def test_a_report_without_a_verdict_says_what_is_unknown():
    progress = say.WorldProgress(40.0, 2.0, say.CollisionCounts(1, 2))
    report = report_of(statistics_of(progress), {})
    assert report["sim_time"] == 40.0
    assert report["collisions"] == {"robot_robot": 1, "robot_world": 2}
    assert report["min_clearance"] is None
    assert report["trajectory_sha256"] is None
    assert report["makespan"] is None
    assert report["throughput_per_minute"] == 0.0


def test_a_report_is_strict_json(tmp_path):
    report = report_of(statistics_of(), {**VERDICT, "min_clearance": math.inf})
    write_report(tmp_path / "report.json", report)
    assert json.loads((tmp_path / "report.json").read_text(encoding="utf-8")) == report


SENT = say.GoalSent("Srobot1", "a")


@pytest.mark.parametrize(
    ("events", "verdict", "is_unfinished", "component_failed", "code"),
    [
        ([goal("Srobot1", "reached", 1.0)], {}, False, False, 0),
        ([goal("Srobot1", "failed", 1.0)], {}, False, False, 1),
        ([SENT], {}, False, False, 0),
        ([SENT], {}, True, False, 1),
        ([], {}, True, False, 1),
        ([], {"robot_robot": 1}, False, False, 1),
        ([], {"robot_world": 1}, False, False, 1),
        ([goal("Srobot1", "failed", 1.0)], {"robot_world": 1}, True, True, 3),
    ],
)
def test_the_exit_code_follows_from_the_report(
    events, verdict, is_unfinished, component_failed, code
):
    report = report_of(statistics_of(*events), VERDICT | verdict)
    assert code == exit_code(report, is_unfinished=is_unfinished, component_failed=component_failed)


def test_goals_never_sent_are_pending_and_the_verdict_knows_collisions():
    events = (SENT, goal("Srobot1", "reached", 1.0), say.MissionLoaded(6))
    assert report_of(statistics_of(*events))["goals"] == {
        "sent": 1, "reached": 1, "failed": 0, "pending": 5
    }  # fmt: skip
    report = report_of(statistics_of(), VERDICT | {"collisions": [CRASH, CRASH]})
    assert len(report["breaches"]["collisions"]) == 2
    crashes = {**report["breaches"], "collisions": [CRASH] * 12}
    lines = breach_lines(crashes, had_to_finish=True)
    assert lines[-1] == "and 2 more collisions; all are in the report"


@pytest.mark.parametrize(
    ("goals", "text"),
    [
        ((16, 13, 0, 11), "13 of 24, 0 missed, 11 open: 3 under way, 8 not sent"),
        ((20, 20, 0, 0), "20 of 20, 0 missed"),
        ((5, 3, 2, 0), "3 of 5, 2 missed"),
    ],
)
def test_the_summary_says_what_became_of_all_goals(goals, text):
    names = ("sent", "reached", "failed", "pending")
    assert goals_text(dict(zip(names, goals, strict=True))) == text


def test_without_a_mission_goals_are_what_the_robots_report():
    statistics = statistics_of(
        status("Srobot1", goals_reached=2, goal_map=(1.0, 2.0), sim_time=9.0),
        status("Srobot2", goals_reached=1, goals_failed=1, sim_time=12.0),
        status("Srobot2", goals_reached=1, goals_failed=1, sim_time=14.0),
        has_mission=False,
    )
    assert (statistics.sent, statistics.reached, statistics.failed, statistics.pending) == (
        5,
        3,
        1,
        1,
    )
    assert statistics.last_goal_time == 12.0


def test_a_goal_from_outside_that_is_tried_again_is_missed_once():
    """`swarm-commander` by hand tries a goal four times; its robot counts each try."""
    events, now = [], 10.0
    for tries in range(4):
        events.append(status("Srobot1", goal_map=(1.0, 2.0), goals_failed=tries, sim_time=now))
        events.append(status("Srobot1", goals_failed=tries + 1, sim_time=now + 60.0))
        now += 61.0
    under_way = statistics_of(*events[:-1], has_mission=False)
    assert report_of(under_way)["goals"] == {"sent": 1, "reached": 0, "failed": 0, "pending": 1}
    over = statistics_of(*events, has_mission=False)
    assert report_of(over)["goals"] == {"sent": 1, "reached": 0, "failed": 1, "pending": 0}
    elsewhere = status("Srobot1", goal_map=(5.0, 2.0), goals_failed=4, sim_time=now)
    later = statistics_of(*events, elsewhere, has_mission=False)
    assert report_of(later)["goals"] == {"sent": 2, "reached": 0, "failed": 1, "pending": 1}
    again = status("Srobot1", goal_map=(1.0, 2.0), goals_failed=4, sim_time=now + 100.0)
    much_later = statistics_of(*events, again, has_mission=False)
    assert report_of(much_later)["goals"] == {"sent": 2, "reached": 0, "failed": 1, "pending": 1}


def test_goals_from_outside_are_told_and_timed_as_those_of_a_mission():
    why = "missed its goal: error 208: no path"
    there, then = (1.0, 2.0), (-4.0, 0.5)
    statistics = statistics_of(
        status("Srobot1", goal_map=there, sim_time=5.0),
        status("Srobot1", goals_reached=1, sim_time=17.0),
        status("Srobot1", goal_map=then, goals_reached=1, sim_time=20.0),
        status("Srobot1", goals_reached=1, goals_failed=1, sim_time=21.0, detail=why),
        has_mission=False,
    )
    report = report_of(statistics)
    assert report["goal_duration"] == {"median": 12.0, "worst": 12.0}
    assert breach_lines(report["breaches"], had_to_finish=False) == [
        "Srobot1 missed (-4, 0.5) at t = 21.0 s: error 208: no path"
    ]


def test_terminal_and_page_say_the_same_of_robots_and_makespan():
    newcomer = say.RobotSpawned("Srobot3", 3, "waffle", (0.0, 0.0, 0.0), 1.0)
    open_one = status("Srobot1", goal_map=(1.0, 2.0), goals_reached=1, sim_time=9.0)
    report = report_of(statistics_of(newcomer, open_one, has_mission=False))
    console = Console(width=100, file=io.StringIO())
    series = {"lost": {"seconds": 15.04, "share": 0.1}, "longest_stop": {"duration": 10.0}}
    console.print(summary_table(report | series, 0))
    text = console.file.getvalue()
    assert "time lost, longest stop of a robot   │ 15.0 s, 10.0 s" in text
    assert "2 robots and 1 that came in" in text
    assert "makespan                             │ goals are open" in text
    assert merits(report)["makespan"] == "goals are open"


def test_there_is_no_guarantee_if_a_lidar_looks_over_broken_robots():
    room = say.ConditionsChecked("all 2 robots have room", True, 40, 2, [])
    for unseen in ([], ["the LiDAR of a waffle does not meet a carrier"]):
        for events in (
            (say.WorldBuilt([], "", unseen), room),
            (room, say.WorldBuilt([], "", unseen)),
        ):
            found = report_of(statistics_of(*events))["conditions"]
            assert (found["guaranteed"], found["findings"]) == (not unseen, unseen)


def test_a_dead_robot_neither_holds_nor_is_active():
    statistics = statistics_of(
        say.NavigatorActive("Srobot1", 1),
        say.NavigatorActive("Srobot2", 2),
        status("Srobot1", state="holding", detail="for loader_1"),
        status("Srobot2", state="holding"),
    )
    assert (statistics.active, statistics.holding) == (2, ["Srobot1", "Srobot2"])
    statistics.apply(say.NavigatorDied("Srobot2", -9))
    assert (statistics.active, statistics.holding) == (1, ["Srobot1"])
    lines = [str(line).split() for line in status_table(statistics)]
    assert lines[0][:2] == ["Srobot1", "holding"]
    assert lines[1][:2] == ["Srobot2", "dead"]
    assert summary_line("running", statistics).startswith("running | active 1/2 | goals 0 | ")


def test_batteries_are_told_of_the_robots_that_have_one():
    battery = {"least": 0.0, "final": 0.5, "charges": 2, "charging_time": 41.25,
               "energy_used": 0.75, "empty_at": 12.5}  # fmt: skip
    robots = {"Srobot1": {**VERDICT["robots"]["Srobot1"], "battery": battery}}
    report = report_of(statistics_of(), VERDICT | {"robots": VERDICT["robots"] | robots})
    one, two = report["robots"]["Srobot1"], report["robots"]["Srobot2"]
    assert {f"battery_{name}": value for name, value in battery.items()}.items() <= one.items()
    assert not [name for name in two if name.startswith("battery")]
    text = (Path(__file__).resolve().parents[5] / "docs" / "report.md").read_text("utf-8")
    assert [name for name in one if f"`{name}`" not in text] == []
    rows = [*summary_table(report, 0).columns[0].cells]
    assert "lowest battery, charges" in rows
    assert "empty batteries" in rows
    assert "empty batteries" not in [*summary_table(report_of(statistics_of()), 0).columns[0].cells]
