"""Who waits for whom is read from what the robots say, and circles that last are counted."""

import pytest

from swarm_common.model.run_words import waits_for
from swarm_mission.wait_graph import WaitGraph


@pytest.mark.parametrize(
    ("state", "detail", "other"),
    [
        ("waiting", "for Srobot12, which is in the way", "Srobot12"),
        ("holding", "parked, waits for Srobot3, 2 before it at loader_1", "Srobot3"),
        ("holding", "parked, waits until loader_1 is free", ""),
        ("holding", "parked, waits for room on the single lanes at loader_1", ""),
        ("yielding", "makes way for Srobot8", ""),
        ("yielding", "makes way for Srobot8, waits for Srobot7, which is in the way", "Srobot7"),
        ("waiting", "for agv_07, which is in the way", "agv_07"),
        ("holding", "parked, waits for ann: the narrow region ahead is full", "ann"),
        ("waiting", "stands: no scan for more than 1.0 s", ""),
        ("waiting", "before an obstacle", ""),
        ("driving", "", ""),
    ],
)
def test_making_way_is_not_waiting(state, detail, other):
    assert waits_for(state, detail) == other


def test_a_circle_that_lasts_is_counted_once():
    graph = WaitGraph()
    for robot, other, time in (("a", "b", 1.0), ("b", "c", 2.0), ("d", "a", 2.5), ("c", "a", 3.0)):
        graph.note(robot, other, time)
        graph.note(robot, other, time + 0.1)  # said again
    graph.note("d", "", 9.0)  # no part of it
    graph.note("b", "d", 10.0)
    told = graph.as_json(50.0)
    assert (told["lasting_circles"], told["longest_circle"]) == (1, 7.0)
    assert told["circles"] == [{"robots": ["c", "a", "b"], "since": 3.0, "duration": 7.0}]
    assert told["at_the_end"] == {"a": "b", "b": "d", "c": "a"}


def test_short_circles_do_not_count_and_open_ones_end_with_the_run():
    graph = WaitGraph()
    graph.note("a", "b", 0.0)
    graph.note("b", "a", 1.0)
    graph.note("b", "", 5.9)
    graph.note("b", "a", 6.0)
    assert graph.as_json(8.0)["lasting_circles"] == 0
    graph.note("b", "", 8.0)
    graph.note("b", "a", 8.0)
    assert graph.as_json(13.0)["lasting_circles"] == 1
