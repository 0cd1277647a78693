"""A fleet control with the library vda5050-sdk, unmodified: orders, updates and cancels of 2.1.

python sdk_master.py PORT ROBOTS ORDERS MAP HALF
"""

import asyncio
import sys
import uuid

from vda5050.client.master import MasterClient
from vda5050.config import MasterConfig
from vda5050.model.common import Action
from vda5050.model.order import Order

PORT, ROBOTS, ORDERS, MAP = int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
HALF = float(sys.argv[5])  # [m] half the side of the square with the places to go to
PITCH = 1.8  # [m] between these
LIMIT = 600.0  # [s] for one order
KINDS = ("plain", "update", "plain", "cancel", "work")
FINAL = ("FINISHED", "FAILED")
COUNT = int(2 * HALF / PITCH) + 1
PLACES = [
    (round(PITCH * i - HALF, 3), round(PITCH * j - HALF, 3))
    for i in range(COUNT)
    for j in range(COUNT)
]


def action(kind, blocking="NONE", **parameters):
    return {
        "actionType": kind,
        "actionId": str(uuid.uuid4()),
        "blockingType": blocking,
        "actionParameters": [{"key": k, "value": v} for k, v in parameters.items()],
    }


def part(number, *, released, **more):
    return {"sequenceId": number, "released": released, "actions": [], **more}


def way(here, end, kind):
    """Return nodes and edges; the last of an order that is to be updated are not released."""
    places = [here, ((here[0] + end[0]) / 2, (here[1] + end[1]) / 2), end]
    nodes = [
        part(2 * i, released=i < 2 or kind != "update", nodeId=f"n{i}",
             nodePosition={"x": x, "y": y, "mapId": MAP})
        for i, (x, y) in enumerate(places)
    ]  # fmt: skip
    edges = [
        part(2 * i + 1, released=nodes[i + 1]["released"], edgeId=f"e{i}",
             startNodeId=f"n{i}", endNodeId=f"n{i + 1}")
        for i in range(2)
    ]  # fmt: skip
    if kind == "work":
        nodes[-1]["actions"] = [action("wait", "HARD", duration=1.0)]
    return {"nodes": nodes, "edges": edges}


TARGETS: dict[str, tuple[float, float]] = {}  # of all robots


class Robot:
    """One robot and its orders."""

    def __init__(self, client, name):
        self.client, self.name, self.key = client, name, f"swarm/{name}"
        self.state, self.order_id = None, ""

    async def until(self, is_true):
        end = asyncio.get_running_loop().time() + LIMIT
        while not is_true():
            assert asyncio.get_running_loop().time() < end, (self.name, self.order_id, self.state)
            await asyncio.sleep(0.02)

    def is_refused(self):
        """Whether the order was refused: the robot has moved since, to let another one pass."""
        found = [r for error in self.state.errors for r in error.error_references or ()]
        is_named = self.order_id in [reference.reference_value for reference in found]
        return self.state.order_id != self.order_id and is_named

    def is_taken(self):
        return self.state.order_id == self.order_id

    def is_over(self):
        ended = all(each.action_status.value in FINAL for each in self.state.action_states)
        return self.is_refused() or (self.is_taken() and not self.state.node_states and ended)

    def choose(self, number):
        """Return a place that no other robot drives to or stands at."""
        taken = [place for name, place in TARGETS.items() if name != self.name]
        first = 7 * number + 11 * int(self.name.removeprefix("Srobot"))
        around = [PLACES[(first + k) % len(PLACES)] for k in range(len(PLACES))]
        TARGETS[self.name] = next(place for place in around if place not in taken)
        return TARGETS[self.name]

    async def send(self, content, update):
        header = {
            "headerId": 0, "timestamp": "2026-01-01T00:00:00.000Z", "version": "2.1.0",
            "manufacturer": "swarm", "serialNumber": self.name, "orderId": self.order_id,
        }  # fmt: skip
        order = Order.model_validate(header | {"orderUpdateId": update} | content)
        result = await self.client.dispatch(order, self.key)
        assert result.accepted, result

    async def do(self, kind, **parameters):
        told = Action.model_validate(action(kind, **parameters))
        await self.client.send_instant_action(self.key, [told])

    async def carry_out(self, number):
        """Have one order carried out; return whether it was, or is to be sent anew."""
        kind, self.order_id = KINDS[number % len(KINDS)], str(uuid.uuid4())
        here = self.state.agv_position
        content = way((here.x, here.y), self.choose(number), kind)
        await self.send(content, 0)
        await self.until(lambda: self.is_taken() or self.is_refused())
        if kind == "update" and self.is_taken():
            released = [content[key][-1] | {"released": True} for key in ("nodes", "edges")]
            more = {"nodes": [content["nodes"][1], released[0]], "edges": [released[1]]}
            await self.send(more, 1)
        if kind == "cancel" and not self.is_over():
            await self.do("cancelOrder", orderId=self.order_id)
        await self.until(self.is_over)
        return not self.is_refused()

    async def work(self):
        while self.state is None:
            await self.do("stateRequest")
            await asyncio.sleep(2.0)
        for number in range(ORDERS):
            while not await self.carry_out(number):
                pass


async def main():
    client = MasterClient(MasterConfig(broker_url=f"mqtt://127.0.0.1:{PORT}"))
    robots = [Robot(client, f"Srobot{number}") for number in range(1, ROBOTS + 1)]
    by_name = {robot.name: robot for robot in robots}
    client.on_state(lambda state, key: setattr(by_name[key.serial_number], "state", state))
    async with client:
        await asyncio.gather(*(robot.work() for robot in robots))


asyncio.run(main())
