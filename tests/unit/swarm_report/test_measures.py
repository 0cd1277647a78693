"""Figures out of a run's time series, and the words about where it lost time."""

import json
import re
from typing import cast

import numpy as np
import pytest

from swarm_common.files.journal import Journal
from swarm_common.files.map_io import save_map
from swarm_common.model.grid import Grid
from swarm_common.model.run_words import SERIES_FIELDS
from swarm_describe.robots.loading import load_robot
from swarm_report.bottleneck import find_bottleneck, lost_words
from swarm_report.charts import timeline
from swarm_report.document import document_html, shares
from swarm_report.headline import headline, headline_text, report_fields, waits_between
from swarm_report.ideal import ideal_times
from swarm_report.measures import lost_time, shares_over_time, state_shares, station_use, throughput
from swarm_report.run import RunData
from swarm_report.run_files import Report

SITES = "stations:\n  dock: [2.0, 2.0, 0.0]\n  shop: [8.0, 8.0, 0.0]\n"
END = 100


class Story:
    """A run of four robots that are far from everything but where a test puts them."""

    def __init__(self, folder):
        self.folder, self.places, self.lines = folder, dict[tuple[int, int], list[float]](), []

    def state(self, robot, t, state, station="", place=0):
        self.lines.append((t, robot, {"state": state, "station": station, "place": place}))

    def waited(self, robot, t, seconds, at, whom=""):
        waiting = {"state": "waiting", "station": "", "place": 0, "blocker": whom}
        self.lines.append((t, robot, waiting))
        self.state(robot, t + seconds, "driving")
        self.places[robot, t] = at

    def reached(self, robot, t, goal):
        self.lines.append((t, robot, {"goal": goal, "outcome": "reached", "duration": 1.0}))

    def run(self):
        for name in ("config", "trace"):
            (self.folder / name).mkdir()
        (self.folder / "sites.yaml").write_text(SITES)
        names = [f"Srobot{robot + 1}" for robot in range(4)]
        robots = [{"name": name} for name in names]
        config = {"world": "hall", "robots": robots, "sites": str(self.folder / "sites.yaml")}
        (self.folder / "config" / "world.json").write_text(json.dumps(config))
        world = Journal(self.folder / "trace" / "world.jsonl")
        world.write(robots=names, near_mm=500)
        for t in range(END + 1):
            spots = [self.places.get((robot, t), [50.0, 50.0 + robot]) for robot in range(4)]
            x, y = ([round(1000 * spot[axis]) for spot in spots] for axis in (0, 1))
            far = [500] * 4
            world.write(t=t, x=x, y=y, yaw=[0] * 4, to_robot=far, to_world=far)
        journal = Journal(self.folder / "trace" / "robots.jsonl")
        for t, robot, line in sorted(self.lines, key=lambda entry: entry[:2]):
            journal.write(t=t, robot=names[robot], **line)
        return RunData(self.folder)


@pytest.fixture
def story(tmp_path):
    story = Story(tmp_path)
    for robot in range(4):
        story.state(robot, 0.0, "driving")
    return story


def test_use_and_queue_of_a_station(story):
    story.state(0, 10.0, "holding", "dock")
    story.state(0, 30.0, "driving")
    story.state(1, 20.0, "driving", "dock", place=1)
    story.state(1, 50.0, "driving")
    story.reached(2, 40.0, "dock")
    for t in range(40, 60):
        story.places[2, t] = [2.0, 2.3]
    use = station_use(story.run())["dock"]
    assert use.utilisation == pytest.approx(20 / 101)
    assert (use.goals, use.longest_queue, use.queue_time) == (1, 2, pytest.approx(50.0))
    assert use.queue == pytest.approx(0.5)
    assert station_use(RunData(story.folder))["shop"].queue_time == 0.0


def test_one_robot_after_another_is_no_longer_queue(story):
    for robot, (start, end) in enumerate(((10.0, 20.0), (20.0, 30.0))):
        story.state(robot, start, "holding", "dock")
        story.state(robot, end, "driving")
    assert station_use(story.run())["dock"].longest_queue == 1


def test_throughput_has_a_rate_for_each_window(story):
    for t in (1.0, 2.0, 95.0):
        story.reached(0, t, "dock")
    flow = throughput(story.run())
    assert (flow.window, flow.starts[-1], flow.ends[-1]) == (10.0, 90.0, 100.0)
    assert flow.per_minute.tolist() == [12.0, 0, 0, 0, 0, 0, 0, 0, 0, 6.0]
    assert flow.mean == pytest.approx(60.0 * 3 / 95.0)  # as in report.json, not of 100 s


