"""Every element of a metadata.yaml counts: what is done to one is in the result, or is told."""

import copy
from contextlib import closing

import pytest
import yaml

from swarm_common.middleware.topic_table import WORLD_TOPICS
from swarm_common.model.errors import ConfigError
from swarm_recording.bag import Bag
from swarm_recording.bag_metadata import read_metadata
from swarm_recording.tape import Tape
from tests.unit.swarm_recording.bags import NOTE, OTHER, metadata, notes, split_bag

ALL = notes(20, (NOTE, OTHER))
NAMES = ["part_0.mcap", "part_1.mcap"]
TREE = {"rosbag2_bagfile_information": metadata(NAMES, ALL)}
TREE["rosbag2_bagfile_information"]["custom_data"] = None


def read(tmp_path, text):
    path = tmp_path / "metadata.yaml"
    path.write_text(text)
    words: list[str] = []
    try:
        return read_metadata(path, words.append), words
    except ConfigError as error:
        return None, [str(error)]


def places(tree, at=()):
    parts = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in parts:
        yield (*at, key)
        if isinstance(value, dict | list):
            yield from places(value, (*at, key))


def parent(tree, place):
    for key in place[:-1]:
        tree = tree[key]
    return tree


KEYS = [place for place in places(TREE) if isinstance(place[-1], str)]
ENTRIES = [place for place in places(TREE) if isinstance(place[-1], int)]


def test_metadata_is_understood_whole(tmp_path):
    found, words = read(tmp_path, yaml.safe_dump(TREE))
    assert words == []
    assert found.files == tuple(NAMES)
    assert (found.message_count, found.counts) == (20, {NOTE: 10, OTHER: 10})
    tape = Tape(tmp_path / "recording.mcap", {})
    tape.add_topic(WORLD_TOPICS[0])
    tape.write(WORLD_TOPICS[0].name, 7, b"\0\1\0\0" + bytes(8))
    tape.close()
    found, words = read(tmp_path, (tmp_path / "metadata.yaml").read_text())
    assert words == []
    assert found.files == ("recording.mcap",)


@pytest.mark.parametrize("place", KEYS, ids=str)
def test_a_key_renamed_or_twice_is_told(tmp_path, place):
    tree = copy.deepcopy(TREE)
    holder = parent(tree, place)
    holder[f"{place[-1]}s"] = holder.pop(place[-1])
    _, words = read(tmp_path, yaml.safe_dump(tree))
    assert any(place[-1] in line for line in words)
    tree = copy.deepcopy(TREE)
    holder = parent(tree, place)
    holder["TWIN"] = holder[place[-1]]
    text = yaml.safe_dump(tree, sort_keys=False).replace("TWIN:", f"{place[-1]}:")
    found, words = read(tmp_path, text)
    assert found is None
    assert "twice" in words[0]


@pytest.mark.parametrize("place", KEYS, ids=str)
def test_a_key_at_another_place_is_told(tmp_path, place):
    """Moved one level up, and into the first mapping beside it."""
    for is_up in (True, False):
        tree = copy.deepcopy(TREE)
        holder = parent(tree, place)
        value = holder.pop(place[-1])
        if is_up:
            above = [parent(tree, place[:k]) for k in range(len(place) - 1, 0, -1)]
            target = next((holder for holder in above if isinstance(holder, dict)), None)
        else:
            target = next((v for v in holder.values() if isinstance(v, dict)), None)
        if target is None or place[-1] in target:
            continue
        target[place[-1]] = value
        found, words = read(tmp_path, yaml.safe_dump(tree))
        assert any(place[-1] in line for line in words), (found, is_up)


@pytest.mark.parametrize("place", ENTRIES, ids=str)
def test_an_entry_of_a_list_that_is_doubled_or_moved_matters(tmp_path, place):
    whole, _ = read(tmp_path, yaml.safe_dump(TREE))
    doubled = copy.deepcopy(TREE)
    parent(doubled, place).append(parent(doubled, place)[place[-1]])
    _, words = read(tmp_path, yaml.dump(doubled, Dumper=yaml.SafeDumper))
    assert any("twice" in line for line in words)
    moved = copy.deepcopy(TREE)
    parent(moved, place).reverse()
    found, words = read(tmp_path, yaml.safe_dump(moved))
    is_order = "relative_file_paths" in place
    assert (found != whole) == is_order or words
    gone = copy.deepcopy(TREE)
    del parent(gone, place)[place[-1]]
    found, words = read(tmp_path, yaml.safe_dump(gone))
    assert found != whole or words


@pytest.mark.parametrize("place", KEYS, ids=str)
@pytest.mark.parametrize("value", ["x", 7, True, [], {"a": 1}, None], ids=str)
def test_a_value_of_another_type_is_told(tmp_path, place, value):
    tree = copy.deepcopy(TREE)
    was = parent(tree, place)[place[-1]]
    parent(tree, place)[place[-1]] = value
    is_same = type(was) is type(value)
    if place[-1] in ("custom_data", "offered_qos_profiles") or is_same:
        return
    _, words = read(tmp_path, yaml.safe_dump(tree))
    assert words


def test_counts_that_differ_are_told_by_topic(tmp_path):
    folder = split_bag(tmp_path / "bag", [ALL[:10], ALL[10:]])
    text = (folder / "metadata.yaml").read_text()
    (folder / "metadata.yaml").write_text(text.replace("message_count: 10", "message_count: 11"))
    words: list[str] = []
    with closing(Bag(folder, words.append)):
        assert len(words) == 1
    assert f"{NOTE}: 10 of 11" in words[0]
