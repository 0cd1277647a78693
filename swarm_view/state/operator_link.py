"""Commands of a page to the swarm: goals, poses, pause, speed, robots. Nothing here waits."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any
from uuid import uuid4

import numpy as np
from action_msgs.srv import CancelGoal
from geometry_msgs.msg import PoseWithCovarianceStamped
from geometry_msgs.msg import Twist as TwistMsg
from nav2_msgs.action import AssistedTeleop, NavigateToPose
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntitiesStates,
    GetSimulationState,
    SetEntityState,
    SetSimulationState,
    SpawnEntity,
    StepSimulation,
)
from std_msgs.msg import Empty
from unique_identifier_msgs.msg import UUID

from swarm_common.middleware import ros_io
from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.middleware.ros_io import resource_in
from swarm_common.middleware.ros_poll import drain
from swarm_common.model.records import FloatArray, Pose, Twist

POSITION_VARIANCE, YAW_VARIANCE = 0.25, 0.0685  # what RViz's tool sends
PATIENCE = 5.0  # [s] of wall time in which a listener must appear
ASK_PERIOD = 1.0  # [s] of wall time between two looks at the state of the simulation
Tell = Callable[[str], None]  # shows the outcome of an order to the user who gave it


class OperatorLink:
    """Publishers and clients of a node, made when they are first needed.

    Attributes:
        is_paused: None before the world has said it.
        speed: Times real time, 0 for no limit; None before the world has said it.
    """

    def __init__(self, node: Node) -> None:
        self.is_paused: bool | None = None
        self.speed: float | None = None
        self._node = node
        self._executor = SafeExecutor()
        self._executor.add_node(node)
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self._waiting: list[tuple[float, Callable[[], bool], str, Tell]] = []
        self._asked = float("-inf")
        self._busy: set[str] = set()
        self._full_speeds: dict[str, Twist] = {}

    def turn(self, now: float) -> None:
        """Process answers, orders that wait for a listener, and the world's state."""
        drain(self._executor)
        waiting, self._waiting = self._waiting, []
        for deadline, attempt, what, tell in waiting:
            deadline = deadline or now + PATIENCE
            if attempt():
                continue
            if now < deadline:
                self._waiting.append((deadline, attempt, what, tell))
            else:
                tell(f"Nobody takes {what}.")
        if now - self._asked > ASK_PERIOD:
            self._asked = now
            self._ask_world()

    def _ask_world(self) -> None:
        def receive_state(response: Any) -> None:
            self.is_paused = response.state.state == SimulationState.STATE_PAUSED

        def receive_speed(response: Any) -> None:
            if response.values and response.values[0].type == ParameterType.PARAMETER_DOUBLE:
                self.speed = response.values[0].double_value

        self._ask("/sim/get_simulation_state", GetSimulationState, None, receive_state)
        request = GetParameters.Request(names=["speed"])
        self._ask("/sim/world/get_parameters", GetParameters, request, receive_speed)

    def send_goal(self, robot: str, goal_map: Pose, tell: Tell) -> None:
        """Send a robot somewhere, by the action that missions use; so it can be cancelled."""
        kind = NavigateToPose.Impl.SendGoalService
        request = kind.Request(goal_id=UUID(uuid=list(uuid4().bytes)))
        request.goal.pose.pose = ros_io.pose_msg(goal_map)
        request.goal.pose.header.frame_id = "map"

        def done(response: Any) -> None:
            if not response.accepted:
                tell(f"{robot} rejects the goal.")

        name = f"/{robot}/navigate_to_pose/_action/send_goal"
        self._call(name, kind, request, f"goals for {robot}", tell, done)

    def set_initial_pose(self, robot: str, pose_map: Pose, tell: Tell) -> None:
        """Tell a robot where it is, as RViz's tool does."""
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose = ros_io.pose_msg(pose_map)
        message.pose.covariance[0] = message.pose.covariance[7] = POSITION_VARIANCE
        message.pose.covariance[35] = YAW_VARIANCE
        self._publish(f"/{robot}/initialpose", message, tell)

    def cancel(self, robot: str, tell: Tell) -> None:
        """Cancel the goal of a robot, including goals of other clients."""

        def done(response: Any) -> None:
            count = len(response.goals_canceling)
            tell(f"{robot}: {'goal cancelled' if count else 'there is no goal to cancel'}.")

        # A request with neither goal id nor stamp cancels all goals of the action.
        name = f"/{robot}/navigate_to_pose/_action/cancel_goal"
        what = f"the cancellation for {robot}"
        self._call(name, CancelGoal, CancelGoal.Request(), what, tell, done)

    def set_paused(self, paused: bool, tell: Tell) -> None:
        """Pause the world or let it go on."""
        state = SimulationState.STATE_PAUSED if paused else SimulationState.STATE_PLAYING
        request = SetSimulationState.Request(state=SimulationState(state=state))
        name = "/sim/set_simulation_state"
        self._call(name, SetSimulationState, request, "pause and resume", tell)
        self._asked = float("-inf")

    def step(self, ticks: int, tell: Tell) -> None:
        """Let a paused world do a few ticks."""
        request = StepSimulation.Request(steps=ticks)
        self._call("/sim/step_simulation", StepSimulation, request, "steps", tell)

    def set_speed(self, speed: float, tell: Tell) -> None:
        """Set the world's speed in times real time; 0 for as fast as possible."""
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=float(speed))
        request = SetParameters.Request(parameters=[ParameterMsg(name="speed", value=value)])
        self._call("/sim/world/set_parameters", SetParameters, request, "the speed", tell)
        self.speed = speed

    def spawn(self, model: str, pose_map: Pose | None, tell: Tell) -> None:
        """Add a robot; without a pose at a free place of the start area."""
        request = SpawnEntity.Request()
        resource_in(request).uri = model
        request.initial_pose.header.frame_id = "spawn" if pose_map is None else "map"
        if pose_map is not None:
            request.initial_pose.pose = ros_io.pose_msg(pose_map)
        self._call(
            "/sim/spawn_entity", SpawnEntity, request, "new robots", tell,
            lambda response: tell(f"{response.entity_name} has come."),
        )  # fmt: skip

    def move(
        self, name: str, robots: Collection[str], start_map: FloatArray, end_map: FloatArray,
        yaw: float | None, tell: Tell,
    ) -> None:  # fmt: skip
        """Put something at `end_map` (2,) in map.

        Args:
            name: Name of a robot; empty for the object that is nearest to `start_map` (2,).
            robots: Names of those that are no objects.
            yaw: [rad] in map; None to leave it as it is.
        """

        def choose(response: Any) -> None:
            found = {
                entity: state
                for entity, state in zip(response.entities, response.states, strict=True)
                if (entity == name if name else entity not in robots)
            }
            places = {
                entity: np.hypot(
                    state.pose.position.x - start_map[0], state.pose.position.y - start_map[1]
                )
                for entity, state in found.items()
            }
            entity = min(places, key=places.__getitem__, default="")
            if not entity:
                tell(f"There is no {name or 'object'} to move.")
                return
            request = SetEntityState.Request(entity=entity)
            request.state.pose = found[entity].pose
            request.state.pose.position.x, request.state.pose.position.y = map(float, end_map)
            if yaw is not None:
                request.state.pose.orientation = ros_io.pose_msg(Pose(0.0, 0.0, yaw)).orientation
            self._call(
                "/sim/set_entity_state", SetEntityState, request, f"the move of {entity}", tell,
                lambda _: tell(f"{entity} is at ({end_map[0]:.2f}, {end_map[1]:.2f}) now."),
            )  # fmt: skip

        self._call(
            "/sim/get_entities_states", GetEntitiesStates, GetEntitiesStates.Request(),
            "moves", tell, choose,
        )  # fmt: skip

    def remove(self, robot: str, tell: Tell) -> None:
        """Remove a robot from the world; its navigator ends."""
        self._call(
            "/sim/delete_entity", DeleteEntity, DeleteEntity.Request(entity=robot),
            f"the removal of {robot}", tell, lambda _: tell(f"{robot} was taken out."),
        )  # fmt: skip

    def begin_drive(self, robot: str, tell: Tell, on_end: Callable[[], None]) -> None:
        """Ask a robot to be driven by hand; `on_end` is called when it is not any more."""
        send, get = AssistedTeleop.Impl.SendGoalService, AssistedTeleop.Impl.GetResultService
        action = f"/{robot}/assisted_teleop/_action"
        identifier = UUID(uuid=list(uuid4().bytes))
        request = GetParameters.Request(names=["max_vel_x", "max_vel_theta"])

        def learn(response: Any) -> None:
            if len(response.values) == 2:
                values = [value.double_value for value in response.values]
                self._full_speeds[robot] = Twist(values[0], 0.0, values[1])

        def ended(response: Any) -> None:
            message = getattr(response.result, "error_msg", "")
            tell(f"{robot} is on its own again{f': {message}' if message else '.'}")
            on_end()

        def done(response: Any) -> None:
            if not response.accepted:
                tell(f"{robot} cannot be driven by hand; is its navigator active?")
                on_end()
                return
            tell(f"{robot} is yours.")
            self._call(
                f"{action}/get_result", get, get.Request(goal_id=identifier), "a result", tell,
                ended, heeds_problems=False,
            )  # fmt: skip

        self._ask(f"/{robot}/navigator/get_parameters", GetParameters, request, learn)
        goal = send.Request(goal_id=identifier)
        self._call(f"{action}/send_goal", send, goal, f"driving {robot} by hand", tell, done)

    def full_speed(self, robot: str) -> Twist | None:
        """Return a robot's full speed; None before it is known."""
        return self._full_speeds.get(robot)

    def wish(self, robot: str, twist: Twist) -> None:
        """Say how a robot that is driven by hand is to drive."""
        message = TwistMsg()
        message.linear.x, message.angular.z = twist.vx, twist.wz
        self._publisher(f"/{robot}/cmd_vel_teleop", TwistMsg).publish(message)

    def end_drive(self, robot: str) -> None:
        """Give a robot back to its mission."""
        self._publisher(f"/{robot}/preempt_teleop", Empty).publish(Empty())

    def close(self) -> None:
        """Stop; the node is its owner's to destroy."""
        self._executor.shutdown()

    def _publish(self, topic: str, message: Any, tell: Tell) -> None:
        publisher = self._publisher(topic, type(message))

        def attempt() -> bool:
            if publisher.get_subscription_count() == 0:
                return False
            publisher.publish(message)
            return True

        self._waiting.append((0.0, attempt, topic, tell))

    def _publisher(self, topic: str, kind: Any) -> Any:
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(kind, topic, ros_io.RELIABLE)
        return self._publishers[topic]

    def _call(
        self, name: str, kind: Any, request: Any, what: str, tell: Tell,
        done: Callable[[Any], None] | None = None, *, heeds_problems: bool = True,
    ) -> None:  # fmt: skip
        """Call a service when it is there; `done` gets the answer, `tell` a refusal."""
        client = self._client(name, kind)

        def take(future: Any) -> None:
            response = future.result()
            problem = _problem_in(response) if heeds_problems else ""
            if problem:
                tell(problem)
            elif done is not None:
                done(response)

        def attempt() -> bool:
            if not client.service_is_ready():
                return False
            client.call_async(request).add_done_callback(take)
            return True

        self._waiting.append((0.0, attempt, what, tell))

    def _ask(self, name: str, kind: Any, request: Any, take: Callable[[Any], None]) -> None:
        """Ask a question if it can be answered and the last one has been."""
        client = self._client(name, kind)
        if name in self._busy or not client.service_is_ready():
            return
        self._busy.add(name)

        def done(future: Any) -> None:
            self._busy.discard(name)
            take(future.result())

        client.call_async(request or kind.Request()).add_done_callback(done)

    def _client(self, name: str, kind: Any) -> Any:
        if name not in self._clients:
            self._clients[name] = self._node.create_client(kind, name)
        return self._clients[name]


def _problem_in(response: Any) -> str:
    """Return why a service refused; empty if it did not."""
    result = getattr(response, "result", None)
    if result is not None and result.result != Result.RESULT_OK:
        return str(result.error_message) or f"refused (code {result.result})"
    refused = [one.reason for one in getattr(response, "results", ()) if not one.successful]
    return "; ".join(refused)
