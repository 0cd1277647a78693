"""Names in files are texts as written, whatever YAML makes of such a word elsewhere."""

import pytest

from swarm_common.files import yaml_io
from swarm_common.files.sites_io import load_sites
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError
from swarm_describe.robots.source import find_robot
from swarm_map.floor_plan import load_plan

WORDS = [
    "1", "01", "0x10", "0b1", "1.10", "1e3", "12:30", "1_000", ".5", ".inf", "yes", "no", "on",
    "off", "Yes", "true", "null", "~", "2024-01-01", "2024-01-01T10:00:00", "=", "größe",
]  # fmt: skip


def written(folder, text, name="mine.yaml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("is_fast", [True, False])
def test_stations_are_called_as_written(tmp_path, monkeypatch, is_fast):
    monkeypatch.setattr(yaml_io, "_is_shallow", lambda _: is_fast)
    lines = "".join(f"  {word}: [{k}, 0, 0]\n" for k, word in enumerate(WORDS))
    sites = load_sites(written(tmp_path, f"stations:\n{lines}"))
    assert list(sites.stations) == WORDS
    assert [pose.x for pose in sites.stations.values()] == list(range(len(WORDS)))


def test_floor_plans_keep_them_to_the_end(tmp_path):
    lines = "".join(f"  {word}: [{k}, 0, 0]\n" for k, word in enumerate(WORDS))
    text = f"name: 010\nboxes: [{{name: no, at: [1, 1], size: [1, 1, 1]}}]\nstations:\n{lines}"
    plan = load_plan(written(tmp_path, text))
    assert (plan.name, plan.things[0].name) == ("010", "no")
    assert list(plan.sites["stations"]) == WORDS


def test_arguments_of_xacro_are_as_on_its_command_line(tmp_path):
    written(tmp_path, "<robot/>", "a.urdf")
    lines = "".join(f"  {word}: {word}\n" for word in WORDS)
    source = find_robot(
        written(tmp_path, f"model: 1e3\nxacro_args:\n{lines}  none:\n", "robot.yaml")
    )
    assert source.data["model"] == "1e3"
    assert source.arguments() == {**{word: word for word in WORDS}, "none": ""}


def test_merged_mappings_and_aliases_count_too(tmp_path):
    text = "base: &b {name: 01}\nitems: [{<<: *b}, {name: &n 02}, {at: *n}]\n"
    data = read_yaml(written(tmp_path, text), as_written=("base.name", "items.*.name"))
    assert data["items"] == [{"name": "01"}, {"name": "02"}, {"at": 2}]


def test_values_elsewhere_keep_their_types_without_times_of_day(tmp_path):
    text = "a: [1, 010, 0x10, 1e-3, 1.5e+2, -.inf, yes, ~, 12:30, 2024-01-01, 09, '1']\n"
    values = read_yaml(written(tmp_path, text))["a"]
    infinity = -float("inf")
    numbers = [1, 8, 16, 1e-3, 150.0, infinity, True, None]
    assert values == [*numbers, "12:30", "2024-01-01", "09", "1"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stations:\n  a: [0, 0, 0]\n  'a': [1, 0, 0]\n", "line 3.*'a' occurs twice.* line 2"),
        ("stations:\n  [a]: [0, 0, 0]\n", "line 2.*expected a name"),
        ("stations:\n  '': [0, 0, 0]\n", "stations has the key ''"),
        ('stations:\n  "a\\nb": [0, 0, 0]\n', "the key 'a.*nb'"),
        ("spawn: 0\n", "spawn is 0"),
    ],
)
def test_names_that_are_none_or_equal_are_refused(tmp_path, text, message):
    with pytest.raises(ConfigError, match=f"(?s){message}"):
        load_sites(written(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stations: {a: {at: [0, 0, 0], repeat: [[2, 1, 0]]}, a_1: [5, 0, 0]}", "'a_1' occurs tw"),
        ("walls: [{points: [[0, 0], [1, 0]], closed: 'yes'}]", "closed is 'yes'"),
        ("boxes: 0", "boxes is 0"),
    ],
)
def test_floor_plans_lose_nothing(tmp_path, text, message):
    with pytest.raises(ConfigError, match=message):
        load_plan(written(tmp_path, text))
