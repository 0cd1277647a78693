"""An operator's goals repeat: with a tick at which they begin, or in a swarm that is stepped."""

import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import rclpy
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import SetSimulationState
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.ros_io import pose_stamped, start_text, tick_of
from swarm_common.model.records import CONTROL_PERIOD, Pose
from swarm_workbench import Swarm
from tests.fakes.ros_domains import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 90.0  # [s] of wall time, on a busy machine
START = 100  # tick at which the goals begin
SECONDS = 70.0  # of a run
OPTIONS: dict[str, Any] = {"world": "doorway", "robots": 2, "seed": 2, "drive": "planar"}
GOALS = {"Srobot1": (4.5, -1.5, 0.0), "Srobot2": (4.5, 1.5, 0.0)}  # through the door
SLOW = "1"  # times real time until the operator has paused the world


class Operator:
    """A client of our own in a swarm's domain."""

    def __init__(self, domain: int) -> None:
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("operator", context=self.context, enable_rosout=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.tick = 0
        self.node.create_subscription(RobotStatus, "/Srobot1/status", self._hear, 10)

    def _hear(self, status: RobotStatus) -> None:
        self.tick = tick_of(status.stamp)

    def pause(self) -> None:
        """Let time stand still."""
        self._set_state(SimulationState.STATE_PAUSED)

    def go_on(self) -> None:
        """Let the world run as fast as it can."""
        client = AsyncParameterClient(self.node, "/sim/world")
        self._spin_until(client.services_are_ready)
        answer = self._result_of(client.set_parameters([Parameter("speed", value=0.0)]))
        assert answer.results[0].successful
        self._set_state(SimulationState.STATE_PLAYING)

    def _set_state(self, state: int) -> None:
        client = self.node.create_client(SetSimulationState, "/sim/set_simulation_state")
        self._spin_until(client.service_is_ready)
        request = SetSimulationState.Request(state=SimulationState(state=state))
        assert self._result_of(client.call_async(request)).result.result == Result.RESULT_OK

    def send_goals(self) -> None:
        """Send all goals by their action, before they begin."""
        for name, place in GOALS.items():
            client = ActionClient(self.node, NavigateToPose, f"/{name}/navigate_to_pose")
            self._spin_until(client.server_is_ready)
            goal = NavigateToPose.Goal(
                pose=pose_stamped(Pose(*place), 0), behavior_tree=start_text(START)
            )
            assert self._result_of(client.send_goal_async(goal)).accepted
        assert self.tick < START

    def _spin_until(self, is_true: Callable[[], bool]) -> None:
        end = time.monotonic() + LIMIT
        while not is_true():
            assert time.monotonic() < end
            self.executor.spin_once(timeout_sec=0.05)

    def _result_of(self, future: Any) -> Any:
        self._spin_until(future.done)
        return future.result()

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()


def by_the_action(folder: Path, pack: int) -> str:
    flags = (
        "--world", OPTIONS["world"], "--swarm-size", str(OPTIONS["robots"]),
        "--seed", str(OPTIONS["seed"]), "--drive", OPTIONS["drive"], "--pack", str(pack),
        "--speed", SLOW, "--duration", str(SECONDS), "--headless", "--no-report",
        "--run-dir", "run",
    )  # fmt: skip
    command = "from swarm_commander.cli.main import swarm_up; swarm_up()"
    with reserved_domain() as domain, (folder / "up.log").open("w+", encoding="utf-8") as log:
        operator = Operator(domain)
        up = subprocess.Popen(
            (sys.executable, "-c", command, *flags), cwd=folder, stdout=log, stderr=log,
            env=os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)},
        )  # fmt: skip
        try:
            operator.pause()
            operator.send_goals()
            operator.go_on()
            assert up.wait(timeout=LIMIT) == 0, (folder / "up.log").read_text(encoding="utf-8")
        finally:
            operator.close()
            up.terminate()
    report = json.loads((folder / "run" / "report.json").read_text(encoding="utf-8"))
    assert report["late_ticks"] == 0
    return str(report["trajectory_sha256"])


def by_steps(swarm: Swarm) -> None:
    """Send the goals in a swarm of Python so that they begin at the same tick."""
    swarm.run(until=(START - 1) * CONTROL_PERIOD)
    for name, place in GOALS.items():
        swarm[name].go_to(place)
    swarm.run(until=SECONDS)


def in_the_bench() -> str:
    with Swarm(**OPTIONS, bench=True) as swarm:
        by_steps(swarm)
    assert swarm.report.goals_reached == len(GOALS)
    return hashlib.sha256(swarm.trajectories.true.tobytes()).hexdigest()


@pytest.fixture(scope="module")
def bench() -> str:
    """Hash of the run in the bench."""
    return in_the_bench()


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "pack", [pytest.param(1, marks=pytest.mark.long), 2, pytest.param(2, marks=pytest.mark.long)]
)
def test_goals_with_a_tick_repeat_and_are_those_of_the_bench(tmp_path, bench, pack):
    assert by_the_action(tmp_path, pack) == bench


@pytest.mark.long
@pytest.mark.timeout(600)
def test_goals_between_two_steps_of_a_swarm_repeat(tmp_path, bench, monkeypatch):
    found = []
    for run in ("first", "second"):
        with reserved_domain() as domain:
            monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
            with Swarm(**OPTIONS, run_dir=tmp_path / run) as swarm:
                by_steps(swarm)
            found.append(swarm.report.full["trajectory_sha256"])
    assert found == [bench] * 2
