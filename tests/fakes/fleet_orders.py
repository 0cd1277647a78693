"""Orders of VDA 5050 along a line of nodes, and a robot without a navigator that drives them."""

import json
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from typing import Any

import numpy as np

from swarm_common.model.records import Pose
from swarm_vda5050.dialect import MESSAGES, Dialect, Identity
from swarm_vda5050.faults import OrderRejectedError
from swarm_vda5050.messages import BatteryState, SafetyState, VehicleState
from swarm_vda5050.order_check import DrivingArea
from swarm_vda5050.reading import written
from swarm_vda5050.standard import VERSIONS
from swarm_vda5050.vehicle import RobotSenses, Vehicle

MAP = "hall"
EPOCH = datetime(2026, 1, 1, tzinfo=UTC)  # of simulated time
SPACING = 2.0  # [m] between nodes
OF_2 = Identity("swarm", "Srobot1", "2.1")
OF_20 = Identity("swarm", "Srobot1", "2.0")
OF_3 = Identity("swarm", "Srobot1", "3.0")


def action(kind: str, action_id: str, blocking: str = "HARD", **parameters: Any) -> dict[str, Any]:
    return {
        "actionType": kind,
        "actionId": action_id,
        "blockingType": blocking,
        "actionParameters": [{"key": k, "value": v} for k, v in parameters.items()],
    }


def node(
    number: int, *actions: Mapping[str, Any], released: bool = True, **place: Any
) -> dict[str, Any]:
    """Return the node that lies `number` steps along the line, unless `place` says else."""
    position = {"x": SPACING * number, "y": 0.0, "mapId": MAP} | place
    return {
        "nodeId": f"n{number}",
        "sequenceId": 2 * number,
        "released": released,
        "nodePosition": position,
        "actions": list(actions),
    }


def edge(number: int, *actions: Mapping[str, Any], released: bool = True) -> dict[str, Any]:
    """Return the edge from node `number` to the next."""
    return {
        "edgeId": f"e{number}",
        "sequenceId": 2 * number + 1,
        "released": released,
        "startNodeId": f"n{number}",
        "endNodeId": f"n{number + 1}",
        "actions": list(actions),
    }


def header(version: str = "2.1.0") -> dict[str, Any]:
    return {
        "headerId": 7,
        "timestamp": "2026-01-01T00:00:00.000Z",
        "version": version,
        "manufacturer": "swarm",
        "serialNumber": "Srobot1",
    }


def order(
    nodes: Iterable[Mapping[str, Any]], order_id: str = "A", update: int = 0
) -> dict[str, Any]:
    """Return an order along nodes of the line."""
    nodes = list(nodes)
    edges = [
        edge(each["sequenceId"] // 2, released=after["released"]) for each, after in pairwise(nodes)
    ]
    parts = {"orderId": order_id, "orderUpdateId": update, "nodes": nodes, "edges": edges}
    return header() | parts


def along(first: int, base: int, last: int, order_id: str = "A", update: int = 0) -> dict[str, Any]:
    nodes = [node(number, released=number <= base) for number in range(first, last + 1)]
    return order(nodes, order_id, update)


def nurbs(
    *points: tuple[float, ...], degree: int = 1, knots: Iterable[float] | None = None
) -> dict[str, Any]:
    """Return a trajectory; without knots it is a polyline."""
    names = ("x", "y", "weight")
    controls = [dict(zip(names, point, strict=False)) for point in points]
    if knots is None:
        knots = [0.0, *np.linspace(0.0, 1.0, len(points)).tolist(), 1.0]
    return {"degree": degree, "knotVector": list(knots), "controlPoints": controls}


def on_wire(topic: str, content: Mapping[str, Any], version: str) -> bytes:
    """Return a message as a version has it, with the header that it lacks."""
    told = header() | dict(content) | {"version": VERSIONS[version]}
    return json.dumps(told if version == "2.1" else written(told, topic, version)).encode()


class Toy:
    """A vehicle on a robot that is where it is told to be at once."""

    def __init__(
        self, identity: Identity = OF_2, ground: DrivingArea | None = None, **robot: Any
    ) -> None:
        robot = {"version": identity.version} | robot
        self.vehicle = Vehicle(ground or DrivingArea(MAP), identity.offered, 0.2, **robot)
        self.dialect = Dialect(identity)
        self.now = 0.0
        self.pose = Pose(0.0, 0.0, 0.0)
        self.arrivals: list[tuple[str, str, int]] = []
        self.sense()

    def sense(self, **more: Any) -> None:
        utc = EPOCH + timedelta(seconds=self.now)
        self.vehicle.sense(RobotSenses(self.now, self.pose, utc=utc, **more))

    def send(self, content: Mapping[str, Any]) -> None:
        self.hear("order", content)

    def do(self, kind: str, action_id: str = "i", **parameters: Any) -> None:
        self.hear("instantActions", {"actions": [action(kind, action_id, "NONE", **parameters)]})

    def hear(self, topic: str, content: Mapping[str, Any]) -> None:
        """Receive a message as a pilot does; it has the names inside the package."""
        try:
            data = on_wire(topic, content, self.dialect.identity.version)
            self.vehicle.receive(self.dialect.read(topic, data))
        except OrderRejectedError as error:
            self.vehicle.reject(error, MESSAGES[topic])

    def wait(self, duration: float) -> None:
        self.now += duration
        self.sense()

    def clock(self, until: float) -> None:
        for now in (until, until + 0.1):
            self.now = now
            self.sense()

    def step(self) -> bool:
        """Drive to the next node; False if the robot has to stand."""
        leg = self.vehicle.leg
        if leg is None:
            return False
        position = leg.nodes[0].node_position
        self.pose = Pose(position.x, position.y, 0.0)
        self.wait(1.0)
        if len(leg.nodes) == 1:
            self.vehicle.arrive(leg.nodes[0].key)
        return True

    def drive(self) -> None:
        while self.step():
            pass

    @property
    def faults(self) -> list[str]:
        """Names of the active errors."""
        return [error.fault.name for error in self.vehicle.errors]

    @property
    def done(self) -> dict[str, str]:
        """Status of each action by its id."""
        vehicle = self.vehicle
        states = (*vehicle.action_states, *vehicle.instant_action_states)
        return {state.action_id: str(state.action_status) for state in states}

    def state(self) -> VehicleState:
        """Return the state as a pilot composes it."""
        vehicle = self.vehicle
        return VehicleState(
            order_id=vehicle.order_id,
            order_update_id=vehicle.order_update_id,
            last_node_id=vehicle.last_node[0],
            last_node_sequence_id=vehicle.last_node[1],
            node_states=vehicle.node_states,
            edge_states=vehicle.edge_states,
            driving=False,
            action_states=vehicle.action_states,
            instant_action_states=vehicle.instant_action_states,
            battery_state=BatteryState(battery_charge=100.0, charging=False),
            operating_mode="AUTOMATIC",
            errors=tuple(self.dialect.error(report) for report in vehicle.errors),
            safety_state=SafetyState(e_stop="NONE", field_violation=False),
            information=(),
            maps=(),
            loads=() if vehicle.load is None else (vehicle.load,),
            paused=vehicle.is_paused,
            new_base_request=vehicle.wants_base,
        )
