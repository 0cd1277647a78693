"""Messages that are lost, doubled, late or out of order: an order is done once, to its end."""

import json
from enum import Enum

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fakes.fleet_orders import OF_2, Toy, action, header, node, order

LAST = 5  # node of the order


class Fault(Enum):
    NONE = "none"
    LOST = "lost"
    DOUBLED = "doubled"
    LATE = "late"


def update(number):
    """Return the order, or the update that adds a node to its base."""
    parts = range(number, LAST + 1)
    nodes = [
        node(k, *([action("wait", f"w{k}", duration=0.5)] if k else []), released=k <= number + 1)
        for k in parts
    ]
    return order(nodes, update=number)


class Network:
    """Delivers messages as well as it is let."""

    def __init__(self, toy, faults):
        self.toy, self.faults = toy, faults
        self.late: list[tuple[str, bytes]] = []
        self.is_late_due = False

    def send(self, topic, content):
        data = json.dumps(content).encode()
        match self.faults.pop(0) if self.faults else Fault.NONE:
            case Fault.NONE:
                self.deliver(topic, data)
            case Fault.DOUBLED:
                self.deliver(topic, data)
                self.deliver(topic, data)
            case Fault.LATE:
                self.late.append((topic, data))

    def deliver(self, topic, data):
        self.toy.vehicle.receive(self.toy.dialect.read(topic, data))

    def deliver_late(self):
        while self.late:
            self.deliver(*self.late.pop())  # the latest first


@settings(max_examples=60, deadline=None)
@given(
    faults=st.lists(st.sampled_from(Fault), max_size=40),
    hurries=st.lists(st.booleans(), max_size=40),
    pauses=st.sets(st.integers(0, 30)),
)
def test_an_order_is_done_once_whatever_the_network_does(faults, hurries, pauses):
    toy = Toy(OF_2)
    network = Network(toy, faults)
    vehicle, number = toy.vehicle, 0
    passed, ended = [vehicle.last_node[1]], []
    for turn in range(200):
        if turn in pauses:
            kinds = [action("startPause", f"p{turn}", "NONE"), action("stopPause", f"q{turn}")]
            network.send("instantActions", header() | {"actions": kinds})
        if vehicle.order_id == "A" and vehicle.order_update_id == number < LAST - 1:
            number += vehicle.wants_base or (bool(hurries) and hurries.pop())
        network.send("order", update(number))  # until the robot has it
        if turn % 3 == 2:
            network.deliver_late()
        toy.step()
        toy.wait(1.0)
        if vehicle.last_node[1] != passed[-1]:
            passed.append(vehicle.last_node[1])
        now = [name for name, status in toy.done.items() if name[0] == "w" and status == "FINISHED"]
        assert set(ended) <= set(now)
        ended += [name for name in now if name not in ended]
        if vehicle.last_node == (f"n{LAST}", 2 * LAST) and not vehicle.is_busy:
            break
    assert passed == list(range(0, 2 * LAST + 2, 2))
    assert ended == [f"w{k}" for k in range(1, LAST + 1)]
    assert not vehicle.is_paused
    network.deliver_late()
    toy.drive()
    assert vehicle.last_node == (f"n{LAST}", 2 * LAST)
    assert not vehicle.is_busy
