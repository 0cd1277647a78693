"""Bags of other people: split, compressed, cut, renamed; nothing is left out without a word."""

import itertools
import resource
import shutil
import sqlite3
from contextlib import closing

import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from swarm_common.model.errors import ConfigError
from swarm_recording.bag import Bag
from swarm_recording.bag_feed import BagFeed
from tests.unit.swarm_recording.bags import (
    NOTE,
    OTHER,
    STRING,
    Message,
    cdr,
    metadata,
    notes,
    split_bag,
    write,
    write_metadata,
)

ALL = notes(120)
PARTS = [ALL[k : k + 10] for k in range(0, 120, 10)]


def read(path):
    words: list[str] = []
    with closing(Bag(path, words.append)) as bag:
        return [tuple(item) for item in bag.messages()], words


def test_all_files_of_a_bag_are_read_in_order(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    assert read(folder) == (ALL, [])
    assert read(folder / "metadata.yaml") == (ALL, [])
    with closing(Bag(folder)) as bag:
        assert [file.name for file in bag.files] == [f"part_{k}.mcap" for k in range(12)]
        assert bag.counts == {NOTE: 120}
        assert (bag.first, bag.last) == (ALL[0][1], ALL[-1][1])
        assert list(bag.messages(after=ALL[34][1])) == ALL[35:]
        assert bag.latest([NOTE], ALL[57][1] + 1) == [ALL[57]]


def test_one_file_of_several_is_played_alone_and_that_is_told(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    messages, (words,) = read(folder / "part_3.mcap")
    assert messages == PARTS[3]
    assert f"one of 12 files of a bag; all of them: {folder}" in words


def test_without_metadata_the_numbers_say_the_order(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    (folder / "metadata.yaml").unlink()
    messages, (words,) = read(folder)
    assert messages == ALL
    assert "no metadata.yaml" in words
    with closing(Bag(folder)) as bag:
        assert bag.files[2].name == "part_2.mcap"
        assert bag.files[10].name == "part_10.mcap"
    write(folder / "another.mcap", ALL)
    with pytest.raises(ConfigError, match=r"(?s)another\.mcap.*name one of them"):
        Bag(folder)


def test_metadata_that_cannot_be_read_is_told(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: [")
    messages, words = read(folder)
    assert messages == ALL
    assert "metadata.yaml" in words[0]


def test_a_missing_file_is_named(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    (folder / "part_4.mcap").unlink()
    messages, words = read(folder)
    assert messages == ALL[:40] + ALL[50:]
    assert any("part_4.mcap" in line for line in words)
    assert any("110 messages" in line and "120" in line for line in words)
    for path in folder.glob("*.mcap"):
        path.unlink()
    with pytest.raises(ConfigError, match="not there"):
        Bag(folder)


def test_renamed_files_are_found(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    for index in range(12):
        (folder / f"part_{index}.mcap").rename(folder / f"new_{index}.mcap")
    messages, (words,) = read(folder)
    assert messages == ALL
    assert "part_0.mcap" in words
    assert "new_0.mcap" in words


def test_paths_with_the_name_of_the_folder_are_found(tmp_path):
    """Old versions of rosbag2 wrote them, and the folder may have another name now."""
    folder = split_bag(tmp_path / "bag", PARTS[:2])
    names = ["old_name/part_0.mcap", "/home/somebody/old_name/part_1.mcap"]
    content = metadata(names, ALL[:20]) | {"version": 2}
    del content["files"]
    write_metadata(folder, content)
    assert read(folder) == (ALL[:20], [])


def test_a_file_that_is_not_listed_is_told(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    shutil.copy(folder / "part_3.mcap", folder / "copy of part_3.mcap")
    messages, (words,) = read(folder)
    assert messages == ALL
    assert "copy of part_3.mcap: not read" in words


def test_an_unreadable_or_empty_file_does_not_hide_the_others(tmp_path):
    folder = split_bag(tmp_path / "bag", [*PARTS, []])
    assert read(folder) == (ALL, [])
    (folder / "part_5.mcap").write_bytes(b"")
    messages, words = read(folder)
    assert messages == ALL[:50] + ALL[60:]
    assert any("part_5.mcap" in line for line in words)


def test_files_that_overlap_are_merged_by_time(tmp_path):
    messages = notes(60, (NOTE, OTHER))
    folder = split_bag(tmp_path / "bag", [messages[::2], messages[1::2]])
    assert read(folder) == (messages, [])
    with closing(Bag(folder)) as bag:
        assert bag.latest([NOTE, OTHER], messages[31][1]) == messages[30:32]
    parts: list[list[Message]] = [[], [], [], []]
    for k, message in enumerate(ALL):
        parts[(k * k) % 4 if k % 7 else 3].append(message)
    assert read(split_bag(tmp_path / "bag", parts))[0] == ALL


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.data())
def test_any_split_gives_the_same_sequence(tmp_path, data):
    times = sorted(data.draw(st.lists(st.integers(0, 30), min_size=1, max_size=40)))
    messages = [(NOTE, time, cdr(f"{k}")) for k, time in enumerate(times)]
    cuts = sorted(data.draw(st.lists(st.integers(0, len(times)), max_size=5)))
    edges = [0, *cuts, len(times)]
    parts = [messages[a:b] for a, b in itertools.pairwise(edges)]
    folder = split_bag(tmp_path / "bag", parts)
    try:
        assert read(folder) == (messages, [])
        after = data.draw(st.integers(0, 30))
        with closing(Bag(folder)) as bag:
            assert list(bag.messages(after=after)) == [m for m in messages if m[1] > after]
            last = [m for m in messages if m[1] <= after][-1:]
            assert bag.latest([NOTE], after) == last
    finally:
        shutil.rmtree(folder)


def test_a_bag_may_have_more_files_than_a_process_may_open(tmp_path):
    folder = split_bag(tmp_path / "bag", [[message] for message in ALL])
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (80, hard))
    try:
        assert read(folder) == (ALL, [])
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_a_feed_jumps_over_files_and_scans_all(tmp_path):
    now = [0.0]
    with closing(BagFeed(split_bag(tmp_path / "bag", PARTS), lambda: now[0])) as feed:
        feed.want([NOTE])
        feed.take()
        feed.play()
        seen = 1
        for _ in range(119):
            now[0] += 0.1
            seen += len(feed.take())
            feed.want([])  # reads around the running stream
            feed.want([NOTE])
            feed.take()
        assert [data for _, data in feed.scan([NOTE])] == [data for _, _, data in ALL]
        feed.seek(105.05)
        assert feed.take() == [(NOTE, ALL[50][2])]
    assert seen > 100


@pytest.mark.parametrize("compression", list(CompressionType))
def test_chunks_may_be_compressed(tmp_path, compression):
    path = write(tmp_path / "a.mcap", ALL, compression=compression)
    assert read(path) == (ALL, [])


@pytest.mark.parametrize(
    "without",
    [
        {"use_chunking": False},
        {"index_types": IndexType.NONE},
        {"use_statistics": False},
        {"use_summary_offsets": False, "repeat_channels": False, "repeat_schemas": False},
        {"enable_crcs": False},
    ],
)
def test_what_a_file_lacks_of_its_index_loses_no_message(tmp_path, without):
    path = write(tmp_path / "a.mcap", ALL, **without)  # type: ignore[arg-type]
    assert read(path) == (ALL, [])


@pytest.mark.parametrize("end", [".zstd", ".zst"])
def test_compressed_files_are_read(tmp_path, end):
    folder = split_bag(tmp_path / "bag", PARTS)
    names = []
    for index in range(12):
        path = folder / f"part_{index}.mcap"
        names.append(path.name + end)
        (folder / names[-1]).write_bytes(zstandard.compress(path.read_bytes()))
        path.unlink()
    content = metadata(names, ALL)
    content |= {"compression_format": "zstd", "compression_mode": "FILE"}
    write_metadata(folder, content)
    assert read(folder) == (ALL, [])
    assert read(folder / names[0])[0] == PARTS[0]
    (folder / names[0]).write_bytes(zstandard.compress(b"nothing of the kind" * 9))
    with pytest.raises(ConfigError, match="something else than MCAP"):
        Bag(folder / names[0])


def test_compressed_files_are_read_to_their_cut(tmp_path):
    many = notes(20_000)
    path = write(tmp_path / "a.mcap", many, chunk_size=4096, compression=CompressionType.NONE)
    packed = zstandard.compress(path.read_bytes())
    (tmp_path / "b.mcap.zstd").write_bytes(packed[: len(packed) * 2 // 3])
    messages, (words,) = read(tmp_path / "b.mcap.zstd")
    assert 0 < len(messages) < 20_000
    assert messages == many[: len(messages)]
    assert f"{len(messages)} messages up to" in words
    packed = [(topic, time, zstandard.compress(data)) for topic, time, data in ALL]
    assert read(write(tmp_path / "a.mcap", packed)) == (ALL, [])


@pytest.mark.parametrize(
    "mode", [CompressionMode.NONE, CompressionMode.FILE, CompressionMode.MESSAGE]
)
def test_bags_of_rosbags_are_read(tmp_path, mode):
    writer = RosbagsWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP)
    if mode is not CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        store = get_typestore(Stores.ROS2_JAZZY)
        link = writer.add_connection(NOTE, STRING, typestore=store)
        for _, time, data in ALL:
            writer.write(link, time, data)
    assert read(tmp_path / "bag") == (ALL, [])


def test_a_file_whose_recorder_was_killed_is_read_as_far_as_it_goes(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS[:-1])
    write(folder / "part_11.mcap", PARTS[-1][:6], end=False)
    write_metadata(folder, metadata([f"part_{k}.mcap" for k in range(12)], ALL[:116]))
    messages, (words,) = read(folder)
    assert messages == ALL[:116]
    assert "part_11.mcap has no end" in words
    assert "6 messages up to 111.500 s" in words


def test_bags_of_other_storages_say_how_they_are_converted(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    with closing(sqlite3.connect(folder / "bag_0.db3")) as base:
        base.execute("create table messages(id)")
    for path in (folder, folder / "bag_0.db3"):
        with pytest.raises(ConfigError, match=r"sqlite3.*rosbags-convert --src .*bag"):
            Bag(path)
    (folder / "bag_0.db3").rename(folder / "bag_0.mcap")
    with pytest.raises(ConfigError, match=r"sqlite3"):
        Bag(folder)
    (tmp_path / "x.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(99))
    with pytest.raises(ConfigError, match=r"ROS 1.*rosbags-convert"):
        Bag(tmp_path / "x.bag")


@pytest.mark.parametrize(
    ("quality", "expected"),
    [
        ("- {reliability: 2, durability: 2}", (False, False)),  # as Humble and Iron write it
        ("- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1", (True, True)),
        ("- {reliability: best_effort, durability: volatile}", (False, False)),
        (
            "- {reliability: best_effort, durability: volatile}\n"
            "- {reliability: reliable, durability: transient_local}",
            (True, True),
        ),
        ("", (True, False)),
    ],
)
def test_the_quality_of_every_version(tmp_path, quality, expected):
    with closing(Bag(write(tmp_path / "a.mcap", ALL, quality=quality))) as bag:
        topic = bag.topics[NOTE]
        assert (topic.is_reliable, topic.is_latched) == expected


def test_a_quality_that_is_not_understood_is_told_and_metadatas_counts(tmp_path):
    messages, (words,) = read(write(tmp_path / "a.mcap", ALL, quality="- reliability: sturdy"))
    assert messages == ALL
    assert NOTE in words
    assert "offered_qos_profiles" in words
    folder = split_bag(tmp_path / "bag", PARTS)
    content = metadata([f"part_{k}.mcap" for k in range(12)], ALL)
    content["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"] = (
        "- {history: 3, depth: 0, reliability: 2, durability: 2}"
    )
    write_metadata(folder, content)
    with closing(Bag(folder)) as bag:
        assert not bag.topics[NOTE].is_reliable


def test_several_broadcasters_of_static_transforms_all_stay(tmp_path):
    quality = "- {depth: 1, reliability: reliable, durability: transient_local}\n" * 3
    path = write(tmp_path / "a.mcap", ALL[:9], quality=quality)
    with closing(Bag(path)) as bag:
        assert bag.topics[NOTE].depth == 3
        assert bag.latest([NOTE], ALL[5][1]) == ALL[3:6]


def test_a_topic_of_two_types_is_told(tmp_path):
    folder = split_bag(tmp_path / "bag", PARTS)
    write(folder / "part_7.mcap", PARTS[7], kind="std_msgs/msg/Int32")
    messages, words = read(folder)
    assert messages == ALL[:70] + ALL[80:]
    assert any("std_msgs/msg/Int32" in line and "10 messages" in line for line in words)
