"""A record becomes report.json and a bench's line, and both become a record again."""

import gzip
import json
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.model.breaches import MissedGoal, UnfinishedGoal
from swarm_run.record.compose import RobotFacts, compose_record
from swarm_run.record.figures import percentiles, rounded, waiting
from swarm_run.record.report_file import record_of, report_of
from swarm_run.record.run_record import COUNTERS, Goals, RunRecord, record_from_json

KEPT = Path(__file__).resolve().parents[4] / "benchmarks" / "results"
BATTERY = {"least": 0.25, "final": 0.5, "charges": 2, "empty_at": None}
CRASH = {"robots": ["a"], "obstacle": "wall", "x": 1.0, "y": 2.0, "sim_time": 7.0}
VERDICT: dict[str, Any] = {
    "sim_time": 100.0, "robot_robot": 0, "robot_world": 1, "near_misses": 1, "min_clearance": 0.0,
    "trajectory_sha256": "00", "collisions": [CRASH],
    "robots": {
        "a": {"distance": 20.0, "collisions": 1, "near_misses": 1, "min_clearance": 0.0},
        "b": {"distance": 9.0, "collisions": 0, "near_misses": 0, "min_clearance": float("inf"),
              "battery": BATTERY},
    },
}  # fmt: skip
WAITS = {"lasting_circles": 1, "longest_circle": 6.0, "circles": [], "at_the_end": {}}


def robot(*ends, failed=0, wait_time=0.0):
    return RobotFacts(
        reached=len(ends), failed=failed, ends=ends, is_done=True, hold_time=1.0,
        wait_time=wait_time, counts=dict.fromkeys(COUNTERS, 2),
    )  # fmt: skip


def record(**changes):
    facts = {"a": robot((30.0, 30.0), (50.0, 15.0)), "b": robot((20.0, 20.0), failed=1)}
    given: dict[str, Any] = {
        "missed": [MissedGoal("b", "dock", 80.0, "closed")], "waits": WAITS, "robots": 2,
        "seed": 4, "wall_time": 5.0, "processes": {"has_verdict": True, "world": "hall"},
    }  # fmt: skip
    return compose_record(facts, Goals(4, 3, 1, 0), 80.0, VERDICT, **given | changes)


def test_throughput_and_misses_count_what_was_settled():
    found = record()
    assert found.throughput_per_minute == pytest.approx(60.0 * 3 / 80.0)
    assert (found.makespan, found.settled_time) == (None, 80.0)
    assert (found.goals_sent, found.goals_reached, found.goals_failed) == (4, 3, 1)
    assert found.first_miss == "b missed dock at t = 80.0 s: closed"
    finish = {name: each.finish_time for name, each in found.per_robot.items()}
    assert finish == {"a": 50.0, "b": None}
    facts, goals = {"a": robot((30.0, 30.0))}, Goals(2, 1, 0, 1)
    way = [UnfinishedGoal("a", "dock", "driving")]
    given: dict[str, Any] = {"waits": WAITS, "robots": 1, "seed": 0, "wall_time": 1.0}
    ended = compose_record(facts, goals, 30.0, VERDICT, unfinished=way, **given)
    assert (ended.goals_sent, ended.goals_failed, ended.makespan) == (2, 1, None)
    endless = compose_record(facts, goals, 30.0, VERDICT, is_endless=True, **given)
    assert (endless.goals_sent, endless.goals_failed, endless.makespan) == (1, 0, None)


def test_the_record_of_a_report_says_what_was_reported():
    report = json.loads(json.dumps(report_of(record())))
    again = record_of(report)
    assert {**report_of(again), **report} == report
    differing = {"processes", "scenario", "cpu_ms_per_robot_second"}
    for name in set(RunRecord.__struct_fields__) - differing:
        assert rounded(getattr(again, name)) == rounded(getattr(record(), name)), name
    assert again.per_robot["b"].battery == BATTERY


def test_a_line_becomes_its_record_and_lacks_what_only_the_report_says():
    data = json.loads(json.dumps(record().as_json()))
    assert data.pop("schema") == 1
    assert {**record_from_json(data).as_json(), **data} == {"schema": 1, **data}
    names = set(RunRecord.__struct_fields__) - set(record().as_json())
    assert {"processes", "waits", "breaches", "goals", "settled_time"} <= names


@pytest.mark.parametrize("name", ["rows", "baselines", "halls"])
def test_lines_on_disk_are_read(name):
    with gzip.open(KEPT / f"{name}.jsonl.gz", "rt", encoding="utf-8") as file:
        lines = [json.loads(line) | {"per_robot": {}} for line in file]
    for line in lines:
        found = record_from_json(line).as_json()
        assert {key: found[key] for key in line} == line
    with pytest.raises(msgspec.ValidationError, match="seed"):
        record_from_json(lines[0] | {"seed": "one"})


@given(st.lists(st.floats(0.0, 1e6), min_size=1))
def test_half_of_the_robots_waited_less_than_the_median(times):
    found = waiting(times)
    assert found.median == pytest.approx(percentiles(times, median=50)["median"])
    assert found.worst == max(times)


def test_what_is_not_finite_is_null():
    data = {"a": float("nan"), "b": [float("inf"), 1.23456], "c": Goals(1, 2, 3, 4)}
    goals = {"sent": 1, "reached": 2, "failed": 3, "pending": 4}
    assert rounded(data) == {"a": None, "b": [None, 1.2346], "c": goals}
