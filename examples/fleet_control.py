"""A fleet control in sixty lines: drives every robot that it hears through a mission, by VDA 5050.

swarm-up --world slim_blockage --swarm-size 5 --vda5050 embedded
python examples/fleet_control.py worlds/slim_blockage/sites.yaml
"""

import json
import sys
from datetime import UTC, datetime

import paho.mqtt.client as mqtt
import yaml
from paho.mqtt.enums import CallbackAPIVersion

ROBOTS, PORT = 5, int(sys.argv[2]) if len(sys.argv) > 2 else 1883
SITES = yaml.safe_load(open(sys.argv[1]))["stations"]
MAP = sys.argv[1].split("/")[-2]
todo: dict[str, list[str]] = {}  # stations that are left, by robot
sent: dict[str, str] = {}  # latest order, by robot
home: set[str] = set()  # robots that have nothing left to do


def position(x: float, y: float, theta: float | None = None) -> dict:
    heading = {} if theta is None else {"theta": theta}
    return {"x": x, "y": y, "mapId": MAP, **heading}


def node(name: str, number: int, where: dict, *actions: dict) -> dict:
    return {"nodeId": name, "sequenceId": number, "released": True, "nodePosition": where,
            "actions": list(actions)}  # fmt: skip


def order(state: dict, station: str) -> dict:
    """Return the order from where a robot is to a station, where it works for two seconds."""
    robot, here = state["serialNumber"], state["agvPosition"]
    sent[robot] = f"{robot}-{station}-{state['headerId']}"
    work = {"actionType": "wait", "actionId": f"{sent[robot]}-work", "blockingType": "HARD",
            "actionParameters": [{"key": "duration", "value": 2.0}]}  # fmt: skip
    edge = {"edgeId": f"to-{station}", "sequenceId": 1, "released": True, "startNodeId": "here",
            "endNodeId": station, "actions": []}  # fmt: skip
    nodes = [node("here", 0, position(here["x"], here["y"])),
             node(station, 2, position(*SITES[station]), work)]  # fmt: skip
    return {"headerId": 0, "timestamp": datetime.now(UTC).isoformat(), "version": "2.1.0",
            "manufacturer": state["manufacturer"], "serialNumber": robot, "orderId": sent[robot],
            "orderUpdateId": 0, "nodes": nodes, "edges": [edge]}  # fmt: skip


def on_state(client: mqtt.Client, _: object, message: mqtt.MQTTMessage) -> None:
    state = json.loads(message.payload)
    robot, names = state["serialNumber"], list(SITES)
    left = todo.setdefault(robot, [names[(len(todo) + k) % len(names)] for k in range(2)])
    works = any(a["actionStatus"] not in ("FINISHED", "FAILED") for a in state["actionStates"])
    if state["orderId"] != sent.get(robot, "") or state["nodeStates"] or works:
        return  # it has not heard of its order yet, or is not done
    print(f"{robot} is done; left: {left}", flush=True)
    if left:
        topic = message.topic.replace("/state", "/order")
        client.publish(topic, json.dumps(order(state, left.pop(0))))
    else:
        home.add(robot)
    if len(home) == ROBOTS:
        client.disconnect()


fleet = mqtt.Client(CallbackAPIVersion.VERSION2)
fleet.on_message = on_state
fleet.on_connect = lambda client, *_: client.subscribe("uagv/v2/+/+/state")
fleet.connect("127.0.0.1", PORT)
fleet.loop_forever()
