"""What users get: the wheel in an environment of its own, each command and each example once."""

import contextlib
import json
import shutil
import signal
import socket
import subprocess
import time
import tomllib

import pytest

from swarm_common.middleware.other_ros import is_own_ros
from tests.fakes.ros_domains import reserved_domain
from tests.fakes.wheel_environment import ROOT, WheelEnvironment

FOLDER = ROOT / "examples"
LIMIT = 600.0  # [s] of wall time, on a busy machine
pytestmark = pytest.mark.timeout(900)
COMMANDS = sorted(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"])
HALL = ("--world", "hall_12", "--headless", "--no-report")

EXAMPLES = {
    "compare": (["1"], "of 4 goals reached"),
    "external_node": ([], "0 collisions"),
    "faults": ([], "0 collisions"),
    "four_robots": (["--bench"], "0 collisions"),
    "own_controller": (["1"], "own: 0 collisions"),
    "own_rule": ([], "0 collisions"),
    "own_world": ([], "["),
    "ros_client": ([], "status 4"),  # action_msgs/GoalStatus: succeeded
    "sweep": (["1"], "margin 0.08 m"),
}
ACTIONS = {  # what ends by itself, in this order, and what it says
    "swarm-setup": ([], "compiled navigators are up to date"),
    "swarm-doctor": (["--swarm-size", "2"], "compiled kernels"),
    "swarm-up": (["--swarm-size", "2", "--duration", "3", "--headless"], "report.html"),
    "swarm-report": (["runs/latest"], "report.html"),
    "swarm-replay": (["runs/latest", "--info"], "/Srobot2/status"),
    "swarm-map": (["check", "hall_12"], ""),
    "swarm-bench": (
        ["traffic", "--scenario", "doorway", "--robots", "2", "--seeds", "0"],
        "goals 2/2",
    ),
}
WITH_A_SWARM = {"ros2", "swarm-commander", "swarm-teleop", "swarm-view"}
ORIGINS = """
import importlib, json, sys
print(json.dumps({name: importlib.import_module(name).__file__ for name in sys.argv[1:]}))
"""
SHIELDED = """
from swarm_workbench.gym import SwarmEnv
env = SwarmEnv(2, "hall_12", shield=True)
env.reset(seed=0)
for _ in range(30):
    *_, infos = env.step({name: env.action_space(name).high for name in env.agents})
print(infos)
"""


class Shell:
    """A terminal in which the environment of the wheel is active."""

    def __init__(self, environment, folder, domain):
        self.prefix, self.folder = environment.prefix, folder
        self._variables = environment.variables(ROS_DOMAIN_ID=str(domain))

    def start(self, *words):
        return subprocess.Popen(
            words, cwd=self.folder, env=self._variables, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    def run(self, *words):
        """Return what a command says that ends by itself."""
        with self.start(*words) as process:
            try:
                output, _ = process.communicate(timeout=LIMIT)
            finally:
                process.kill()
        assert process.returncode == 0, f"{words}: {process.returncode}\n{output}"
        return output

    @contextlib.contextmanager
    def running(self, sign, *words):
        """Keep a command running from when it says something until Ctrl-C, with which it ends."""
        with self.start(*words) as process:
            try:
                assert process.stdout is not None
                lines = [next((line for line in process.stdout if sign in line), None)]
                assert lines[0] is not None, f"{words} ended without '{sign}'"
                yield
                process.send_signal(signal.SIGINT)
                output, _ = process.communicate(timeout=LIMIT)
                assert process.returncode == 0, f"{words}: {process.returncode}\n{output}"
            finally:
                process.kill()


@pytest.fixture(scope="module")
def shell(tmp_path_factory):
    """Yield a terminal after `pip install` of the wheel and swarm-setup."""
    if not is_own_ros():
        pytest.skip("ROS 2 is not from PyPI, and no dependency of the wheel")
    folder = tmp_path_factory.mktemp("wheel")
    (folder / "work").mkdir()
    try:
        with reserved_domain() as domain:
            made = Shell(WheelEnvironment(folder), folder / "work", domain)
            said = made.run("swarm-setup")
            assert "interfaces installed" in said
            assert "navigators compiled" in said or "navigators are up to date" in said
            yield made
    finally:
        shutil.rmtree(folder)


def test_all_comes_from_the_wheel_and_navigators_are_compiled(shell):
    packages = sorted(path.parent.name for path in ROOT.glob("swarm_*/__init__.py"))
    navigator = "swarm_nav.behaviour.navigator"
    found = json.loads(shell.run("python", "-c", ORIGINS, *packages, navigator))
    assert [name for name in found if not found[name].startswith(f"{shell.prefix}/")] == []
    assert found[navigator].endswith(".so")


def test_robots_learn_behind_a_shield(shell):
    assert "Srobot2" in shell.run("python", "-c", SHIELDED)


def test_every_command_is_run():
    assert sorted([*ACTIONS, *WITH_A_SWARM]) == COMMANDS


@pytest.mark.parametrize("command", ACTIONS)
def test_a_command_does_its_work(shell, command):
    words, expected = ACTIONS[command]
    said = shell.run(command, *words)
    assert expected in said, said


def test_commands_work_with_a_swarm(shell):
    with shell.running(
        "all robots are active", "swarm-up", "--swarm-size", "2", "--speed", "5", *HALL
    ):
        assert "/Srobot2/status" in shell.run("ros2", "topic", "list")
        shell.run("swarm-commander", "Srobot1", "--goal", "-3.5", "3.5", "0.0")
        with shell.running("Srobot2 is yours", "swarm-teleop", "Srobot2"):
            pass
        with shell.running("http://", "swarm-view", "--port", "0", "--no-open"):
            pass


def test_every_example_is_run():
    elsewhere = {"fleet_control", "learn"}  # below; in test_learning.py
    assert {*EXAMPLES, *elsewhere} == {path.stem for path in FOLDER.glob("*.py")}


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs_and_is_short(shell, name):
    words, expected = EXAMPLES[name]
    assert expected in shell.run("python", str(short(name)), *words)


def test_a_fleet_control_of_the_examples_drives_a_swarm(shell):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = str(probe.getsockname()[1])
    sites = str(ROOT / "worlds" / "hall_12" / "sites.yaml")
    flags = ("--swarm-size", "5", *HALL, "--drive", "planar", "--speed", "max")
    with shell.start("swarm-up", *flags, "--vda5050", f"embedded:{port}") as up:
        try:
            listens = False
            end = time.monotonic() + LIMIT
            while not listens:  # it is to hear the first states
                assert time.monotonic() < end
                assert up.poll() is None, up.communicate()[0]
                with contextlib.suppress(OSError):
                    socket.create_connection(("127.0.0.1", int(port))).close()
                    listens = True
                time.sleep(0.05)
            said = shell.run("python", str(short("fleet_control")), sites, port)
            up.send_signal(signal.SIGINT)
            output, _ = up.communicate(timeout=LIMIT)
        finally:
            up.kill()
    # one that had to let others pass is told to go again, and is done twice
    assert len({line.split()[0] for line in said.splitlines() if "left: []" in line}) == 5
    assert up.returncode == 0, output


def short(name):
    path = FOLDER / f"{name}.py"
    most = 75 if name == "fleet_control" else 41
    assert len(path.read_text(encoding="utf-8").splitlines()) <= most
    return path
