"""Typical runs end as they are kept to end, field by field; only times and machines may differ."""

import json

import pytest

from tests import goldens
from tests.goldens import COMMANDS, GRAPH, KEPT, LONG_GRAPH, NAMES, PYTHON, differences, masked

FILE = json.loads(KEPT.read_text(encoding="utf-8"))
MEANT = "if all of this is meant, run `python -m tests.goldens`"
LONG = [pytest.param(name, marks=pytest.mark.long) for name in LONG_GRAPH]


@pytest.fixture(scope="module")
def folder():
    with goldens.folder_of_runs() as found:
        yield found


@pytest.mark.parametrize("name", [*COMMANDS, *PYTHON, *GRAPH, *LONG])
def test_a_run_ends_as_kept(name, folder):
    if "refused" not in name and FILE["libraries"] != goldens.libraries():
        pytest.skip(f"results are kept for {FILE['libraries']}")
    new = goldens.golden(name, folder)
    if lines := list(differences(FILE["goldens"].get(name, {}), new)):
        pytest.fail("\n".join([name, *lines, MEANT]), pytrace=False)


def test_what_is_kept_is_what_is_run():
    assert list(FILE["goldens"]) == NAMES


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
