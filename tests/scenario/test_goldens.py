"""Typical runs end as they are kept to end, field by field; only times and machines may differ."""

import json
from pathlib import Path

import pytest

from tests.goldens import (
    COMMANDS,
    GRAPH,
    KEPT,
    LONG_GRAPH,
    NAMES,
    PYTHON,
    differences,
    folder_of_runs,
    golden,
    masked,
)
from tests.kept_trajectories import libraries

KEPT_NOW = json.loads(KEPT.read_text(encoding="utf-8"))
MEANT = "if all of this is meant, run `python -m tests.goldens`"


@pytest.fixture(scope="module")
def folder():
    with folder_of_runs() as found:
        yield found


def check(name: str, folder: Path) -> None:
    if "refused" not in name and KEPT_NOW["libraries"] != libraries():
        pytest.skip(f"results are kept for {KEPT_NOW['libraries']}")
    old = KEPT_NOW["goldens"].get(name, {})
    if lines := list(differences(old, golden(name, folder))):
        pytest.fail("\n".join([name, *lines, MEANT]), pytrace=False)


@pytest.mark.parametrize("name", [*COMMANDS, *PYTHON])
def test_a_run_in_this_process_ends_as_kept(name, folder):
    check(name, folder)


@pytest.mark.parametrize("name", GRAPH)
def test_a_short_run_on_the_graph_ends_as_kept(name, folder):
    check(name, folder)


@pytest.mark.long
@pytest.mark.parametrize("name", LONG_GRAPH)
def test_a_run_on_the_graph_ends_as_kept(name, folder):
    check(name, folder)


def test_what_is_kept_is_what_is_run():
    assert list(KEPT_NOW["goldens"]) == NAMES


def test_every_change_is_a_line_and_nothing_else_is():
    old = masked({"wall_time": 1.0, "origin": {"host": "a"}, "goals": [1, float("nan")], "a": None})
    new = masked({"wall_time": 2.0, "origin": {"commit": "b"}, "goals": [2, float("nan")], "b": {}})
    assert list(differences(old, new)) == [
        'origin.host: "*" → "(absent)"',
        'origin.commit: "(absent)" → "*"',
        "goals[0]: 1 → 2",
        'a: null → "(absent)"',
        'b: "(absent)" → {}',
    ]
