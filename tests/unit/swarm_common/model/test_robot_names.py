"""The names of a run's robots, and what is none."""

import re
from pathlib import Path

import pytest

from swarm_commander.run.process_table import ROBOTS_TABLE, TABLE
from swarm_common.middleware.topic_table import WORLD_TOPICS
from swarm_common.model.errors import ConfigError
from swarm_common.model.robot_names import MOST, RESERVED, RobotNames, in_short, natural
from swarm_run.spec import ALL, MERGED, SWARM

ROOT = Path(__file__).parents[4]


@pytest.mark.parametrize(
    ("words", "count", "names"),
    [
        (["agv{}"], 3, ["agv1", "agv2", "agv3"]),
        (["agv_{:02}"], 2, ["agv_01", "agv_02"]),
        (["r{:03d}_x"], 1, ["r001_x"]),
        (["ann", "bob"], 2, ["ann", "bob"]),
        (["ann", "agv{}"], 3, ["ann", "agv2", "agv3"]),
        (["solo"], 1, ["solo"]),
    ],
)
def test_patterns_and_lists(words, count, names):
    own = RobotNames.of(words, count, "--names")
    assert own.first(count) == names
    assert [own.number_of(name) for name in names] == list(range(1, count + 1))
    assert RobotNames.parse(str(own)) == own


@pytest.mark.parametrize(
    "name", ["agv", "agv0", "agv01", "agv70000", "agv-1", "AGV1", "agv1", "/agv5"]
)
def test_names_of_no_robot_have_no_number(name):
    names = RobotNames.of(["ann", "agv{}"], 2, "--names")
    assert names.number_of(name) == 0  # agv1 would be the first robot, which is called ann
    assert names.number_of(f"agv{MOST}") == MOST


@pytest.mark.parametrize(
    ("words", "count", "message"),
    [
        (["agv"], 2, "as many names as robots, 2, but found 1"),
        (["ann", "bob"], 3, "robots, 3, but found 2"),
        (["ann", "bob", "ann"], 3, "two robots are called 'ann'"),
        (["agv{n}"], 2, "expected one field {}"),
        (["agv{:3}"], 2, "expected one field {}"),
        (["{}agv"], 2, "a letter first"),
        (["/agv{}"], 2, "no name for a robot"),
        (["agv-{}"], 2, "no name for a robot"),
        (["x" * 65], 1, "at most 64"),
        ([""], 1, "no name for a robot"),
        (["sim"], 1, "something else of a swarm is called sim"),
        (["map", "bob"], 2, "something else of a swarm is called map"),
    ],
)
def test_bad_names_are_one_error(words, count, message):
    with pytest.raises(ConfigError, match=r"^--names: ") as caught:
        RobotNames.of(words, count, "--names")
    assert message in str(caught.value)


def test_what_else_has_a_name_is_kept_free():
    topics = {topic.name.split("/")[1] for topic in WORLD_TOPICS}
    logs = {row.name for row in (*TABLE, *ROBOTS_TABLE)}
    assert topics | {ALL, MERGED, SWARM} <= RESERVED
    assert logs - {"rviz"} <= RESERVED  # the logs of its windows are called rviz_NAME


def test_nobody_else_builds_or_matches_names():
    built = re.compile(r"Srobot(?:\\d|\{|\(|[\"'])")
    files = [path for path in ROOT.glob("swarm_*/**/*.py") if built.search(path.read_text("utf-8"))]
    assert [path.name for path in files] == ["robot_names.py"]


def test_names_for_people():
    assert in_short(["agv1"]) == "agv1"
    assert in_short(["ann", "bob"]) == "ann and bob"
    assert in_short(["agv2", "agv3", "agv4"]) == "agv2 to agv4"
    assert in_short(["agv_08", "agv_09", "agv_10"]) == "agv_08 to agv_10"
    assert in_short(["agv2", "agv3", "agv5"]) == "agv2, agv3, agv5"
    assert in_short(["ann", "bob", "cem"]) == "ann, bob, cem"
    assert sorted(["agv10", "agv2", "ann"], key=natural) == ["agv2", "agv10", "ann"]
    assert RobotNames(("ann", "bob")).expected == "ann and bob, or Srobot3 to Srobot65535"