def test_bars_of_a_state_that_few_robots_were_in_are_as_high_as_others(story):
    """Left to itself, plotly draws them as high as the distance of their robots' rows."""
    story.state(0, 60.0, "waiting")
    chart = timeline(story.run())
    assert {bars["width"] for bars in chart["data"]} == {0.88}


def test_shares_of_states(story):
    story.state(0, 60.0, "waiting")
    run = story.run()
    assert state_shares(run) == pytest.approx({"driving": 0.9, "waiting": 0.1})
    over_time = shares_over_time(run)
    np.testing.assert_allclose(over_time.by_state["waiting"][[0, -1]], [0.0, 0.25])


def test_a_station_that_most_robots_held_for_is_the_bottleneck(story):
    story.state(0, 10.0, "holding", "dock")
    story.state(0, 40.0, "driving")
    story.waited(1, 50, 6.0, [2.5, 2.5])  # close to it
    story.waited(2, 60, 4.0, [20.0, 20.0])
    found = find_bottleneck(story.run())
    assert (found.station, found.seconds, found.lost.seconds) == ("dock", 36.0, 40.0)
    assert found.words.startswith(
        "dock at (2.0, 2.0) is the bottleneck: 90 % of all lost time"
        " (36 of 40 robot-seconds) was for it or within 1.5 m of it"
    )
    assert "took 10.0 % of the robots' time." in found.words


def test_the_share_of_lost_time_is_the_same_everywhere_and_shares_are_all_of_it(story):
    story.state(0, 10.0, "holding", "dock")
    story.state(0, 40.0, "driving")
    story.state(1, 50.0, "yielding")
    story.state(1, 70.0, "idle")
    story.waited(2, 60, 6.0, [20.0, 20.0])
    run = story.run()
    found, lost = find_bottleneck(run), lost_time(run)
    assert (lost.seconds, lost.share) == (56.0, 0.14)
    assert "took 14.0 % of the robots' time" in found.words
    assert "<b>14.0 %</b>" in document_html(run)
    assert headline_text(run).startswith("100 s; 14 % lost, most of it near dock; ")
    told = sum(float(share.removesuffix(" %")) for share in shares(run).values())
    assert told == pytest.approx(100.0, abs=0.2)
    assert sum(state_shares(run).values()) == pytest.approx(1.0)


def test_waiting_after_the_mission_does_not_shrink_the_share_of_lost_time(story):
    story.state(0, 10.0, "waiting")
    for robot in range(4):
        story.state(robot, 50.0, "idle")
        story.reached(robot, 50.0, "dock")
    run = story.run()
    lost = lost_time(RunData(run.folder, cast(Report, {"goals": {"pending": 0}})))
    assert (lost.seconds, lost.share) == (40.0, 0.2)


def test_the_headline_names_the_longest_stop_and_its_reason_across_states(story):
    story.waited(1, 20, 5.0, [20.0, 20.0], "Srobot3")
    story.waited(0, 30, 7.0, [20.0, 20.0], "Srobot3")
    story.waited(0, 37, 3.0, [20.0, 20.0], "Srobot4")
    parts = {part.text: part.time for part in headline(story.run())}
    assert parts["Srobot1 stopped longest, 10 s, for Srobot3"] == 30.0
    assert waits_between(RunData(story.folder)) == {
        ("Srobot1", "Srobot3"): 7.0, ("Srobot2", "Srobot3"): 5.0, ("Srobot1", "Srobot4"): 3.0,
    }  # fmt: skip
    text = document_html(RunData(story.folder))
    assert 'data-moment="30.0"' in text
    assert "--start 25" in text
    assert 'id="blockers"' in text


def test_headline_and_table_have_their_stops_from_one_computation(story):
    """A headline said "waited 29 s", its table 0.0 s: that one was of the navigators' counters."""
    story.waited(0, 30, 7.0, [20.0, 20.0], "Srobot3")
    story.state(0, 37.0, "yielding")
    story.state(0, 40.0, "idle")
    story.waited(1, 20, 5.0, [20.0, 20.0])
    run = story.run()
    assert "Srobot1 stopped longest, 10 s" in headline_text(run)
    robots = {name: {"wait_time": 0.0, "hold_time": 0.0} for name in run.robots}
    goals = dict.fromkeys(("reached", "sent", "failed", "pending"), 0)
    counted = {"goals": goals, "cpu_ms_per_robot_second": {}, "robots": robots, "swarm_size": 4,
               "collisions": {"robot_robot": 0, "robot_world": 0}}  # fmt: skip
    text = document_html(RunData(story.folder, cast(Report, counted)))
    row = r"<td>(Srobot\d)</td><td>–</td><td>–</td><td>(.*?)</td><td>(.*?)</td>"
    assert re.findall(row, text) == [
        ("Srobot1", "10.0", "10.0"), ("Srobot2", "5.0", "5.0"),
        ("Srobot3", "0.0", "0.0"), ("Srobot4", "0.0", "0.0"),
    ]  # fmt: skip


