"""Vehicles of VDA 5050 take part in lockstep: one order that is there at the start, one run."""

import contextlib
import json
import os
import pickle
import random
import shutil
import socket
import subprocess
import time
from pathlib import Path
from typing import Any

import paho.mqtt.client as mqtt
import pytest
import rclpy
from paho.mqtt.enums import CallbackAPIVersion
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import SetSimulationState

from swarm_common.process import start
from swarm_run.domain import DomainLock
from swarm_run.spec import RunSpec
from tests.fakes.fleet_orders import action, edge, header, node
from tests.fakes.ros_domains import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 120.0  # [s] of wall time, on a busy machine
WORLD = "hall_12"
NAMES = ("Srobot1", "Srobot2")
PLACES = {"Srobot1": ((0.0, -2.0), (4.5, -2.0)), "Srobot2": ((4.5, -2.0), (0.0, -2.0))}
PORTS = range(20_000, 30_000)
ARRIVAL = 2.0  # [s] of wall time that a message may take on this host
HAS_BROKER = shutil.which("mosquitto", path=os.environ["PATH"] + ":/usr/sbin") is not None


class FleetControl:
    """A client of the broker that knows the latest state of each robot."""

    def __init__(self, port):
        self.states: dict[str, dict[str, Any]] = {}
        self.client = mqtt.Client(CallbackAPIVersion.VERSION2)
        self.client.on_connect = lambda client, *_: client.subscribe("uagv/v2/swarm/+/state")
        self.client.on_message = self._hear
        until(lambda: self._connects(port), "the broker is there")
        self.client.loop_start()

    def _connects(self, port):
        with contextlib.suppress(OSError):
            self.client.connect("127.0.0.1", port)
            return True
        return False

    def _hear(self, _client, _data, message):
        self.states[message.topic.split("/")[-2]] = json.loads(message.payload)

    def send_orders(self):
        """Send each robot by a place, where it waits, to another; return when they are there."""
        until(lambda: set(self.states) == set(NAMES), "all robots have told where they are")
        for name, (first, last) in PLACES.items():
            here = self.states[name]["agvPosition"]
            nodes = [
                node(0, x=here["x"], y=here["y"], mapId=WORLD),
                node(1, action("wait", f"{name}-wait", duration=3.0), **_at(first)),
                node(2, **_at(last)),
            ]
            edges = [edge(0) | {"maxSpeed": 0.2}, edge(1) | {"maxSpeed": 0.15}]
            order = {"orderId": "there", "orderUpdateId": 0, "nodes": nodes, "edges": edges}
            payload = json.dumps(header() | {"serialNumber": name} | order)
            topic = f"uagv/v2/swarm/{name}/order"
            self.client.publish(topic, payload, qos=1).wait_for_publish(LIMIT)
        time.sleep(ARRIVAL)


def _at(place):
    return {"x": place[0], "y": place[1], "mapId": WORLD}


def until(is_true, what):
    end = time.monotonic() + LIMIT
    while not is_true():
        assert time.monotonic() < end, what
        time.sleep(0.05)


def play(domain):
    """Let a world go on that stands at its first tick."""
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    executor = SingleThreadedExecutor(context=context)
    client_node = rclpy.create_node("operator", context=context, enable_rosout=False)
    executor.add_node(client_node)
    client = client_node.create_client(SetSimulationState, "/sim/set_simulation_state")
    assert client.wait_for_service(LIMIT)
    state = SimulationState(state=SimulationState.STATE_PLAYING)
    future = client.call_async(SetSimulationState.Request(state=state))
    executor.spin_until_future_complete(future, LIMIT)
    executor.shutdown()
    client_node.destroy_node()
    context.shutdown()


def free_port():
    for port in random.sample(PORTS, len(PORTS)):
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise AssertionError("no port is free")


def run(folder, pack):
    port = free_port()
    with reserved_domain() as domain, (folder / "up.log").open("w+", encoding="utf-8") as log:
        spec = RunSpec(
            swarm_size=len(NAMES), world=WORLD, drive="planar", seed=2, pack=pack, paused=True,
            vda5050=f"embedded:{port}", duration=100.0, report=False, speed="max",
            run_dir=str(folder / "run"),
        )  # fmt: skip
        lock = DomainLock(domain)
        up = subprocess.Popen(
            start.command("swarm_commander.cli.child", str(folder), str(lock.fileno())), cwd=folder,
            stdin=subprocess.PIPE, stdout=log, stderr=log, pass_fds=(lock.fileno(),),
            env=os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)},
        )  # fmt: skip
        lock.release()
        up.stdin.write(pickle.dumps(spec))
        up.stdin.flush()
        try:
            control = FleetControl(port)
            control.send_orders()
            play(domain)
            assert up.wait(timeout=LIMIT) == 0, (folder / "up.log").read_text(encoding="utf-8")
            control.client.loop_stop()
        finally:
            up.stdin.close()
            up.wait(timeout=LIMIT)
    for state in control.states.values():
        assert (state["orderId"], state["lastNodeId"]) == ("there", "n2"), state
        assert [each["actionStatus"] for each in state["actionStates"]] == ["FINISHED"]
        assert state["errors"] == []
    report = json.loads((folder / "run" / "report.json").read_text(encoding="utf-8"))
    assert report["late_ticks"] == 0
    return str(report["trajectory_sha256"])


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """Hash of a run."""
    return run(tmp_path_factory.mktemp("first"), 1)


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.skipif(not HAS_BROKER, reason="mosquitto is not installed")
@pytest.mark.parametrize("pack", [pytest.param(1, marks=pytest.mark.long), 2])
def test_orders_of_a_fleet_control_repeat(tmp_path, first, pack):
    assert run(tmp_path, pack) == first
