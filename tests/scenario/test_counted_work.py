"""Twice the work of the baseline is a regression; time is never looked at.

`python -m tests.counted_work` writes a new baseline.
"""

import json

import pytest

from tests.counted_work import BASELINE, count_graph, count_harness

MOST = 2.0  # times the baseline
SLACK = 0.2  # beside: figures that are next to nothing may double


def regressions(part, figures):
    baseline = json.loads(BASELINE.read_text(encoding="utf-8"))[part]
    assert figures.keys() == baseline.keys()
    return [
        f"{name}: {value:.3f}, baseline {baseline[name]:.3f}"
        for name, value in figures.items()
        if value > MOST * baseline[name] + SLACK
    ]


def test_world_and_navigators_do_not_do_twice_the_work():
    assert regressions("harness", count_harness()) == []


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_ros_graph_does_not_do_twice_the_work(tmp_path):
    assert regressions("graph", count_graph(tmp_path)) == []


def test_twice_the_work_is_noticed():
    figures = {
        name: 2.5 * value + 1.0
        for name, value in json.loads(BASELINE.read_text(encoding="utf-8"))["harness"].items()
    }
    assert len(regressions("harness", figures)) == len(figures)
