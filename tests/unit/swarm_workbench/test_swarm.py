"""A swarm on the bench: goals, results and what is refused."""

import asyncio
import importlib.util
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from swarm_bench.runs.scenario import Scenario
from swarm_common.model.breaches import Collision
from swarm_common.model.errors import SwarmError
from swarm_workbench import Pixel, Pose, Swarm, Trajectories, load_robot, load_world, run_scenario
from swarm_workbench.goal import GoalTimeoutError
from swarm_workbench.history import RunTables


@pytest.fixture(scope="module")
def swarm():
    with Swarm(robots=2, world="doorway", bench=True, seed=3) as started:
        yield started


def test_a_goal_is_reached_and_told(swarm):
    robot = swarm["Srobot1"]
    x, y = robot.true_pose.x, robot.true_pose.y
    goal = robot.go_to((x + 0.6, y))
    result = goal.wait(timeout=60.0)
    assert result
    assert result.outcome == "succeeded"
    assert goal.wait() is result  # a second wait returns at once
    assert abs(robot.true_pose.x - x - 0.6) < 0.26
    assert abs(robot.pose.x - robot.true_pose.x) < 0.05
    assert swarm.report.goals_reached == 1
    assert swarm.report.collisions == 0
    assert len(robot.scan.ranges) == load_robot("turtlebot3_waffle").lidar.rays


def test_time_passes_by_ticks_and_is_recorded(swarm, tmp_path):
    before = swarm.time
    swarm.run(seconds=1.3)
    assert swarm.time == pytest.approx(before + 1.3)
    run = swarm.trajectories
    assert run.names == ("Srobot1", "Srobot2")
    assert len(run.times) == round(swarm.time * 10) + 1
    assert np.allclose(run.true[-1], swarm.true_poses)
    assert np.allclose(run.estimated[-1], swarm.poses)
    assert len(run.table()) == 2 * len(run.times)
    run.save(tmp_path)
    read = Trajectories.load(tmp_path)
    assert read.names == run.names
    assert np.array_equal(read.times, run.times)
    assert np.allclose(read.true, run.true, atol=1e-5)


def test_tables_say_what_robots_did(swarm):
    states, events = list(_rows(swarm.states)), list(_rows(swarm.events))
    assert states[0][1:3] == ("Srobot1", "idle")
    assert [row[2] for row in states if row[1] == "Srobot1"][:3] == ["idle", "driving", "idle"]
    assert [row[1:3] for row in events] == [("Srobot1", "reached")]
    assert 0.0 < events[0][0] <= swarm.time
    assert not list(_rows(swarm.waits))


def test_waits_and_contacts_are_rows():
    history = RunTables(["a", "b"])
    for time, detail in ((1.0, ""), (2.0, "for b, which is in the way"), (5.5, "")):
        state = "waiting" if detail else "driving"
        status = SimpleNamespace(state=state, detail=detail, goals_reached=0, goals_failed=0)
        history.note("a", status, time)
    history.note("b", SimpleNamespace(**vars(status) | {"goals_failed": 1}), 6.0)
    assert list(_rows(history.waits())) == [(2.0, "a", "b", 3.5)]
    contacts = [Collision(("a", "b"), "", 0.0, 0.0, 3.0), Collision(("b",), "wall", 0.0, 0.0, 4.0)]
    assert [row[:3] for row in _rows(history.events(contacts))] == [
        (3.0, "a", "contact"), (3.0, "b", "contact"), (4.0, "b", "contact"), (6.0, "b", "failed"),
    ]  # fmt: skip


def _rows(found):
    if hasattr(found, "itertuples"):
        return found.itertuples(index=False, name=None)
    return (tuple(row.tolist()) for row in found)


def test_goals_are_awaited_in_an_event_loop_that_runs(swarm):
    async def both():
        start = swarm["Srobot2"].true_pose
        goals = [
            swarm["Srobot2"].go_to((start.x, start.y, start.yaw)),
            swarm["Srobot1"].send("spin", {"target_yaw": 0.3}),
        ]
        return await asyncio.gather(*goals)

    assert all(asyncio.run(both()))


def test_cancel_timeout_and_a_thread_of_its_own(swarm):
    results = []
    thread = threading.Thread(
        target=lambda: results.append(swarm["Srobot1"].send("wait", {"time": {"sec": 1}}).wait())
    )
    thread.start()
    swarm.run(seconds=2.0)
    thread.join(20.0)
    assert results
    assert results[0]
    goal = swarm["Srobot1"].go_to("east_north")
    with pytest.raises(GoalTimeoutError, match="has not arrived after 1 s"):
        goal.wait(timeout=1.0)
    goal.cancel()
    assert goal.wait(timeout=5.0).outcome == "canceled"


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("east_nort", "unknown station 'east_nort'; did you mean"),
        ((99.0, 0.0), "is in a wall, off the map"),
        (Pixel(0, 0), "is in a wall"),
        ((1.0,), "expected the name of a station"),
        ((1.0, float("nan"), 0.0), "expected the name of a station"),
        (None, "expected the name of a station"),
        ((1.0, 2.0, 3.0, 4.0), "expected the name of a station"),
        (Pose(0.0, float("inf"), 0.0), "expected the name of a station"),
    ],
)
def test_a_goal_that_makes_no_sense_is_refused(swarm, place, message):
    with pytest.raises(SwarmError, match=message):
        swarm["Srobot1"].go_to(place)


