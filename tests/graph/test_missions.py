"""The mission process and `swarm-commander` over a real ROS graph of fake robots."""

import itertools
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from swarm_interfaces.msg import Mission, RobotStatus

from swarm_common.middleware.ros_io import LATCHED, RELIABLE, pose_stamped
from swarm_common.model.errors import NoSwarmError
from swarm_common.model.records import Pose
from swarm_run.domain import DomainLock
from swarm_run.robots.client import NotActiveError, RobotCommander
from swarm_run.robots.discovery import robot_on_mission
from swarm_run.robots.task import TaskResult

ROOT = Path(__file__).resolve().parents[2]
SITES = ROOT / "worlds" / "slim_blockage" / "sites.yaml"
DOMAIN = int(os.environ["ROS_DOMAIN_ID"])
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}
MODULE = "swarm_commander.mission.runner"


@pytest.fixture
def lock():
    owned = DomainLock(DOMAIN)
    yield owned
    owned.release()


@pytest.fixture
def robots(lock):
    """Yield a function that starts fake robots."""
    started: list[subprocess.Popen[bytes]] = []

    def start(*flags):
        command = (sys.executable, "-m", "tests.fakes.ros_robots", *flags)
        process = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE)
        started.append(process)
        assert process.stdout.readline() == b"ready\n"

    yield start
    for process in started:
        process.terminate()
        process.communicate(timeout=20)


def config_of(path, count, **changes):
    names = [f"Srobot{number}" for number in range(1, count + 1)]
    mission = changes.get("mission", "loading_route")
    config = {
        "robots": [
            {"name": name, "number": number, "mission": mission}
            for number, name in enumerate(names, 1)
        ],
        "homes": [[0.0, 0.0, 0.0] for _ in names],
        "mission": "loading_route",
        "sites": str(SITES),
        "seed": 0,
        "laps": 1,
        "goals_per_robot": 3,
        "stand_still_at_end": False,
    }
    path.write_text(json.dumps(config | changes), encoding="utf-8")
    return path


class Runner:
    """The mission process and what it says."""

    def __init__(self, config, name):
        module = ("-m", name, str(config))
        self.process = subprocess.Popen(
            (sys.executable, *module, "--event-fd", "1", "--control-fd", "0"),
            env=ENVIRONMENT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )

    def tell(self, command):
        self.process.stdin.write(json.dumps(command).encode() + b"\n")
        self.process.stdin.flush()

    def events_until(self, kind):
        events = []
        for line in self.process.stdout:
            events.append(json.loads(line))
            if events[-1]["event"] == kind:
                return events
        pytest.fail(f"it ended without {kind}")

    def close(self):
        self.process.terminate()
        self.process.communicate(timeout=10)
        assert self.process.returncode == 0


@pytest.fixture
def runner(tmp_path):
    """Yield a function that starts a mission process."""
    started: list[Runner] = []

    def start(count, module=MODULE, **changes):
        started.append(Runner(config_of(tmp_path / "mission.json", count, **changes), module))
        return started[-1]

    yield start
    for process in started:
        process.close()


def goals(events, robot):
    return [
        (event["event"], goal["sim_time"])
        for event in events
        if event["event"] in ("reached", "missed")
        and (goal := event.get("missed", event))["robot"] == robot
    ]


def test_goals_follow_each_other_at_exact_ticks(robots, runner):
    robots("3")
    events = runner(3).events_until("done")
    for name in ("Srobot1", "Srobot2", "Srobot3"):
        outcomes, times = zip(*goals(events, name), strict=True)
        assert outcomes == ("reached",) * 3
        # 20 ticks of driving after 0.2 s at the loader, whatever the machine was doing.
        steps = [after - before for before, after in itertools.pairwise(times)]
        assert steps == pytest.approx([2.2, 2.2])


def test_failed_goals_are_tried_again(robots, runner):
    robots("2", "--fail", "Srobot2")
    events = runner(2).events_until("done")
    assert [outcome for outcome, _ in goals(events, "Srobot2")] == ["reached"] * 3
    assert sum(event["event"] == "sent" for event in events) == 6


def test_a_silent_robot_loses_its_goals_and_the_others_go_on(robots, runner):
    robots("2", "--mute", "Srobot2")
    process = runner(2, "tests.fakes.hasty_runner", goals_per_robot=8)
    events = process.events_until("done")
    assert [outcome for outcome, _ in goals(events, "Srobot1")] == ["reached"] * 8
    assert [outcome for outcome, _ in goals(events, "Srobot2")][-1] == "missed"
    assert len(goals(events, "Srobot2")) == 8


