"""Five robots that a fleet control drives over MQTT: a mission, bad input, a robot killed."""

import contextlib
import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import paho.mqtt.client as mqtt
import pytest
from paho.mqtt.enums import CallbackAPIVersion
from shapely import LineString, Point
from vda5050.validation import SchemaValidator

from tests.fakes.fleet_orders import action, edge, header, node, nurbs
from tests.fakes.real_swarm import RealSwarm
from tests.fakes.ros_domains import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
WORLD = "hall_12"
CORNER = ((4.5, -2.0), (0.0, -2.0))  # of the way round it
LIMIT = 90.0  # [s] of wall time, on a busy machine
HAS_BROKER = shutil.which("mosquitto", path=os.environ["PATH"] + ":/usr/sbin") is not None


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Listener:
    """Hears everything, and remembers it."""

    def __init__(self, port, root="uagv/v2/swarm"):
        self.root = root
        self.messages: list[tuple[str, str, dict[str, Any]]] = []  # robot, topic, content
        self.client = mqtt.Client(CallbackAPIVersion.VERSION2)
        self.client.on_connect = lambda client, *_: client.subscribe(f"{root}/#")
        self.client.on_message = self._hear
        self.client.connect("127.0.0.1", port)
        self.client.loop_start()

    def _hear(self, _client, _data, message):
        robot, topic = message.topic.split("/")[-2:]
        with contextlib.suppress(ValueError):
            self.messages.append((robot, topic, json.loads(message.payload)))

    def all(self, robot, topic):
        return [m for who, what, m in list(self.messages) if (who, what) == (robot, topic)]

    def state(self, robot):
        return self.all(robot, "state")[-1]

    def send(self, robot, topic, content, *, is_kept=False):
        payload = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.client.publish(f"{self.root}/{robot}/{topic}", payload, retain=is_kept)

    def wait(self, is_true, what):
        end = time.monotonic() + LIMIT
        while not is_true():
            assert time.monotonic() < end, (what, self.messages[-3:])
            time.sleep(0.05)

    def await_error(self, robot, kind, word):
        def is_there():
            errors = self.state(robot)["errors"]
            return any(kind == e["errorType"] and word in e["errorDescription"] for e in errors)

        self.wait(is_there, f"{kind} {word}")


@pytest.fixture(scope="module")
def swarm(tmp_path_factory):
    port = free_port()
    with reserved_domain() as domain:
        up = RealSwarm(
            tmp_path_factory.mktemp("vda5050"), domain, "--swarm-size", "5", "--world", WORLD,
            "--vda5050", f"embedded:{port}", "--drive", "planar", "--speed", "max", "--headless",
            "--no-report",
        )  # fmt: skip
        try:
            up.wait_until_active()
            up.wait_until(lambda: "VDA 5050: 5 robots at" in up.output)
            yield Listener(port), port, up
        finally:
            up.close()


def kill_broker(up):
    (broker,) = (
        child for child in up.processes()
        if child.name() == "mosquitto"
    )  # fmt: skip
    broker.kill()


def is_online_again(robot, listener):
    """Whether a robot whose connection broke has another one; what is sent before is lost."""
    told = [message["connectionState"] for message in listener.all(robot, "connection")]
    return "CONNECTIONBROKEN" in told and told[-1] == "ONLINE"


def order_from(state, order_id, x, y, *actions):
    """Return an order from where a robot is to a place."""
    here = state["agvPosition"]
    nodes = [
        node(0, x=here["x"], y=here["y"], mapId=WORLD),
        node(1, *actions, x=x, y=y, mapId=WORLD),
    ]
    parts = {"orderId": order_id, "orderUpdateId": 0, "nodes": nodes, "edges": [edge(0)]}
    return header() | {"serialNumber": state["serialNumber"]} | parts


def has_arrived(listener, robot):
    """Whether a robot has no nodes ahead; asks it for its state, so that none is missed."""
    ask = action("stateRequest", f"ask-{time.monotonic()}", "NONE")
    told = {"serialNumber": robot, "actions": [ask]}
    listener.send(robot, "instantActions", header() | told)
    return listener.state(robot)["nodeStates"] == []