def test_names_and_times_that_make_no_sense_are_refused(swarm):
    with pytest.raises(SwarmError, match="unknown robot 'Srobot9'"):
        swarm["Srobot9"]
    with pytest.raises(SwarmError, match="until a later time"):
        swarm.run(until=0.0)
    with pytest.raises(SwarmError, match="not both"):
        swarm.run()
    with pytest.raises(SwarmError, match="the bench takes spin"):
        swarm["Srobot1"].send("dock_robot", {})
    with pytest.raises(SwarmError, match="starts once"):
        swarm.start()


def test_after_the_block_only_results_are_there():
    with Swarm(robots=1, world="doorway", bench=True) as swarm:
        robot = swarm["Srobot1"]
        swarm.run(seconds=0.2)
    assert swarm.report.sim_time == pytest.approx(0.2)
    assert len(swarm.trajectories.times) == 3
    assert len(swarm.states) == 1
    for use in (lambda: robot.pose, lambda: robot.go_to((1, 1)), lambda: swarm.run(until=9.0)):
        with pytest.raises(SwarmError, match="use it inside its with block"):
            use()
    swarm.close()  # once more is harmless


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"world": "no_such"}, "unknown world 'no_such'"),
        ({"robot": "no_such"}, "unknown robot 'no_such'"),
        ({"brain": "no_such"}, "unknown method 'no_such'"),
        ({"brain": "no_such:Brain"}, "cannot import no_such"),
        ({"drive": "wings"}, "unknown drive 'wings'"),
        ({"parameters": {"traffic.no_such": 1}}, "no_such"),
        ({"viewer": True}, "leave out bench=True"),
        ({"robots": 0}, "robots is 0; expected a swarm size"),
    ],
)
def test_options_that_make_no_sense_are_refused(options, message):
    with pytest.raises(SwarmError, match=message):
        Swarm(**({"robots": 1, "world": "doorway", "bench": True} | options)).start()


def test_processes_need_rclpy_and_folders_trajectories(monkeypatch, tmp_path):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(SwarmError, match="this Python has no rclpy"):
        Swarm(robots=1).start()
    with pytest.raises(SwarmError, match="expected the folder of a run"):
        Trajectories.load(tmp_path)


def test_a_picture_has_the_paths(swarm):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = swarm.plot()
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["Srobot1", "Srobot2"]
    matplotlib.pyplot.close(axes.figure)


def test_worlds_that_come_along_have_a_map_and_stations():
    world = load_world("doorway")
    assert "east_north" in world.stations
    assert world.map.cells.shape[0] > 50


def test_a_scenario_ends_at_the_time_limit_that_is_given():
    assert run_scenario("doorway", robots=2, time_limit=5.0).sim_time == pytest.approx(5.0, abs=0.2)
    endless = Scenario(name="endless", world="doorway", mission="change_rooms", duration=60.0)
    result = run_scenario(endless, robots=2, time_limit=5.0)
    assert result.sim_time == pytest.approx(5.0, abs=0.2)


def test_arguments_of_the_wrong_sort_are_refused_in_words():
    for robots in ("two", [2], 2.5, 0):
        with pytest.raises(SwarmError, match=r"robots is .*expected a swarm size"):
            Swarm(robots=robots, world="doorway", bench=True).start()
        with pytest.raises(SwarmError, match="robots"):
            run_scenario("doorway", robots=robots)
    for seed in (-1, 1.5, "one"):
        with pytest.raises(SwarmError, match="seed"):
            run_scenario("doorway", robots=2, seed=seed)
    for limit in (-1.0, 0, "soon", float("nan"), 1e308):
        with pytest.raises(SwarmError, match="time_limit"):
            run_scenario("doorway", robots=2, time_limit=limit)
    for scenario in (3, None):
        with pytest.raises(SwarmError, match="unknown scenario"):
            run_scenario(scenario)
    with pytest.raises(SwarmError, match="method"):
        run_scenario("doorway", robots=2, brain=3)
    with pytest.raises(SwarmError, match="parameters"):
        run_scenario("doorway", robots=2, parameters=[1])
    with Swarm(robots=1, world="doorway", bench=True) as swarm:
        with pytest.raises(SwarmError, match="unknown robot"):
            swarm[1]
        with pytest.raises(SwarmError, match="a number"):
            swarm.run(seconds="a")
