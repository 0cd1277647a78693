"""Fleet controls drive a swarm to the end: two public libraries unmodified, and a coordinator."""

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fakes.real_swarm import RealSwarm
from tests.fakes.ros_domains import reserved_domain
from tests.graph.test_vda5050 import HAS_BROKER, free_port

MASTERS = Path(__file__).resolve().parents[1] / "fakes" / "masters"
LIMIT = 240.0  # [s] of wall time, on a busy machine
SIZE = ("5", "5", "hall_12", "4.5")  # robots, orders of each, map, reach of the places [m]
CROWD = ("20", "1", "hall_12", "-5.5", "1.5", "8")  # likewise; first node [m], pitch [m], nodes


def has_node_library():
    node = shutil.which("node")
    look = (node or "", "-e", "require.resolve('vda-5050-lib')")
    return (
        node is not None and subprocess.run(look, capture_output=True, check=False).returncode == 0
    )


def command_of(version):
    """Return the command of the master of a version; skips where its library is missing."""
    if version == "2.1":
        if importlib.util.find_spec("aiomqtt") is None:
            pytest.skip("aiomqtt is not installed: pip install vda5050-sdk[mqtt]")
        return sys.executable, str(MASTERS / "sdk_master.py")
    if not has_node_library():
        pytest.skip("vda-5050-lib is not installed: npm install vda-5050-lib, and NODE_PATH")
    return "node", str(MASTERS / "lib_master.js")


def drive(folder, command, size, *flags):
    """Let a fleet control drive a swarm to the end, without a contact; return the verdict on it."""
    port = free_port()
    with reserved_domain() as domain:
        up = RealSwarm(
            folder, domain, "--swarm-size", size[0], "--world", size[2], "--vda5050",
            f"embedded:{port}", "--vda5050-check", "lenient", "--drive", "planar",
            "--speed", "max", "--pack", "5", "--headless", "--no-report", *flags,
        )  # fmt: skip
        try:
            up.wait_until_active()
            up.wait_until(lambda: f"VDA 5050: {size[0]} robots at" in up.output)
            done = subprocess.run(
                (*command, str(port), *size), timeout=LIMIT, env=os.environ, check=False
            )
            assert done.returncode == 0
            up.popen.send_signal(signal.SIGINT)
            assert up.wait_for_end() == 0
        finally:
            up.close()
    report = json.loads((folder / "run" / "report.json").read_text(encoding="utf-8"))
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    return json.loads((folder / "run" / "vda5050.json").read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.skipif(not HAS_BROKER, reason="mosquitto is not installed")
@pytest.mark.parametrize("version", ["2.1", "2.0"])
def test_a_public_library_drives_the_swarm_and_breaks_no_rule(version, tmp_path):
    verdict = drive(tmp_path, command_of(version), SIZE, "--vda5050-version", version)
    assert set(verdict["broken"]) <= {"start"}, verdict
    assert verdict["orders"]["done"] + verdict["orders"]["given_up"] >= 25


@pytest.mark.slow
@pytest.mark.skipif(not HAS_BROKER, reason="mosquitto is not installed")
def test_a_fleet_control_that_coordinates_drives_20_robots_that_make_no_way(tmp_path):
    """Robots left the edges that were theirs, and blocked each other for good."""
    command = sys.executable, str(MASTERS / "coordinating_master.py")
    verdict = drive(tmp_path, command, CROWD, "--coordination", "fleet")
    assert verdict["broken"] == [], verdict
    assert verdict["orders"]["done"] >= 20  # robots in the way are sent off besides