def test_a_place_without_a_station_can_be_the_bottleneck(story):
    for t, offset in ((10, -0.5), (20, 0.0), (30, 0.5)):
        story.waited(0, t, 10.0, [20.0 + offset, 20.0])
    story.state(1, 10.0, "holding", "shop")
    story.state(1, 20.0, "driving")
    found = find_bottleneck(story.run())
    assert (found.station, found.x, found.seconds) == ("", pytest.approx(20.0), 30.0)
    assert found.words.startswith("The floor around (20.0, 20.0) is the bottleneck: 75 %")


@pytest.mark.parametrize(
    ("holds", "said"),
    [
        ({"dock": 30.0, "shop": 29.0}, "most of it was at dock 51 %, shop 49 %."),
        ({"dock": 5.0}, ""),  # too little to look for a reason
        ({}, ""),
    ],
)
def test_nothing_is_called_the_bottleneck_where_nothing_stands_out(story, holds, said):
    for robot, (station, seconds) in enumerate(holds.items()):
        story.state(robot, 10.0, "holding", station)
        story.state(robot, 10.0 + seconds, "driving")
    run = story.run()
    assert find_bottleneck(run) is None
    assert lost_words(run).endswith(said)
    assert bool(lost_words(run)) == bool(said)
    assert said in document_html(run)


def test_the_report_has_the_figures(story):
    story.state(0, 10.0, "holding", "dock")
    story.state(0, 40.0, "driving")
    story.reached(0, 45.0, "dock")
    fields = report_fields(story.run())
    assert tuple(fields) == SERIES_FIELDS
    assert json.loads(json.dumps(fields, allow_nan=False)) == fields
    assert fields["stations"]["dock"]["queue"] == 0.3
    assert fields["throughput"]["per_minute"][4] == 6.0
    assert fields["state_shares"] == {"driving": 0.925, "holding": 0.075}
    assert fields["bottleneck"]["station"] == "dock"


def test_a_run_without_time_series_has_no_figures(tmp_path):
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "world.json").write_text('{"robots": [{"name": "Srobot1"}]}')
    fields = report_fields(RunData(tmp_path))
    empty = {"stations": {}, "state_shares": {}, "ideal_times": {}, "waited_for": []}
    assert fields == dict.fromkeys(SERIES_FIELDS) | empty


def test_the_ideal_time_is_that_of_the_shortest_way_around_walls(tmp_path):
    cells = np.zeros((100, 100), np.int8)
    cells[:, 50:52] = 100
    cells[80:, 50:52] = 0  # a gap at the top
    for name in ("config", "trace"):
        (tmp_path / name).mkdir()
    save_map(Grid(cells, 0.1, 0.0, 0.0), tmp_path / "trace" / "map.yaml")
    robots = [{"name": "Srobot1", "model": "turtlebot3_waffle"}, {"name": "Srobot2"}]
    (tmp_path / "config" / "world.json").write_text(json.dumps({"robots": robots}))
    world = Journal(tmp_path / "trace" / "world.jsonl")
    world.write(robots=["Srobot1", "Srobot2"], near_mm=500)
    for t, x in ((0, 2000), (50, 8000)):
        world.write(t=t, x=[x, x], y=[2000, 2000], yaw=[0, 0], to_robot=[0, 0], to_world=[0, 0])
    journal = Journal(tmp_path / "trace" / "robots.jsonl")
    for name in ("Srobot1", "Srobot2"):
        journal.write(t=50.0, robot=name, goal="there", outcome="reached", duration=50.0)
    straight, around = 6.0, 2.0 * np.hypot(3.0, 6.0)
    times = ideal_times(RunData(tmp_path))
    assert list(times) == ["Srobot1"]  # of the other one no model is known
    length = times["Srobot1"] * load_robot("turtlebot3_waffle").max_vel_x
    assert straight < around < length < 1.15 * around
