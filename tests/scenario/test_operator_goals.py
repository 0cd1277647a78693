"""An operator's goals repeat: with a tick at which they begin, or in a swarm that is stepped."""

import hashlib
import time
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

LIMIT = 90.0  # [s] of wall time, on a busy machine
START = 100  # tick at which the goals begin
SECONDS = 70.0  # of a run
OPTIONS: dict[str, Any] = {"world": "doorway", "robots": 2, "seed": 2, "drive": "planar"}
GOALS = {"Srobot1": (4.5, -1.5, 0.0), "Srobot2": (4.5, 1.5, 0.0)}  # through the door
SLOW = "1"  # times real time until the operator has paused the world


class Operator:
    """A client of our own in a swarm's domain."""

    def __init__(self, domain):
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("operator", context=self.context, enable_rosout=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.tick = 0
        self.node.create_subscription(RobotStatus, "/Srobot1/status", self._hear, 10)

    def _hear(self, status):
        self.tick = tick_of(status.stamp)

    def pause(self):
        self._set_state(SimulationState.STATE_PAUSED)

    def go_on(self):
        client = AsyncParameterClient(self.node, "/sim/world")
        self._spin_until(client.services_are_ready)
        answer = self._result_of(client.set_parameters([Parameter("speed", value=0.0)]))
        assert answer.results[0].successful
        self._set_state(SimulationState.STATE_PLAYING)

    def _set_state(self, state):
        client = self.node.create_client(SetSimulationState, "/sim/set_simulation_state")
        self._spin_until(client.service_is_ready)
        request = SetSimulationState.Request(state=SimulationState(state=state))
        assert self._result_of(client.call_async(request)).result.result == Result.RESULT_OK

    def send_goals(self):
        """Send all goals by their action, before they begin."""
        for name, place in GOALS.items():
            client = ActionClient(self.node, NavigateToPose, f"/{name}/navigate_to_pose")
            self._spin_until(client.server_is_ready)
            goal = NavigateToPose.Goal(
                pose=pose_stamped(Pose(*place), 0), behavior_tree=start_text(START)
            )
            assert self._result_of(client.send_goal_async(goal)).accepted
        assert self.tick < START

    def _spin_until(self, is_true):
        end = time.monotonic() + LIMIT
        while not is_true():
            assert time.monotonic() < end
            self.executor.spin_once(timeout_sec=0.05)

    def _result_of(self, future):
        self._spin_until(future.done)
        return future.result()

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()


def by_the_action(start, pack):
    swarm = start(
        "--world", OPTIONS["world"], "--swarm-size", str(OPTIONS["robots"]),
        "--seed", str(OPTIONS["seed"]), "--drive", OPTIONS["drive"], "--pack", str(pack),
        "--speed", SLOW, "--duration", str(SECONDS), "--headless", "--no-report",
    )  # fmt: skip
    operator = Operator(int(swarm.environment["ROS_DOMAIN_ID"]))
    try:
        operator.pause()
        operator.send_goals()
        operator.go_on()
        report = swarm.good_report(LIMIT)
    finally:
        operator.close()
    assert report["late_ticks"] == 0
    return report["trajectory_sha256"]


def by_steps(swarm):
    swarm.run(until=(START - 1) * CONTROL_PERIOD)
    for name, place in GOALS.items():
        swarm[name].go_to(place)
    swarm.run(until=SECONDS)


def in_the_bench():
    with Swarm(**OPTIONS, bench=True) as swarm:
        by_steps(swarm)
    assert swarm.report.goals_reached == len(GOALS)
    return hashlib.sha256(swarm.trajectories.true.tobytes()).hexdigest()


@pytest.fixture(scope="module")
def bench():
    """Hash of the run in the bench."""
    return in_the_bench()


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "pack", [pytest.param(1, marks=pytest.mark.long), 2, pytest.param(2, marks=pytest.mark.long)]
)
def test_goals_with_a_tick_repeat_and_are_those_of_the_bench(start, bench, pack):
    assert by_the_action(start, pack) == bench


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