def ended(state, action_id):
    """Return the status of an action; empty if there is none."""
    found = [a["actionStatus"] for a in state["actionStates"] if a["actionId"] == action_id]
    return found[0] if found else ""


def round_the_corner(state):
    """Return an order in a corridor that does not lead straight to its end."""
    content = order_from(state, "corner", 0.0, -2.0)
    here = state["agvPosition"]
    content["nodes"][1]["nodePosition"] |= {"theta": 1.5, "allowedDeviationTheta": 0.1}
    content["edges"][0] |= {
        "trajectory": nurbs((here["x"], here["y"]), *CORNER),
        "corridor": {"leftWidth": 0.5, "rightWidth": 0.5},
    }
    return content


@pytest.mark.slow
@pytest.mark.skipif(not HAS_BROKER, reason="mosquitto is not installed")
def test_a_fleet_control_drives_the_swarm(swarm):
    listener, port, up = swarm
    sites = str(ROOT / "worlds" / WORLD / "sites.yaml")
    example = (sys.executable, str(ROOT / "examples" / "fleet_control.py"), sites, str(port))
    with subprocess.Popen(example, stdout=subprocess.DEVNULL) as control:
        end = time.monotonic() + LIMIT
        while control.poll() is None:
            if time.monotonic() > end:
                control.kill()
            for number in range(1, 6):  # it has missed the first states; the next may be far off
                request = action("stateRequest", f"ask-{number}-{time.monotonic()}", "NONE")
                content = header() | {"serialNumber": f"Srobot{number}", "actions": [request]}
                listener.send(f"Srobot{number}", "instantActions", content)
            time.sleep(1.0)
    assert control.returncode == 0
    for number in range(1, 6):
        state = listener.state(f"Srobot{number}")
        assert state["orderId"].startswith(f"Srobot{number}-")
        assert state["nodeStates"] == [] == state["errors"]
        assert all(a["actionStatus"] == "FINISHED" for a in state["actionStates"])

    state = listener.state("Srobot1")
    wall = order_from(state, "wall", -9.9, 0.0)
    for content, kind, word in (
        (b"no json", "validationError", "order: JSON is malformed"),
        (json.dumps(wall).replace("-9.9", "NaN").encode(), "validationError", "malformed"),
        (wall | {"speed": 1}, "validationError", "speed"),
        (wall, "noRouteError", "is "),
        (b" " * 1_150_000, "validationError", "bytes"),
    ):
        listener.send("Srobot1", "order", content)
        listener.await_error("Srobot1", kind, word)

    work = action("wait", "work", duration=3.0)
    listener.send("Srobot1", "order", order_from(state, "far", 5.0, 5.0, work))
    listener.wait(lambda: listener.state("Srobot1")["driving"], "it drives")
    assert listener.state("Srobot1")["errors"] == []
    for kind, is_kept in (("startPause", True), ("stopPause", False)):
        told = {"serialNumber": "Srobot1", "actions": [action(kind, kind, "NONE")]}
        listener.send("Srobot1", "instantActions", header() | told, is_kept=is_kept)
    assert up.run("commander", "restart", "Srobot1").returncode == 0
    listener.wait(
        lambda: (
            listener.state("Srobot1")["lastNodeId"] == "n1"
            and listener.state("Srobot1")["actionStates"][0]["actionStatus"] == "FINISHED"
        ),
        "it arrives although its navigator was killed",
    )
    listener.wait(lambda: is_online_again("Srobot1", listener), "it is heard again")
    listener.await_error("Srobot1", "validationError", "kept this message from before")
    assert listener.state("Srobot1")["paused"] is False
    listener.send("Srobot1", "instantActions", b"", is_kept=True)  # the broker forgets it
    told = {"serialNumber": "Srobot1", "actions": [action("stateRequest", "s", "NONE")]}
    listener.send("Srobot1", "instantActions", header() | told)
    listener.wait(lambda: listener.state("Srobot1")["errors"] == [], "it takes what is new")
    state = listener.state("Srobot1")
    count = len(listener.all("Srobot1", "visualization"))
    listener.send("Srobot1", "order", round_the_corner(state))
    listener.wait(lambda: listener.state("Srobot1")["orderId"] == "corner", "it takes the corridor")
    listener.wait(lambda: listener.state("Srobot1")["nodeStates"] == [], "it leaves the corridor")
    assert abs(listener.state("Srobot1")["agvPosition"]["theta"] - 1.5) < 0.15
    track = [m["agvPosition"] for m in listener.all("Srobot1", "visualization")[count:]]
    corner = LineString([(state["agvPosition"]["x"], state["agvPosition"]["y"]), *CORNER])
    far = [corner.distance(Point(at["x"], at["y"])) for at in track]
    assert max(far) < 0.55, (
        max(far),
        state,
        track,
    )  # half the corridor's width, and what the pose may err
    assert min(math.hypot(at["x"] - 2.5, at["y"] - 1.5) for at in track) > 1.2
    assert listener.state("Srobot1")["errors"] == []
    count = len(listener.all("Srobot1", "state"))
    content = order_from(listener.state("Srobot1"), "astern", 3.0, -2.0)
    content["edges"][0]["orientation"] = 3.14
    listener.send("Srobot1", "order", content)
    listener.wait(lambda: listener.state("Srobot1")["orderId"] == "astern", "it takes the order")
    listener.wait(lambda: has_arrived(listener, "Srobot1"), "it drives backwards")
    speeds = [m["velocity"]["vx"] for m in listener.all("Srobot1", "state")[count:]]
    assert min(speeds) < -0.1
    assert max(speeds) < 0.05
    assert abs(listener.state("Srobot1")["agvPosition"]["theta"]) > 2.8
    assert listener.state("Srobot1")["errors"] == []
    exact = action("finePositioning", "exact", stationName="dock")
    content = order_from(listener.state("Srobot1"), "exact", 2.0, -2.0, exact)
    content["nodes"][1]["nodePosition"] |= {"theta": 0.7}
    listener.send("Srobot1", "order", content)
    maps = ROOT / "maps"
    for version, name in (("2", WORLD), ("3", "slim_blockage")):
        link = (maps / f"{name}.yaml").as_uri()
        told = {"mapId": WORLD, "mapVersion": version, "mapDownloadLink": link}
        actions = {"actions": [action("downloadMap", f"map-{version}", "NONE", **told)]}
        told = header() | {"serialNumber": "Srobot1"} | actions
        listener.send("Srobot1", "instantActions", told)
    listener.await_error("Srobot1", "actionError", "does not fit the running world")
    listener.wait(
        lambda: [each["mapVersion"] for each in listener.state("Srobot1")["maps"]] == ["1", "2"],
        "it has the map",
    )
    listener.wait(
        lambda: (
            listener.state("Srobot1")["orderId"] == "exact"
            and ended(listener.state("Srobot1"), "exact") == "FINISHED"
        ),
        "it stands exactly",
    )
    at = listener.state("Srobot1")["agvPosition"]
    assert math.hypot(at["x"] - 2.0, at["y"] + 2.0) < 0.06
    assert abs(at["theta"] - 0.7) < 0.06
    count = len(listener.all("Srobot2", "connection"))
    kill_broker(up)
    listener.wait(lambda: len(listener.all("Srobot2", "connection")) > count, "the broker is back")
    listener.send("Srobot2", "order", order_from(listener.state("Srobot2"), "back", 0.0, 0.0))
    listener.wait(lambda: listener.state("Srobot2")["orderId"] == "back", "it takes an order")
    up.popen.send_signal(signal.SIGINT)
    assert up.wait_for_end() == 0
    connections = [m["connectionState"] for m in listener.all("Srobot1", "connection")]
    assert connections == ["ONLINE", "CONNECTIONBROKEN", "ONLINE", "ONLINE", "OFFLINE"]
    valid = SchemaValidator()
    for robot, topic, content in listener.messages:
        if topic not in ("order", "instantActions"):
            assert valid.errors(topic, content) == [], (robot, topic)
