"""A goal gets there once and its end is heard, whatever messages are lost."""

import random
from itertools import pairwise

import pytest

from swarm_run.robots.delivery import (
    MOST_PATIENCE,
    PATIENCE,
    TASK_TIME,
    TRANSITIONS,
    Action,
    Delivery,
    DeliveryEvent,
    Phase,
)

SENSELESS = {
    (Phase.SENT, DeliveryEvent.RESULT),
    (Phase.SENT, DeliveryEvent.UNKNOWN),
}  # nothing was asked


@pytest.mark.parametrize("phase", Phase)
@pytest.mark.parametrize("event", DeliveryEvent)
def test_every_pair_is_in_the_table_or_refused(phase, event):
    delivery = Delivery(0.0)
    delivery.phase = phase
    if (phase, event) in SENSELESS:
        with pytest.raises(ValueError, match="cannot happen"):
            delivery.hear(event, 1.0)
    else:
        assert delivery.hear(event, 1.0) is TRANSITIONS[phase][event][1]
        assert delivery.phase is TRANSITIONS[phase][event][0]


def test_goals_are_asked_about_with_growing_patience():
    delivery = Delivery(0.0)
    assert delivery.hear(DeliveryEvent.ACCEPTANCE, 0.1) is Action.ASK
    assert delivery.look(TASK_TIME, is_busy=True) is Action.NOTHING
    delivery.hear(DeliveryEvent.RESULT, 20.0)
    assert delivery.phase is Phase.ENDED
    assert delivery.look(1e6, is_busy=False) is Action.NOTHING
    delivery = Delivery(0.0)
    delivery.hear(DeliveryEvent.ACCEPTANCE, 0.0)
    assert delivery.look(PATIENCE, is_busy=True) is Action.NOTHING
    assert delivery.look(PATIENCE, is_busy=False) is Action.ASK
    delivery = Delivery(0.0)
    times = [t for t in range(2000) if delivery.look(float(t), is_busy=False) is Action.ASK]
    gaps = [after - before for before, after in pairwise(times)]
    assert times[0] == PATIENCE
    assert gaps == sorted(gaps)
    assert gaps[-1] == MOST_PATIENCE
    delivery = Delivery(0.0)
    delivery.look(PATIENCE, is_busy=False)
    delivery.hear(DeliveryEvent.ACCEPTANCE, 4.0)
    assert delivery.hear(DeliveryEvent.UNKNOWN, 4.1, question=1) is Action.NOTHING
    assert delivery.phase is Phase.ACCEPTED
    delivery.hear(DeliveryEvent.UNKNOWN, 4.2, question=2)
    assert delivery.phase is Phase.ENDED, "the server was restarted"


class Server:
    """Knows each goal once, as rclpy's; what it sends and gets is lost or late at random."""

    def __init__(self, seed, loss, refuses):
        self.begun = 0
        self.has_ended = False
        self._rng = random.Random(seed)
        self._loss = loss
        self._refuses = refuses
        self._asked: list[int] = []
        self._mail: list[tuple[float, DeliveryEvent | Action, int]] = []

    def post(self, what, now, question=0):
        if self._rng.random() >= self._loss:
            self._mail.append((now + self._rng.choice((0.01, 0.5, 5.0)), what, question))

    def turn(self, now):
        """Take and give what is due."""
        due = sorted((m for m in self._mail if m[0] <= now), key=lambda m: m[0])
        self._mail = [m for m in self._mail if m[0] > now]
        heard: list[tuple[DeliveryEvent, int]] = []
        for _, what, question in due:
            if isinstance(what, DeliveryEvent):
                heard.append((what, question))
            elif what is Action.SEND:
                is_new = not self.begun and not self._refuses
                self.begun += is_new
                self.post(DeliveryEvent.ACCEPTANCE if is_new else DeliveryEvent.REFUSAL, now)
            elif not self.begun:
                self.post(DeliveryEvent.UNKNOWN, now, question)
            elif self.has_ended:
                self.post(DeliveryEvent.RESULT, now)
            else:
                self._asked.append(question)
        return heard

    def end(self, now):
        self.has_ended = True
        for question in self._asked:
            self.post(DeliveryEvent.RESULT, now, question)


@pytest.mark.parametrize("refuses", [False, True])
@pytest.mark.parametrize("seed", range(60))
def test_whatever_is_lost_the_goal_runs_once_and_its_end_is_heard(seed, refuses):
    server = Server(seed, loss=0.5, refuses=refuses)
    delivery = Delivery(0.0)
    server.post(Action.SEND, 0.0)
    last: DeliveryEvent | None = None
    now = 0.0
    while delivery.phase is not Phase.ENDED and now < 3000.0:
        now += 0.25
        for event, question in server.turn(now):
            last = event
            act(server, delivery.hear(event, now, question), now, delivery)
        is_busy = bool(server.begun) and not server.has_ended
        act(server, delivery.look(now, is_busy), now, delivery)
        if server.begun and now >= 40.0 and not server.has_ended:
            server.end(now)
    assert delivery.phase is Phase.ENDED
    assert server.begun == (0 if refuses else 1)
    assert last is DeliveryEvent.RESULT or refuses


def act(server, action, now, delivery):
    if action is not Action.NOTHING:
        server.post(action, now, delivery.question)
