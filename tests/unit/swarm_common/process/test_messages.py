"""Messages between swarm-up and its processes: what is known passes, what is not is named."""

import os
import typing

import pytest

from swarm_common.process import messages as say
from swarm_common.process.messages import UnknownMessageError, decode, encode
from swarm_common.process.pipes import EventWriter, MessageReader

COMMANDS = (
    say.ForkServerCommand
    | say.WorldCommand
    | say.MissionCommand
    | say.ServerCommand
    | say.ClientCommand
    | say.RestartNavigator
    | say.KernelsCompiled
)


def kinds_of(base):
    known = set()
    for kind in base.__subclasses__():
        below = kinds_of(kind)
        known |= below or {kind}
    return known


def test_every_kind_of_message_belongs_to_a_union_that_somebody_decodes():
    assert kinds_of(say.EventBase) == set(typing.get_args(say.Event))
    assert kinds_of(say.CommandBase) == set(typing.get_args(COMMANDS))


@pytest.mark.parametrize(
    "event",
    [
        say.WorldProgress(4.0, 2.0, say.CollisionCounts(1, 2)),
        say.CollisionBegan(say.Collision(("Srobot1",), "wall", 1.0, 2.0, 3.0)),
        say.GoalMissed(say.MissedGoal("Srobot1", "loader_3", 4.0, "error 208")),
    ],
)
def test_an_event_passes_through_a_line(event):
    assert decode(encode(event), say.EVENTS) == event


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (b'{"event":"exploded"}', "exploded"),
        (b'{"event":"active"}', "robot"),
        (b'{"cmd":"go"}', "missing required field `event`"),
        (b"Traceback (most recent call last):", "Traceback"),
    ],
)
def test_a_line_that_is_no_known_event_is_an_error_that_names_it(line, words):
    with pytest.raises(UnknownMessageError, match="unknown message") as caught:
        decode(line, say.EVENTS)
    assert words in str(caught.value)


def test_half_a_line_waits_for_its_other_half():
    read_end, write_end = os.pipe()
    reader = MessageReader(read_end, say.EVENTS)
    os.write(write_end, b'{"event": "ready"}\n{"eve')
    assert reader.read() == [say.Ready()]
    os.write(write_end, b'nt": "alive"}\n\n')
    EventWriter(write_end).write(say.Note("x"))
    assert reader.read() == [say.Alive(), say.Note("x")]
    os.close(write_end)
    assert reader.read() == []
    os.close(read_end)
