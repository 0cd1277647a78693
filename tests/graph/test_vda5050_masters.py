"""Unmodified fleet controls of two public libraries drive five robots through 25 orders."""

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


@pytest.mark.slow
@pytest.mark.skipif(not HAS_BROKER, reason="mosquitto is not installed")
@pytest.mark.parametrize("version", ["2.1", "2.0"])
def test_a_public_library_drives_the_swarm_and_breaks_no_rule(version, tmp_path):
    command = command_of(version)
    port = free_port()
    with reserved_domain() as domain:
        up = RealSwarm(
            tmp_path, domain, "--swarm-size", "5", "--world", "hall_12",
            "--vda5050", f"embedded:{port}", "--vda5050-version", version,
            "--vda5050-check", "lenient", "--drive", "planar", "--speed", "max", "--pack", "5",
            "--headless", "--no-report", "--run-dir", str(tmp_path / "run"),
        )  # fmt: skip
        try:
            up.wait_until_active()
            up.wait_until(lambda: "VDA 5050: 5 robots at" in up.output)
            done = subprocess.run(
                (*command, str(port), *SIZE), timeout=LIMIT, env=os.environ, check=False
            )
            assert done.returncode == 0
            up.popen.send_signal(signal.SIGINT)
            assert up.wait_for_end() == 0
        finally:
            up.close()
    verdict = json.loads((tmp_path / "run" / "vda5050.json").read_text(encoding="utf-8"))
    assert set(verdict["broken"]) <= {"start"}, verdict
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