def test_a_dead_robot_loses_its_goals_at_once(robots, runner):
    robots("2")
    process = runner(2)
    process.events_until("reached")
    process.tell({"cmd": "dead", "robot": "Srobot2"})
    events = process.events_until("done")
    assert [outcome for outcome, _ in goals(events, "Srobot2")][-1] == "missed"
    assert [outcome for outcome, _ in goals(events, "Srobot1")][-1] == "reached"


COMMANDER = "from swarm_commander.cli.main import commander; commander()"
# As if converting a message had met the exception.
CHANGES_EXCEPTIONS = """
import rclpy

spin_once = rclpy.spin_once

def spin(*args, **options):
    try:
        spin_once(*args, **options)
    except KeyboardInterrupt:
        raise RuntimeError("error return without exception set")

rclpy.spin_once = spin
"""


def start_commander(*flags, code=COMMANDER):
    return subprocess.Popen(
        (sys.executable, "-c", code, *flags),
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def commander(*flags):
    process = start_commander(*flags)
    try:
        output, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    return subprocess.CompletedProcess(process.args, process.returncode, output, errors)


@pytest.fixture
def operator():
    rclpy.init(domain_id=DOMAIN, signal_handler_options=rclpy.SignalHandlerOptions.NO)
    node = rclpy.create_node("operator", enable_rosout=False)
    yield node
    node.destroy_node()
    rclpy.shutdown()


def test_the_commander_drives_a_robot_and_says_how_it_goes(robots):
    robots("2")
    result = commander("Srobot2")
    assert result.returncode == 0, result.stderr
    assert "holding for loader_3, place 2" in result.stdout
    assert "to go" in result.stdout
    assert result.stdout.index("shipping: reached") < result.stdout.index("home: reached")


@pytest.mark.parametrize("code", [COMMANDER, CHANGES_EXCEPTIONS + COMMANDER])
def test_ctrl_c_ends_a_mission(robots, operator, code):
    """The cancelled goal counted as failed, and was sent again: the robot drove on."""
    robots("1")
    process = start_commander("Srobot1", code=code)
    while "holding" not in process.stdout.readline():
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=20.0)
    assert process.returncode == 130, output + errors
    after = output.partition("stopping: goals are cancelled")[2]
    assert after == "\n"
    goals: list[float] = []
    operator.create_subscription(
        RobotStatus, "/Srobot1/status", lambda s: goals.append(s.goal.x), RELIABLE
    )
    while len(goals) < 2:
        rclpy.spin_once(operator, timeout_sec=0.1)
    assert math.isnan(goals[-1])


def test_the_commander_notices_that_the_swarm_has_ended(robots, lock):
    robots("1", "--homes", "--mute", "Srobot1")
    process = start_commander("Srobot1")
    assert "sent" in process.stdout.readline()
    lock.release()
    try:
        _, errors = process.communicate(timeout=10.0)
    finally:
        process.kill()
    assert errors == "swarm-commander: the swarm has ended\n"
    assert process.returncode == 3


def test_a_task_ends_with_the_swarm(robots, lock, operator):
    robots("1", "--mute", "Srobot1")
    robot = RobotCommander(operator, "Srobot1")
    while not robot.isReady():
        rclpy.spin_once(operator, timeout_sec=0.1)
    task = robot.goToPose(pose_stamped(Pose(1.5, -2.0, 0.0), 0))
    assert not robot.isTaskComplete()
    lock.release()
    end = time.monotonic() + 10.0
    while not robot.isTaskComplete():
        assert time.monotonic() < end
        rclpy.spin_once(operator, timeout_sec=0.1)
    assert (robot.getResult(), task.reason) == (TaskResult.FAILED, "the swarm has ended")


def test_a_task_for_a_robot_that_is_not_there_fails(robots, operator):
    robots("1")
    robot = RobotCommander(operator, "Srobot7")
    task = robot.goToPose(pose_stamped(Pose(1.5, -2.0, 0.0), 0))
    end = time.monotonic() + 20.0
    while not robot.isTaskComplete():
        assert time.monotonic() < end
        rclpy.spin_once(operator, timeout_sec=0.1)
    assert robot.getResult() is TaskResult.FAILED
    assert task.reason == "no robot 'Srobot7' is running; there are Srobot1"


