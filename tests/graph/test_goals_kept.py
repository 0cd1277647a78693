"""What an action server keeps of goals that have ended: not for ever."""

from __future__ import annotations

import time

import pytest
import rclpy
from action_msgs.msg import GoalStatusArray
from nav2_msgs.action import Wait
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.qos import qos_profile_action_status_default

from swarm_common.records import CONTROL_PERIOD
from swarm_common.ros_poll import drain
from swarm_nav.goals import Outcome
from swarm_nav.ros_actions import RESULT_TIMEOUT, TickActionServer
from swarm_nav.ros_clock import TickClock
from tests.graph.conftest import reserved_domain

GOALS = 20


@pytest.fixture
def node():
    with reserved_domain() as domain:
        context = Context()
        rclpy.init(context=context, domain_id=domain)
        node = rclpy.create_node("navigator", context=context, enable_rosout=False)
        yield node
        node.destroy_node()
        context.try_shutdown()


def test_goals_that_have_ended_are_forgotten(node):
    executor = EventsExecutor(context=node.context)
    executor.add_node(node)
    clock = TickClock(node)
    clock.set(1)

    def begin(server, handle):
        server.finish(handle, Outcome.SUCCEEDED, Wait.Result())

    TickActionServer(node, Wait, "wait", lambda _: True, begin, lambda _: None)
    listed = []
    node.create_subscription(
        GoalStatusArray,
        "wait/_action/status",
        lambda message: listed.append(len(message.status_list)),
        qos_profile_action_status_default,
    )
    client = node.create_client(Wait.Impl.SendGoalService, "wait/_action/send_goal")
    assert client.wait_for_service(20.0)

    def send(number: int) -> None:
        request = Wait.Impl.SendGoalService.Request()
        request.goal_id.uuid = [number] * 16
        future = client.call_async(request)
        end = time.monotonic() + 20.0
        while not future.done():
            assert time.monotonic() < end
            drain(executor)
        assert future.result().accepted
        settle(0.05)

    def settle(period: float) -> None:
        end = time.monotonic() + period
        while time.monotonic() < end:
            drain(executor)
            time.sleep(0.005)

    for number in range(GOALS):
        send(number)
    assert max(listed) == GOALS
    ticks = round((RESULT_TIMEOUT + 5.0) / CONTROL_PERIOD)
    clock.set(ticks)
    settle(1.0)
    listed.clear()
    send(GOALS)
    assert listed, "the status of the new goal"
    assert max(listed) == 1
    executor.shutdown()
