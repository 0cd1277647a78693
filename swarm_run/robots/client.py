"""`RobotCommander`: one robot of a swarm driven from Python, in the manner of BasicNavigator.

Method names and units are those of Nav2's BasicNavigator. Unlike it, nothing here waits (except
`waitUntilNav2Active`) and any number of robots share one node. `send` sends goals of Nav2's other
actions::

    rclpy.init()
    node = rclpy.create_node("operator")
    robots = [RobotCommander(node, name) for name in ("Srobot1", "Srobot2")]
    for robot in robots:
        robot.waitUntilNav2Active()
        robot.goToPose(pose)
    while not all(robot.isTaskComplete() for robot in robots):
        rclpy.spin_once(node, timeout_sec=0.1)
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import NavigateToPose
from rclpy.node import Node
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import RELIABLE
from swarm_common.model.errors import SwarmError
from swarm_common.process.pipes import EventWriter
from swarm_run.robots.discovery import robots_in_graph
from swarm_run.robots.goal_client import GoalClient
from swarm_run.robots.robot_watch import RobotWatch, others
from swarm_run.robots.status_check import StatusCheck
from swarm_run.robots.swarm_watch import SwarmPatience, SwarmWatch, has_swarm
from swarm_run.robots.task import Task, TaskResult

TELL_AFTER = 2.0  # [s] of wall time after which a robot that is not seen is spoken of
POLL_PERIOD = 0.2  # [s] of wall time between two questions


class NotActiveError(SwarmError):
    """A navigator does not answer or is not active."""


class RobotCommander:
    """One robot, for one thread: the one that spins the node.

    Attributes:
        name: Its namespace, like ``Srobot3``.
        status: Its latest swarm_interfaces/RobotStatus; None before the first.
        task: Its latest task; None before the first.
    """

    def __init__(
        self,
        node: Node,
        namespace: str,
        on_status: Callable[[RobotStatus], None] | None = None,
        *,
        with_feedback: bool = True,
        door: StatusCheck | None = None,
        watches_swarm: bool = True,
    ) -> None:
        """Attach to a robot.

        Args:
            node: Node that all traffic goes through; spinning it is the caller's work.
            namespace: Namespace of the robot, like `Srobot3`.
            on_status: Called with every status.
            with_feedback: Whether tasks receive feedback; for many robots it costs more than
                all the rest of a client.
            door: Check of the statuses of all robots that the caller attaches to; this robot's
                if there is none.
            watches_swarm: Whether tasks end as failed when the robot or the swarm is gone; False
                for a caller that watches them.
        """
        self.name = namespace.strip("/")
        self.status: RobotStatus | None = None
        self.task: Task | None = None
        self._node = node
        self._on_status = on_status
        events = EventWriter(None)
        self._door = door or StatusCheck(Rejections(events, node.get_logger().warning))
        self._with_feedback = with_feedback
        self._watch = RobotWatch(node, self.name) if watches_swarm else None
        self._clients: dict[str, GoalClient] = {}
        self._subscription = node.create_subscription(
            RobotStatus, f"/{self.name}/status", self._receive_status, RELIABLE
        )
        self._initial_pose = node.create_publisher(
            PoseWithCovarianceStamped, f"/{self.name}/initialpose", RELIABLE
        )

    # Tasks; each replaces the one before

    def goToPose(self, pose: PoseStamped, behavior_tree: str = "") -> Task:
        """Drive to a pose; one in an obstacle is moved by up to `planner.tolerance`, 0.5 m.

        Args:
            pose: In the frame `map`, `odom` or `base_footprint`; an empty frame means `map`.
            behavior_tree: `ros_io.start_text(tick)` is when to set off; empty is at once.

        Returns:
            The task under way; a pose that makes no sense fails as refused, nothing is raised.
        """
        goal = NavigateToPose.Goal(pose=pose, behavior_tree=behavior_tree)
        return self.send("navigate_to_pose", NavigateToPose, goal)

    def send(
        self,
        action: str,
        action_type: type,
        goal: Any,
        on_end: Callable[[Task], None] | None = None,
    ) -> Task:
        """Send any goal to any action of the robot.

        Args:
            action: Name within the namespace, like `navigate_to_pose`.
            action_type: Class of the action, like `nav2_msgs.action.NavigateToPose`.
            goal: Message of the type `action_type.Goal`.
            on_end: Called with the task when it has ended.

        Returns:
            The task under way; `task` from now on.
        """
        self.task = Task(self._client(action, action_type), goal, on_end)
        return self.task

    def look(self) -> None:
        """Ask again for an answer that is overdue; call it from time to time."""
        if self.task is not None:
            is_busy = self.status is not None and not math.isnan(self.status.goal.x)
            self.task.look(is_busy)
            if self._watch is not None and not self.task.is_complete:
                reason = self._watch.look()
                if reason:
                    self.task.give_up(reason)
                    self._node.get_logger().error(f"{self.name}: {reason}")

    def ask(self) -> None:
        """Ask at once for the state of the current task: the robot was silent, or was restarted."""
        if self.task is not None:
            self.task.ask()

    def cancelTask(self) -> None:
        """Cancel the current task."""
        if self.task is not None:
            self.task.cancel()

    def forgetTask(self) -> None:
        """Forget the current task without cancelling it."""
        self.task = None

    def isTaskComplete(self) -> bool:
        """Return whether the task has ended; True before the first; spin the node."""
        self.look()
        return self.task is None or self.task.is_complete

    def getFeedback(self) -> Any:
        """Return the latest feedback message of the task, or None."""
        return None if self.task is None else self.task.feedback

    def getResult(self) -> TaskResult:
        """Return how the task ended."""
        return TaskResult.UNKNOWN if self.task is None else self.task.outcome

    # The rest

    def setInitialPose(self, initial_pose: PoseStamped) -> None:
        """Tell the robot where it is.

        Args:
            initial_pose: In the frame `map`, `odom` or `base_footprint`. One off the map is
                ignored, and so is (0, 0, 0) without a stamp, which a BasicNavigator sends whose
                user has set none.
        """
        message = PoseWithCovarianceStamped(header=initial_pose.header)
        message.pose.pose = initial_pose.pose
        self._initial_pose.publish(message)

    @property
    def is_connected(self) -> bool:
        """Whether what the robot says of its status arrives here."""
        return bool(self._subscription.get_publisher_count())

    def isReady(self) -> bool:
        """Whether goals of `goToPose` would arrive; never waits."""
        return bool(self._client("navigate_to_pose", NavigateToPose).server_is_ready())

    def offers(self, action: str, action_type: type) -> bool:
        """Whether goals of an action would arrive; never waits. The first call asks for it.

        Args:
            action: Name within the namespace, like `navigate_to_pose`.
            action_type: Class of the action, like `nav2_msgs.action.NavigateToPose`.
        """
        return self._client(action, action_type).server_is_ready()

    def waitUntilNav2Active(self, timeout: float = 60.0) -> None:
        """Wait until the navigator is active and takes goals, spinning the node.

        Args:
            timeout: [s] of wall time. The first start after an installation compiles for a minute
                or two.

        Raises:
            NotActiveError: If it does not become so.
            NoSwarmError: If no swarm is running.
            ConfigError: If one starts that does not come up.
            SwarmEndedError: If the swarm has ended.
        """
        start = time.monotonic()
        deadline, watch, is_told = start + timeout, SwarmWatch(self._node), False
        domain, log = self._node.context.get_domain_id(), self._node.get_logger()
        patience = SwarmPatience(domain, partial(has_swarm, domain), log.info)
        client = self._node.create_client(GetState, f"/{self.name}/bt_navigator/get_state")
        try:
            label = ""
            while label != "active" or not self.isReady():
                watch.check()
                now = time.monotonic()
                if not robots_in_graph(self._node):
                    patience.check(now - start)
                is_late = not label and now - start > TELL_AFTER
                absence = others(self._node, self.name) if is_late else ""
                if now > deadline:
                    state = f"the navigator of {self.name} is {label or 'silent'}"
                    raise NotActiveError(absence or f"{state} after {timeout:g} s")
                if absence and not is_told:
                    log.warning(f"{absence}; waiting for it")
                    is_told = True
                label = self._ask_state(client) or label
        finally:
            self._node.destroy_client(client)

    def _ask_state(self, client: Any) -> str:
        if not client.service_is_ready():
            rclpy.spin_once(self._node, timeout_sec=POLL_PERIOD)
            return ""
        future = client.call_async(GetState.Request())
        rclpy.spin_until_future_complete(self._node, future, timeout_sec=2.0)
        response = future.result() if future.done() else None
        if response is None or response.current_state.label != "active":
            rclpy.spin_once(self._node, timeout_sec=POLL_PERIOD)
        return str(response.current_state.label) if response is not None else ""

    def _client(self, action: str, action_type: type) -> GoalClient:
        if action not in self._clients:
            name, feedback = f"/{self.name}/{action}", self._with_feedback
            self._clients[action] = GoalClient(
                self._node, action_type, name, with_feedback=feedback
            )
        return self._clients[action]

    def _receive_status(self, message: RobotStatus) -> None:
        if not self._door.admits(self.name, message):
            return
        self.status = message
        if self._on_status is not None:
            self._on_status(message)
