"""Random orders, updates and cancels: each decision is that of the standard's flow charts.

The decisions are those of an independent implementation, told the same order and state.
"""

import json

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from vda5050.domain.order.acceptance import AcceptanceDecision, OrderAcceptancePolicy
from vda5050.domain.sessions.vehicle_session import VehicleSession
from vda5050.identity import VehicleKey
from vda5050.model.order import Order as TheirOrder
from vda5050.model.state import State as TheirState

from tests.fakes.fleet_orders import SPACING, Toy, along

FINAL = ("FINISHED", "FAILED")
ACCEPTED = (AcceptanceDecision.ACCEPT_NEW, AcceptanceDecision.ACCEPT_UPDATE)
lengths = st.integers(0, 3)


class Orders(RuleBasedStateMachine):
    """A fleet control that sends what it likes, and a robot that drives when it is let."""

    def __init__(self):
        super().__init__()
        self.toy = Toy()
        self.accepted: dict | None = None  # latest order message
        self.used: set[str] = set()
        self.cancelled = ""
        self.count = 0
        self.traversed: list[tuple[str, int]] = []
        self.final: dict[tuple[str, str], str] = {}

    def send(self, content):
        toy, vehicle = self.toy, self.toy.vehicle
        before = (vehicle.order_id, vehicle.order_update_id, vehicle.node_states)
        session = VehicleSession(VehicleKey("swarm", "Srobot1"))
        state = json.loads(toy.dialect.write("state", toy.state()))
        position = {"x": toy.pose.x, "y": 0.0, "theta": 0.0, "mapId": "hall"}
        state["agvPosition"] = position | {"positionInitialized": True}
        session.apply_state(TheirState.model_validate(state))
        if self.accepted is not None:
            session.apply_order(TheirOrder.model_validate(self.accepted))
        theirs = OrderAcceptancePolicy().evaluate(TheirOrder.model_validate(content), session)
        expected = theirs.decision in ACCEPTED
        is_cancelled = content["orderId"] == self.cancelled == vehicle.order_id
        is_used = content["orderId"] != vehicle.order_id and content["orderId"] in self.used
        errors = len(vehicle.errors)
        toy.send(content)
        after = (vehicle.order_id, vehicle.order_update_id, vehicle.node_states)
        if expected and not is_cancelled and not is_used:
            assert after[:2] == (content["orderId"], content["orderUpdateId"]), toy.faults
            assert not toy.faults
            self.accepted = content
            self.used.add(content["orderId"])
            self.note_traversal()
        else:
            assert after == before
            is_same = theirs.decision is AcceptanceDecision.IGNORE_DUPLICATE
            assert is_same or toy.faults, (theirs, errors)

    def note_traversal(self):
        vehicle = self.toy.vehicle
        key = (vehicle.order_id, vehicle.last_node[1])
        if not self.traversed or self.traversed[-1] != key:
            self.traversed.append(key)

    @rule(base=lengths, horizon=lengths, shift=st.sampled_from([0, 0, 0, 1]))
    def new_order(self, base, horizon, shift):
        self.count += 1
        first = round(self.toy.pose.x / SPACING) + shift
        content = along(first, first + base, first + base + horizon, f"o{self.count}")
        for each in content["nodes"]:  # their reading of no deviation is 0
            each["nodePosition"]["allowedDeviationXY"] = 0.7
        self.send(content)

    @rule(
        skip=st.integers(-1, 2), base=lengths, horizon=lengths, step=st.sampled_from([1, 1, 0, -1])
    )
    def update(self, skip, base, horizon, step):
        if self.accepted is None:
            return
        nodes = self.accepted["nodes"]
        end = max(each["sequenceId"] for each in nodes if each["released"]) // 2
        first = max(end + (skip if skip != 2 else 0), 0)
        order_id, number = self.accepted["orderId"], self.accepted["orderUpdateId"] + step
        if number < 0:
            return
        self.send(along(first, first + base, first + base + horizon, order_id, number))

    @rule()
    def repeat(self):
        if self.accepted is not None:
            self.send(self.accepted)

    @rule(data=st.data())
    def old_order(self, data):
        first = round(self.toy.pose.x / SPACING)
        if old := sorted(self.used - {self.toy.vehicle.order_id}):
            content = along(first, first + 1, first + 1, data.draw(st.sampled_from(old)))
            for each in content["nodes"]:
                each["nodePosition"]["allowedDeviationXY"] = 0.7
            self.send(content)

    @rule()
    def drive(self):
        for _ in range(3):
            if self.toy.step():
                self.note_traversal()

    @rule(is_standing=st.booleans())
    def cancel(self, is_standing):
        toy, vehicle = self.toy, self.toy.vehicle
        self.count += 1
        was_busy, order_id = vehicle.is_busy, vehicle.order_id
        toy.sense(is_standing=is_standing)
        toy.do("cancelOrder", f"c{self.count}")
        if was_busy:
            self.cancelled = order_id
            assert vehicle.leg is None
            toy.wait(0.1)
            assert vehicle.node_states == vehicle.edge_states == ()
            assert toy.done[f"c{self.count}"] == "FINISHED"
        else:
            assert toy.done[f"c{self.count}"] == "FAILED"
            assert "NO_ORDER" in toy.faults
        toy.do("stateRequest", f"s{self.count}")

    @invariant()
    def is_consistent(self):
        vehicle = self.toy.vehicle
        nodes, edges = vehicle.node_states, vehicle.edge_states
        assert len(nodes) == len(edges)
        for each, way in zip(nodes, edges, strict=True):
            assert (way.sequence_id, way.released) == (each.sequence_id - 1, each.released)
        numbers = [each.sequence_id for each in nodes]
        assert numbers == sorted(set(numbers))
        assert not nodes or numbers[0] == vehicle.last_node[1] + 2
        assert [n.released for n in nodes] == sorted((n.released for n in nodes), reverse=True)
        if (leg := vehicle.leg) is not None:
            assert all(each.released for each in leg.nodes)
        assert len(self.traversed) == len(set(self.traversed))


TestOrders = Orders.TestCase
TestOrders.settings = settings(
    max_examples=200, stateful_step_count=30, deadline=None,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
