"""Options of `swarm-replay`: what does not fit together is refused before anything is played."""

import contextlib

import pytest

from swarm_common.model.errors import ConfigError
from swarm_recording.bag import Bag
from swarm_recording.filter import PlayOptions, played, topics_to_play
from swarm_view import replay_command
from tests.unit.swarm_recording.bags import NOTE, OTHER, cdr, notes, split_bag, write

MESSAGES = notes(40, (NOTE, OTHER))


@pytest.fixture
def bag(tmp_path):
    return split_bag(tmp_path / "bag", [MESSAGES[:9], MESSAGES[9:]])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"topics": NOTE}, "--topics needs --ros"),
        ({"offset": 1.0}, "--offset needs --ros"),
        ({"clock": 40.0}, "--clock needs --ros"),
        ({"loop": True}, "--loop needs --ros; in the viewer"),
        ({"ros": True, "start": 101.0, "offset": 1.0}, "give one"),
        ({"ros": True, "offset": 4.5}, "--offset is 4.5 s; the recording goes from 100.0 to 103.9"),
        ({"ros": True, "offset": -1.0}, "must not be negative"),
        ({"ros": True, "offset": float("nan")}, "must not be negative"),
        ({"ros": True, "clock": 0.0}, "the clock's rate is 0.0 Hz"),
        ({"ros": True, "start": 99.0}, "--start is 99.0 s"),
    ],
)
def test_options_that_do_not_fit(bag, options, message):
    with pytest.raises(ConfigError, match=message):
        replay_command.replay(bag, **options)


def test_a_gap_of_decades_is_named_with_how_to_skip_it(tmp_path, capsys):
    """Playing waited for 54 years in silence."""
    times = (1.0, 1.5, 1_717_000_000.0, 1_717_000_004.5)
    write(tmp_path / "decades.mcap", [(NOTE, round(1e9 * time), cdr("x")) for time in times])
    replay_command.replay(tmp_path / "decades.mcap", info=True)
    told = "nothing from 1.5 to 1717000000.0 s, 54.4 years: --start 1717000000.000 begins after it"
    assert told in capsys.readouterr().out
    with contextlib.closing(Bag(tmp_path / "decades.mcap")) as bag:
        assert replay_command._gap_lines(bag, 0.0) == [told]
        assert replay_command._gap_lines(bag, times[2]) == []


def test_topics_are_chosen_and_those_that_are_not_there_are_told(bag):
    words: list[str] = []
    recording = Bag(bag)
    options = PlayOptions(topics=[OTHER, "/none"], clock_rate=40.0)
    assert topics_to_play(recording, options, words.append) == [OTHER]
    assert [line.rpartition(" ")[2] for line in words] == ["/none"]
    assert played(recording, options) == {OTHER, "/clock"}
    assert played(recording, PlayOptions()) == {NOTE, OTHER}
    with pytest.raises(ConfigError, match=f"it has {NOTE}, {OTHER}"):
        topics_to_play(recording, PlayOptions(topics=["/none"]), words.append)
    recording.close()
