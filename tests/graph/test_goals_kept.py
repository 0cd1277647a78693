"""What an action server keeps of its goals, and which of them it cancels."""

import time

import pytest
import rclpy
from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from nav2_msgs.action import Wait
from rclpy.context import Context
from rclpy.qos import qos_profile_action_status_default

from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.middleware.ros_poll import drain
from swarm_common.middleware.tick_action import RESULT_TIMEOUT, TickActionServer
from swarm_common.model.records import CONTROL_PERIOD
from swarm_nav.ros.bare_node import TickClock
from tests.fakes.ros_domains import reserved_domain

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


class Server:
    """The server of an action in this process, and a client of it."""

    def __init__(self, node, begin):
        self.executor = SafeExecutor(context=node.context)
        self.executor.add_node(node)
        self.clock = TickClock(node)
        self.clock.set(1)
        TickActionServer(node, Wait, "wait", lambda _: True, begin, lambda _: None)
        self._goals = node.create_client(Wait.Impl.SendGoalService, "wait/_action/send_goal")
        self._results = node.create_client(Wait.Impl.GetResultService, "wait/_action/get_result")
        self.cancels = node.create_client(CancelGoal, "wait/_action/cancel_goal")
        assert self.cancels.wait_for_service(20.0)
        assert self._goals.wait_for_service(20.0)
        assert self._results.wait_for_service(20.0)

    def send(self, number):
        assert self.try_to_send(number)
        self.settle(0.05)

    def try_to_send(self, number):
        request = Wait.Impl.SendGoalService.Request()
        request.goal_id.uuid = [number] * 16
        return self.wait_for(self._goals.call_async(request)).accepted

    def ask(self, number):
        request = Wait.Impl.GetResultService.Request()
        request.goal_id.uuid = [number] * 16
        return self._results.call_async(request)

    def wait_for(self, future):
        end = time.monotonic() + 20.0
        while not future.done():
            assert time.monotonic() < end
            drain(self.executor)
        return future.result()

    def settle(self, period):
        end = time.monotonic() + period
        while time.monotonic() < end:
            drain(self.executor)
            time.sleep(0.005)


def after(seconds):
    return round(seconds / CONTROL_PERIOD)


def test_goals_that_have_ended_are_forgotten(node):
    server = Server(
        node, lambda server, handle: server.finish(handle, Wait.Result(), succeeded=True)
    )
    listed = []
    node.create_subscription(
        GoalStatusArray,
        "wait/_action/status",
        lambda message: listed.append(len(message.status_list)),
        qos_profile_action_status_default,
    )
    server.settle(0.5)
    for number in range(GOALS):
        server.send(number)
    assert max(listed) == GOALS
    server.clock.set(after(RESULT_TIMEOUT + 5.0))
    server.settle(1.0)
    listed.clear()
    server.send(GOALS)
    assert listed, "the status of the new goal"
    assert max(listed) == 1
    server.executor.shutdown()


@pytest.mark.parametrize("duration", [1.0, 100.0, 1000.0])
def test_who_waits_for_the_result_of_a_goal_gets_it_however_long_it_takes(node, duration):
    begun = []
    server = Server(node, lambda *goal: begun.append(goal))
    server.send(0)
    result = server.ask(0)
    server.settle(0.2)
    server.clock.set(after(duration))
    server.settle(0.2)
    actions, handle = begun[0]
    actions.finish(handle, Wait.Result(), succeeded=True)
    assert server.wait_for(result).status == GoalStatus.STATUS_SUCCEEDED
    server.executor.shutdown()


def test_the_id_of_a_goal_that_is_forgotten_may_be_used_again(node):
    begun = []
    server = Server(node, lambda *goal: begun.append(goal))
    server.send(0)
    actions, old = begun[0]
    actions.finish(old, Wait.Result(), succeeded=True)
    server.settle(0.2)
    assert not server.try_to_send(0), "its result is kept"
    server.clock.set(after(RESULT_TIMEOUT + 5.0))
    server.send(0)
    result = server.ask(0)
    server.settle(0.2)
    actions.finish(begun[1][1], Wait.Result(), succeeded=True)
    assert server.wait_for(result).status == GoalStatus.STATUS_SUCCEEDED
    server.executor.shutdown()


def test_goals_are_canceled_by_id_by_stamp_or_all_together(node):
    begun = []
    server = Server(node, lambda *goal: begun.append(goal))
    for number in range(1, 6):
        server.clock.set(after(10.0 * number))
        server.send(number)

    def cancel(number=None, seconds=0):
        request = CancelGoal.Request()
        request.goal_info.stamp.sec = seconds
        if number is not None:
            request.goal_info.goal_id.uuid = [number] * 16
        response = server.wait_for(server.cancels.call_async(request))
        return response.return_code, [goal.goal_id.uuid[0] for goal in response.goals_canceling]

    assert cancel(5) == (CancelGoal.Response.ERROR_NONE, [5])
    assert cancel(5) == (CancelGoal.Response.ERROR_REJECTED, [])
    assert cancel(9) == (CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID, [])
    assert cancel(seconds=-5) == (CancelGoal.Response.ERROR_NONE, [])
    assert cancel(seconds=20) == (CancelGoal.Response.ERROR_NONE, [1, 2])
    actions, handle = begun[4]
    result = server.ask(5)
    server.settle(0.2)
    actions.finish(handle, Wait.Result(), succeeded=False)
    assert server.wait_for(result).status == GoalStatus.STATUS_CANCELED
    assert cancel(5) == (CancelGoal.Response.ERROR_GOAL_TERMINATED, [])
    assert cancel() == (CancelGoal.Response.ERROR_NONE, [3, 4])
    server.executor.shutdown()


def test_a_task_that_fails_does_not_end_the_process(node, capfd):
    executor = SafeExecutor(context=node.context)
    executor.add_node(node)

    async def fail_later():
        raise KeyError("later")

    def fail():
        raise KeyError("at once")

    for task in (fail, fail_later):
        executor.create_task(task)
        drain(executor)
        drain(executor)
    errors = capfd.readouterr().err
    assert "KeyError: 'at once'" in errors
    assert "KeyError: 'later'" in errors
    executor.shutdown()
