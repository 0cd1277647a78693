"""`ros2 bag`: what it tells of bags, and which of rosbag2's options it has."""

import pytest

from swarm_ros2 import bag as verbs
from swarm_ros2 import command_line, launcher
from tests.unit.swarm_recording.bags import NOTE, OTHER, notes, split_bag, write


@pytest.fixture
def started(monkeypatch):
    calls: list[list[str]] = []
    monkeypatch.setattr(launcher, "start", lambda program, words: calls.append(words))
    return calls


def test_info_of_a_split_bag(tmp_path, capsys):
    messages = notes(40, (NOTE, OTHER))
    folder = split_bag(tmp_path / "bag", [messages[:15], messages[15:]])
    (folder / "part_1.mcap").rename(folder / "renamed.mcap")
    assert command_line.run(["bag", "info", str(folder)]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert lines[0] == "Files:             part_0.mcap"
    assert lines[1] == "                   renamed.mcap"
    size = sum(path.stat().st_size for path in folder.glob("*.mcap"))
    assert f"Bag size:          {size / 1024:.1f} KiB" in lines
    assert "Duration:          3.900000000s" in lines
    assert "Messages:          40" in lines
    assert sum("Count: 20 |" in line for line in lines) == 2
    assert err.startswith("WARNING: ")
    assert "renamed.mcap" in err
    assert command_line.run(["bag", "info", "-t", str(folder)]) == 0
    assert capsys.readouterr().out.split() == [NOTE, OTHER]


def test_info_of_nothing(tmp_path, capsys):
    assert command_line.run(["bag", "info", str(tmp_path)]) == 1
    assert "there is no bag" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], ["--speed", "1.0"]),
        (["--rate", "2.5", "--loop"], ["--speed", "2.5", "--loop"]),
        (["-r", "2", "-l"], ["--speed", "2.0", "--loop"]),
        (["--start-offset", "3.25"], ["--speed", "1.0", "--offset", "3.25"]),
        (["--clock"], ["--speed", "1.0", "--clock", "40.0"]),
        (["--clock", "10"], ["--speed", "1.0", "--clock", "10.0"]),
        (["--topics", "/a", "b/c"], ["--speed", "1.0", "--topics", "/a,/b/c"]),
        (["-s", "mcap", "--disable-keyboard-controls"], ["--speed", "1.0"]),
        (["--read-ahead-queue-size", "100"], ["--speed", "1.0"]),
    ],
)
def test_options_of_play(started, words, expected):
    assert command_line.run(["bag", "play", "b", *words]) == 0
    assert started == [["b", "--ros", *expected]]


@pytest.mark.parametrize("verb", ["play", "record", "info"])
def test_options_that_are_not_here_end_in_one_error(started, capsys, verb):
    missing = {"play": verbs.NOT_OF_PLAY, "record": verbs.NOT_OF_RECORD, "info": ("-v", "--sort")}[
        verb
    ]
    for name in (word for names in missing for word in names.split()):
        for words in ([], ["a:=b"]):
            with pytest.raises(SystemExit) as end:
                command_line.run(["bag", verb, "b", name, *words])
            assert end.value.code == 2
            error = capsys.readouterr().err.splitlines()[-1]
            assert f"{name} is an option of ROS 2's own 'ros2 bag'" in error
    assert started == []


@pytest.mark.parametrize(
    "words",
    [
        ["play", "b", "--rate", "0"],
        ["play", "b", "--rate", "nan"],
        ["play", "b", "--rate", "fast"],
        ["play", "b", "--start-offset", "-1"],
        ["play", "b", "--clock", "0"],
        ["play", "b", "-s", "sqlite3"],
        ["record", "-a", "-s", "sqlite3"],
        ["play", "b", "--nonsense"],
    ],
)
def test_wrong_values_are_refused(capsys, words):
    with pytest.raises(SystemExit, match="2"):
        command_line.run(["bag", *words])
    assert words[-2].lstrip("b") in capsys.readouterr().err


def test_record_wants_topics_and_an_empty_folder(tmp_path, capsys):
    assert command_line.run(["bag", "record"]) == 1
    assert "--all" in capsys.readouterr().err
    write(tmp_path / "a.mcap", notes(1))
    for place in (tmp_path, tmp_path / "a.mcap"):
        assert command_line.run(["bag", "record", "-a", "-o", str(place)]) == 1
        assert f"{place} is there already" in capsys.readouterr().err
