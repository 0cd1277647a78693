"""A small fleet control: sends five robots to two stations each, by VDA 5050.
swarm-up --world hall_12 --swarm-size 5 --vda5050 embedded
python examples/fleet_control.py worlds/hall_12/sites.yaml [PORT]
"""

import json
import math
import sys
from pathlib import Path

import paho.mqtt.client as mqtt
import yaml
from paho.mqtt.enums import CallbackAPIVersion

PATH, PORT = Path(sys.argv[1]), int((*sys.argv, 1883)[2])
STATIONS = yaml.safe_load(PATH.read_text(encoding="utf-8"))["stations"]
WORK = {
    "actionType": "wait",
    "blockingType": "HARD",
    "actionParameters": [{"key": "duration", "value": 2.0}],
}
todo: dict[str, list[str]] = {}  # stations that are left, by robot
sent: dict[str, str] = {}  # latest order, by robot
home: set[str] = set()  # robots that have nothing left to do


def part(number: int, **more: object) -> dict:
    return {"sequenceId": number, "released": True, "actions": [], **more}


def node(name: str, number: int, place: dict[str, float], *actions: dict) -> dict:
    position = {**place, "mapId": PATH.parent.name}
    return part(number, nodeId=name, actions=list(actions), nodePosition=position)


def order(state: dict, station: str) -> dict:
    sent[state["serialNumber"]] = name = f"{state['serialNumber']}-{station}-{state['headerId']}"
    here = {axis: state["agvPosition"][axis] for axis in "xy"}
    x, y, yaw = STATIONS[station]
    there = {"x": x, "y": y, "theta": math.remainder(yaw, math.tau)}  # no more than π
    edge = part(1, edgeId=f"to-{station}", startNodeId="here", endNodeId=station)
    nodes = [node("here", 0, here), node(station, 2, there, WORK | {"actionId": f"{name}-work"})]
    header = {key: state[key] for key in list(state)[:5]}
    return {**header, "orderId": name, "orderUpdateId": 0, "nodes": nodes, "edges": [edge]}


def on_state(client: mqtt.Client, _: object, message: mqtt.MQTTMessage) -> None:
    state = json.loads(message.payload)
    robot, names = state["serialNumber"], list(STATIONS)
    todo.setdefault(robot, [names[(len(todo) + k) % len(names)] for k in range(2)])
    told = [ref["referenceValue"] for e in state["errors"] for ref in e.get("errorReferences", ())]
    if sent.get(robot) in told:  # it has moved since, to let another one pass: order again
        todo[robot].insert(0, sent.pop(robot).split("-")[1])
        sent[robot] = state["orderId"]
    works = any(a["actionStatus"] not in ("FINISHED", "FAILED") for a in state["actionStates"])
    if state["orderId"] != sent.get(robot, "") or state["nodeStates"] or works:
        return  # it has not heard of its order yet, or is not done
    print(f"{robot} is done; left: {todo[robot]}", flush=True)
    if todo[robot]:
        topic = message.topic.replace("/state", "/order")
        client.publish(topic, json.dumps(order(state, todo[robot].pop(0))))
        return
    home.add(robot)
    if len(home) == 5:
        client.disconnect()


fleet = mqtt.Client(CallbackAPIVersion.VERSION2)
fleet.on_message = on_state
fleet.on_connect = lambda client, *_: client.subscribe("uagv/v2/+/+/state")
fleet.connect("127.0.0.1", PORT)
fleet.loop_forever()
