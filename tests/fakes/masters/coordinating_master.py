"""A fleet control that coordinates: robots drive from node to node, each held by one robot.

python coordinating_master.py PORT ROBOTS ORDERS MAP FIRST PITCH COUNT

Nodes are a lattice of COUNT x COUNT with its first at (FIRST, FIRST) [m]. The base of an order ends
at the next node, its horizon at the goal. Who waits longest goes first, and others that are in its
way and do nothing are sent off (priority inheritance with backtracking).
"""

import itertools
import json
import math
import random
import sys
from collections import deque
from datetime import UTC, datetime

import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion

PORT, ROBOTS, ORDERS, MAP = int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
FIRST, PITCH, COUNT = float(sys.argv[5]), float(sys.argv[6]), int(sys.argv[7])
FINAL = ("FINISHED", "FAILED")
NODES = list(itertools.product(range(COUNT), repeat=2))
numbers = itertools.count(1)  # of messages and orders


def place_of(node):
    return FIRST + PITCH * node[0], FIRST + PITCH * node[1]


def beside(node):
    i, j = node
    near = ((i + 1, j), (i, j + 1), (i - 1, j), (i, j - 1))
    return [(a, b) for a, b in near if 0 <= a < COUNT and 0 <= b < COUNT]


def part(number, released):
    return {"sequenceId": number, "released": released, "actions": []}


def action(kind, action_id, blocking, **parameters):
    given = [{"key": key, "value": value} for key, value in parameters.items()]
    return {
        "actionType": kind, "actionId": action_id, "blockingType": blocking,
        "actionParameters": given,
    }  # fmt: skip


def steps_to(goal):
    """Return the number of edges from every node to a goal."""
    steps, todo = {goal: 0}, deque([goal])
    while todo:
        node = todo.popleft()
        for other in beside(node):
            if other not in steps:
                steps[other] = steps[node] + 1
                todo.append(other)
    return steps


class Robot:
    """A robot: the node that it has, the one to which it drives, and its orders."""

    def __init__(self, name):
        self.name = name
        self.at = self.to = self.goal = None
        self.steps = {}  # to the goal
        self.left = ORDERS
        self.since = 0  # number of the message with which its order began
        self.order_id, self.update, self.number = "", 0, 0
        self.is_new = self.is_ending = False  # its order
        self.random = random.Random(name)

    def hear(self, state, taken):
        """Learn from a state where the robot is; a robot is on its nearest node at first."""
        if self.at is None:
            x, y = (state["agvPosition"][axis] for axis in "xy")
            free = [node for node in NODES if node not in taken]
            self.at = self.to = min(free, key=lambda node: math.dist(place_of(node), (x, y)))
            self.order_id = state["orderId"]
        if state["errors"]:
            sys.exit(f"{self.name} at {self.at} to {self.to}: {state['errors']}")
        if state["orderId"] != self.order_id or state["orderUpdateId"] != self.update:
            return
        if state["lastNodeSequenceId"] == self.number and not state["driving"]:
            self.at = self.to
            ended = all(each["actionStatus"] in FINAL for each in state["actionStates"])
            if self.is_ending and ended and not state["nodeStates"]:
                self.left -= 1
                self.goal, self.is_ending = None, False

    @property
    def is_idle(self):
        return self.at is not None and self.at == self.to and not self.is_ending

    def ways(self):
        """Return the nodes to which it may go, the best first."""
        near = [self.at, *beside(self.at)]
        return sorted(near, key=lambda node: (self.steps.get(node, 0), self.random.random()))

    def order_to(self, node):
        """Return an order, or an update of one, whose base ends at a node beside."""
        if self.goal is None or self.is_new:  # else it is an update
            self.order_id, self.update, self.number = f"{self.name}-{next(numbers)}", 0, 0
        else:
            self.update += 1
        self.is_new = False
        way = [self.at, node]
        while self.goal is not None and way[-1] != self.goal:
            way.append(min(beside(way[-1]), key=self.steps.__getitem__))
        nodes, edges = [], []
        for k, each in enumerate(way):
            x, y = place_of(each)
            place = {
                "nodeId": "{}-{}".format(*each),
                "nodePosition": {"x": x, "y": y, "mapId": MAP},
            }
            nodes.append(part(self.number + 2 * k, k < 2) | place)
        for k, (a, b) in enumerate(itertools.pairwise(each["nodeId"] for each in nodes)):
            ends = {"edgeId": f"{a}_{b}", "startNodeId": a, "endNodeId": b}
            edges.append(part(self.number + 2 * k + 1, k < 1) | ends)
        self.is_ending = node == self.goal
        if self.is_ending:
            nodes[-1]["actions"] = [action("wait", f"{self.order_id}-w", "HARD", duration=1.0)]
        self.to, self.number = node, self.number + 2
        order = {"orderId": self.order_id, "orderUpdateId": self.update}
        return order | {"nodes": nodes, "edges": edges}


class Master:
    """All robots, and who has which node."""

    def __init__(self):
        self.robots = {f"Srobot{k}": Robot(f"Srobot{k}") for k in range(1, ROBOTS + 1)}
        self.client = mqtt.Client(CallbackAPIVersion.VERSION2)
        self.client.on_message = self.receive
        self.client.on_connect = self.begin

    def begin(self, client, *_):
        client.subscribe("uagv/v2/swarm/+/state")
        for name in self.robots:
            ask = action("stateRequest", f"{name}-state", "NONE")
            self.send(name, "instantActions", {"actions": [ask]})

    def send(self, name, topic, content):
        header = {
            "headerId": next(numbers), "timestamp": datetime.now(UTC).isoformat()[:23] + "Z",
            "version": "2.1.0", "manufacturer": "swarm", "serialNumber": name,
        }  # fmt: skip
        self.client.publish(f"uagv/v2/swarm/{name}/{topic}", json.dumps(header | content))

    def receive(self, client, _, message):
        state = json.loads(message.payload)
        robot = self.robots.get(state["serialNumber"])
        if robot is None:
            return
        robot.hear(state, self.taken())
        if any(each.at is None for each in self.robots.values()):
            return
        robots = sorted(self.robots.values(), key=lambda each: (each.goal is None, each.since))
        for each in robots:
            if each.is_idle and each.goal is None and each.left:
                others = {other.goal for other in robots} | {each.at}
                each.goal = each.random.choice([node for node in NODES if node not in others])
                each.steps, each.since, each.is_new = steps_to(each.goal), next(numbers), True
        decided = set()
        for each in robots:
            if each.is_idle and each.goal is not None and each not in decided:
                self.move(each, frozenset(), decided)
        if not any(each.left for each in self.robots.values()):
            client.disconnect()

    def taken(self):
        return {node: each for each in self.robots.values() for node in (each.to, each.at)}

    def move(self, robot, barred, decided):
        """Send a robot on, or others out of its way; return whether one of them moves."""
        decided.add(robot)
        for node in robot.ways():
            if node == robot.at and not barred:
                return False  # it is best where it is
            if node == robot.at or node in barred:
                continue
            other = self.taken().get(node)
            if other is None:
                self.send(robot.name, "order", robot.order_to(node))
                return True
            is_free_to_go = other.is_idle and other not in decided
            if is_free_to_go and self.move(other, barred | {robot.at}, decided):
                return True
        return False

    def run(self):
        self.client.connect("127.0.0.1", PORT)
        self.client.loop_forever()


Master().run()
