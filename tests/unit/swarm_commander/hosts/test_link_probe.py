"""What lies between two hosts: each kind of fault gets its own words."""

import random

import pytest

from swarm_commander.hosts.link_probe import NOTHING, SIZES, SMALL, WHOLE, Answerer, Asker

SECRET = "a secret of this swarm"


def talk(there, back, rounds=20):
    """Let both sides talk over a network that passes some datagrams."""
    asker, answerer, now = Asker(SECRET, "abc"), Answerer(SECRET), 0.0
    for _ in range(rounds):
        for question in asker.questions(now):
            answer = answerer.answer(question, "10.0.0.2") if there(question) else None
            if answer is not None and back(answer):
                asker.take(answer, now + 0.004)
        now += 1.0
    return asker, answerer, now + 2.0


def everything(_):
    return True


def nothing(_):
    return False


@pytest.mark.parametrize("way", ["there", "back"])
@pytest.mark.parametrize(
    ("passes", "found", "words"),
    [
        (nothing, NOTHING, "in one direction or both"),
        (lambda data: len(data) < WHOLE, "mtu", "ip link set DEVICE mtu"),
        (lambda data: len(data) <= WHOLE, "fragments", "a firewall on the way drops them"),
    ],
)
def test_a_fault_in_either_direction(way, passes, found, words):
    ways = (passes, everything) if way == "there" else (everything, passes)
    asker, _, now = talk(*ways)
    assert asker.finding(now)[0] == found
    assert words in asker.finding(now)[1]


def test_who_is_heard_but_does_not_hear_is_told_of_once():
    _, answerer, _ = talk(everything, nothing)
    assert answerer.deaf() == ["10.0.0.2"]
    assert answerer.deaf() == []
    for ways in ((everything, everything), (nothing, everything)):
        assert talk(*ways)[1].deaf() == []


def test_a_sound_network_and_one_of_which_little_is_known():
    asker, _, now = talk(everything, everything)
    assert asker.finding(now) == ("", "")
    figures = asker.figures(now)
    assert {figures[f"share_{size}_bytes"] for size in SIZES} == {1.0}
    assert figures["round_trip_ms"] == pytest.approx(4.0)
    asker, _, now = talk(nothing, nothing, rounds=3)
    assert asker.finding(now) == ("", "")
    asker, _, now = talk(nothing, nothing)
    asker.restart()
    assert asker.finding(now) == ("", "")
    assert len(asker.questions(now)) == 3


def test_losses_are_told_of_from_where_they_hurt():
    dice = random.Random(1)
    asker, _, now = talk(lambda _: dice.random() > 0.1, everything, rounds=200)
    assert asker.finding(now)[0] == "loss"
    asker, _, now = talk(lambda _: dice.random() > 0.005, everything, rounds=200)
    assert asker.finding(now) == ("", "")


@pytest.mark.parametrize("silence", [False, True])
def test_questions_before_the_world_is_there_are_not_lost(silence):
    """A host that was started before the world said that 82 % of the packets get lost."""
    asker, now = Asker(SECRET, "abc"), 0.0
    answerer = Answerer(SECRET)
    for number in range(120):
        if silence and number == 60:
            asker.restart()
        is_there = number > 40 and not (silence and 57 <= number < 90)
        for question in asker.questions(now):
            answer = answerer.answer(question, "10.0.0.2")
            if answer is not None and is_there:
                asker.take(answer, now + 0.004)
        now += 1.0
        assert asker.finding(now)[0] in {"", NOTHING}
    shares = [value for name, value in asker.figures(now).items() if name.startswith("share")]
    assert shares == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("seed", range(20))
def test_few_lost_packets_are_no_bad_link(seed):
    """One lost answer of five is no loss of 20 %, nor is 1 % in each direction a bad link."""
    dice = random.Random(seed)
    asker, answerer = Asker(SECRET, "abc"), Answerer(SECRET)
    for now in range(400):
        for question in asker.questions(now):
            answer = answerer.answer(question, "10.0.0.2")
            if answer is not None and dice.random() > 0.02:
                asker.take(answer, now + 0.004)
        assert asker.finding(now + 0.5) == ("", "")


def test_where_most_is_lost_the_size_is_not_blamed():
    asker, now = Asker(SECRET, "abc"), 0.0
    for number in range(24):
        for size, question in zip(SIZES, asker.questions(now), strict=True):
            answer = Answerer(SECRET).answer(question, "10.0.0.2")
            if answer is not None and size == SMALL and number % 3 == 0:
                asker.take(answer, now + 0.004)
        now += 1.0
        assert asker.finding(now)[0] in {"", "loss"} or number > 12
    assert asker.finding(now + 2.0)[0] == "mtu"


def test_a_late_large_packet_is_no_missing_one():
    """What was asked within the last seconds may still be answered."""
    asker, now = Asker(SECRET, "abc"), 0.0
    for _ in range(5):
        for size, question in zip(SIZES, asker.questions(now), strict=True):
            answer = Answerer(SECRET).answer(question, "10.0.0.2")
            if answer is not None and size == SMALL:
                asker.take(answer, now + 0.004)
        now += 1.0
    assert asker.finding(now) == ("", "")
    assert asker.finding(now + 2.0)[0] == "mtu"


def test_nobody_is_answered_without_the_secret_nor_at_greater_length():
    question = Asker(SECRET, "abc").questions(0.0)[0]
    answer = Answerer(SECRET).answer(question, "10.0.0.2")
    assert answer is not None
    assert len(answer) == len(question)
    assert Answerer("another").answer(question, "10.0.0.2") is None
    assert Answerer(SECRET).answer(answer, "10.0.0.2") is None  # no endless exchange
    for size in range(len(question)):
        assert Answerer(SECRET).answer(question[:size], "10.0.0.2") is None