def test_without_a_swarm_nobody_is_waited_for(operator):
    with pytest.raises(NoSwarmError, match="no swarm is running in ROS domain"):
        RobotCommander(operator, "Srobot1").waitUntilNav2Active()


def test_a_wait_for_a_robot_that_is_not_there_names_the_others(robots, operator):
    robots("2")
    with pytest.raises(NotActiveError, match="no robot 'Srobot22' is running; there are Srobot1"):
        RobotCommander(operator, "Srobot22").waitUntilNav2Active(timeout=4.0)


def test_a_robot_on_a_mission_is_left_alone_but_takes_a_goal(robots, runner):
    robots("1")
    process = runner(1, goals_per_robot=None, laps=1000)  # not over before the end of the test
    events = process.events_until("reached")
    refused = commander("Srobot1")
    assert refused.returncode == 2, refused.stdout
    assert "is on a mission already" in refused.stderr
    taken = commander("Srobot1", "--goal", "1.5", "-2", "0")
    assert taken.returncode == 0, taken.stderr
    reached_at = float(taken.stdout.partition("reached at t = ")[2].split()[0])
    while goals(events, "Srobot1")[-1][1] < reached_at + 5.0:
        events += process.events_until("reached")
    # The mission went on; its goal that gave way was sent again and not counted as missed.
    outcomes = [outcome for outcome, _ in goals(events, "Srobot1")]
    assert outcomes == ["reached"] * len(outcomes)
    assert sum(event["event"] == "sent" for event in events) == len(outcomes)


def test_a_mission_is_seen_before_it_is_discovered(operator):
    others = rclpy.Context()
    rclpy.init(context=others, domain_id=DOMAIN)
    node = rclpy.create_node("mission", context=others, enable_rosout=False)
    try:
        publisher = node.create_publisher(Mission, "/Srobot1/mission", LATCHED)
        publisher.publish(Mission(active=True))
        assert robot_on_mission(operator, ["Srobot2", "Srobot1"]) == "Srobot1"
    finally:
        node.destroy_node()
        rclpy.shutdown(context=others)


def test_a_robot_whose_mission_is_over_takes_another(robots, runner):
    robots("1")
    runner(1, goals_per_robot=1).events_until("done")
    again = commander("Srobot1")
    assert again.returncode == 0, again.stderr
    assert "home: reached" in again.stdout


@pytest.mark.parametrize(("flags", "home"), [((), (1.0, 0.0)), (("--homes",), (1.0, 7.0))])
def test_home_is_where_a_robot_was_started_if_it_knows(robots, operator, flags, home):
    robots("1", *flags)
    goals: list[tuple[float, float]] = []
    operator.create_subscription(
        RobotStatus, "/Srobot1/status", lambda s: goals.append((s.goal.x, s.goal.y)), RELIABLE
    )
    process = start_commander("Srobot1")
    while process.poll() is None:
        rclpy.spin_once(operator, timeout_sec=0.1)
    output, errors = process.communicate()
    assert process.returncode == 0, output + errors
    assert [goal for goal in goals if not math.isnan(goal[0])][-1] == home


@pytest.mark.parametrize("with_feedback", [True, False])
def test_only_who_wants_feedback_gets_it(robots, operator, with_feedback):
    robots("1")
    robot = RobotCommander(operator, "Srobot1", with_feedback=with_feedback)
    deadline = time.monotonic() + 20.0
    while not robot.isReady() and time.monotonic() < deadline:
        rclpy.spin_once(operator, timeout_sec=0.1)
    robot.goToPose(pose_stamped(Pose(1.5, -2.0, 0.0), 0))
    while not robot.isTaskComplete() and time.monotonic() < deadline:
        rclpy.spin_once(operator, timeout_sec=0.1)
    assert robot.getResult() is TaskResult.SUCCEEDED
    assert (robot.getFeedback() is not None) == with_feedback


def test_an_unknown_robot_lists_those_that_run(robots):
    robots("2")
    result = commander("Srobot7")
    assert result.returncode == 2
    assert result.stderr == (
        "swarm-commander: no robot 'Srobot7' is running; there are Srobot1, Srobot2\n"
    )
    misspelt = commander("spwan", "crate")
    assert "did you mean the command spawn?" in misspelt.stderr


def test_without_a_swarm_the_commander_says_so_within_seconds():
    start = time.monotonic()
    result = commander("Srobot1")
    assert result.returncode == 2
    assert f"no swarm is running in ROS domain {DOMAIN}" in result.stderr
    assert time.monotonic() - start < 50.0  # 6 s where nothing else runs
