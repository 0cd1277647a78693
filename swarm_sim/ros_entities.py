"""simulation_interfaces' services about entities: spawn, delete, list, move, reset.

Questions are answered at once. Changes wait until `apply` is called, between two ticks.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Protocol

from geometry_msgs.msg import Accel
from geometry_msgs.msg import Pose as PoseMsg
from geometry_msgs.msg import Twist as TwistMsg
from rclpy.node import Node
from simulation_interfaces.msg import EntityCategory, EntityFilters, EntityState, Result
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityState,
    ResetSimulation,
    SetEntityState,
    SpawnEntity,
)

from swarm_common import ros_io
from swarm_common.records import Pose, Twist
from swarm_common.ros_poll import PolledService
from swarm_sim.changing_world import ChangingWorld
from swarm_sim.crew import Arrival, Crew, Reason, RefusedError
from swarm_sim.ros_scenery import quaternion
from swarm_sim.things import upright

MAP, SPAWN = "map", "spawn"
FRAMES = ("", MAP, "world")  # which all mean the same
RESULTS = {
    Reason.UNKNOWN: Result.RESULT_NOT_FOUND,
    Reason.UNSUPPORTED: Result.RESULT_FEATURE_UNSUPPORTED,
    Reason.FAILED: Result.RESULT_OPERATION_FAILED,
    Reason.NAME_TAKEN: SpawnEntity.Response.NAME_NOT_UNIQUE,
    Reason.NAME_INVALID: SpawnEntity.Response.NAME_INVALID,
    Reason.NO_MODEL: SpawnEntity.Response.NO_RESOURCE,
    Reason.BAD_MODEL: SpawnEntity.Response.RESOURCE_PARSE_ERROR,
    Reason.BAD_PLACE: SpawnEntity.Response.INVALID_POSE,
}
STATE, SPAWNED = ResetSimulation.Request.SCOPE_STATE, ResetSimulation.Request.SCOPE_SPAWNED


class Host(Protocol):
    """Who has to know what changed."""

    def on_arrival(self, arrival: Arrival) -> None:
        """A robot has come."""

    def on_removal(self, robot: int) -> None:
        """A robot has been taken out."""

    def on_move(self, robot: int, pose_map: Pose) -> None:
        """A robot has been put elsewhere."""


class Entities:
    """The services `/sim/spawn_entity`, `delete_entity`, `get_entities`, ..."""

    def __init__(self, node: Node, world: ChangingWorld, crew: Crew, host: Host) -> None:
        """Offer the services."""
        self._world, self._crew, self._host = world, crew, host
        ask = node.create_service
        ask(GetEntities, "/sim/get_entities", self._list)
        ask(GetEntitiesStates, "/sim/get_entities_states", self._list_states)
        ask(GetEntityState, "/sim/get_entity_state", self._state)
        changes: tuple[tuple[Any, str, Callable[[Any, Any], None]], ...] = (
            (SpawnEntity, "/sim/spawn_entity", self._spawn),
            (DeleteEntity, "/sim/delete_entity", self._delete),
            (SetEntityState, "/sim/set_entity_state", self._move),
            (ResetSimulation, "/sim/reset_simulation", self._reset),
        )
        self._changes = [
            (PolledService(node, kind, name), kind, handle) for kind, name, handle in changes
        ]

    def destroy(self) -> None:
        """Withdraw what the node does not destroy itself."""
        for service, _, _ in self._changes:
            service.destroy()

    def apply(self) -> None:
        """Make the changes that were asked for; call it between two ticks."""
        for service, kind, handle in self._changes:
            while (taken := service.take()) is not None:
                request, request_id = taken
                response = kind.Response()
                response.result.result = Result.RESULT_OK
                try:
                    handle(request, response)
                except RefusedError as error:
                    response.result.result = RESULTS[error.reason]
                    response.result.error_message = str(error)
                service.answer(response, request_id)

    # Changes

    def _spawn(self, request: Any, response: Any) -> None:
        name = request.name
        if request.entity_namespace and name and request.entity_namespace.strip("/") != name:
            response.result.result = SpawnEntity.Response.NAMESPACE_INVALID
            response.result.error_message = "a robot's namespace is its name; leave it empty"
            return
        model = request.entity_resource.uri
        if not model and request.entity_resource.resource_string:
            response.result.result = SpawnEntity.Response.UNSUPPORTED_FORMAT
            response.result.error_message = "descriptions as text are not read; give a uri"
            return
        stamped = request.initial_pose
        at_start = stamped.header.frame_id == SPAWN
        pose = None if at_start else self._pose(stamped.header.frame_id, stamped.pose)
        arrival = self._crew.spawn(
            name or request.entity_namespace.strip("/"),
            request.allow_renaming,
            model.removeprefix("file://"),
            pose,
        )
        self._host.on_arrival(arrival)
        response.entity_name = arrival.name

    def _delete(self, request: Any, _: Any) -> None:
        self._host.on_removal(self._crew.remove(request.entity))

    def _move(self, request: Any, response: Any) -> None:
        name, state = request.entity, request.state
        pose = self._pose(state.header.frame_id, state.pose)
        if name in self._crew.things:
            self._crew.move_thing(name, upright(pose.x, pose.y, state.pose.position.z, pose.yaw))
            return
        try:
            robot = self._crew.move(name, pose)
        except RefusedError as error:
            if error.reason is not Reason.BAD_PLACE:
                raise
            response.result.result = SetEntityState.Response.INVALID_POSE
            response.result.error_message = str(error)
            return
        self._host.on_move(robot, pose)

    def _reset(self, request: Any, response: Any) -> None:
        scope = request.scope or STATE | SPAWNED
        if scope & ~(STATE | SPAWNED):
            raise RefusedError(
                Reason.UNSUPPORTED,
                "simulated time cannot begin again; the scopes are 2 (poses), 4 (what was "
                "spawned) or both, which is the default",
            )
        if scope & SPAWNED:
            for name in self._crew.spawned:
                self._host.on_removal(self._crew.remove(name))
        if scope & STATE:
            for robot, home in self._crew.send_home():
                self._host.on_move(robot, home)

    @staticmethod
    def _pose(frame: str, message: PoseMsg) -> Pose:
        if frame not in FRAMES:
            raise RefusedError(
                Reason.BAD_PLACE, f"poses are in the frame '{MAP}'; '{frame}' is not known"
            )
        try:
            return ros_io.pose_from_msg(message)
        except ValueError as error:
            raise RefusedError(Reason.BAD_PLACE, str(error)) from error

    # Questions

    def _list(self, request: Any, response: Any) -> Any:
        try:
            response.entities = self._matching(request.filters)
            response.result.result = Result.RESULT_OK
        except RefusedError as error:
            response.result.result = RESULTS[error.reason]
            response.result.error_message = str(error)
        return response

    def _list_states(self, request: Any, response: Any) -> Any:
        self._list(request, response)
        response.states = [self._state_of(name) for name in response.entities]
        return response

    def _state(self, request: Any, response: Any) -> Any:
        try:
            response.state = self._state_of(request.entity)
            response.result.result = Result.RESULT_OK
        except RefusedError as error:
            response.result.result = RESULTS[error.reason]
            response.result.error_message = str(error)
        return response

    def _matching(self, filters: EntityFilters) -> list[str]:
        if filters.tags.tags or filters.bounds.points:
            raise RefusedError(Reason.UNSUPPORTED, "filters by tags and bounds are not supported")
        try:
            pattern = re.compile(filters.filter)
        except re.error as error:
            raise RefusedError(
                Reason.FAILED, f"'{filters.filter}' is no regular expression: {error}"
            ) from error
        wanted = {category.category for category in filters.categories}
        kinds = (
            (EntityCategory.CATEGORY_ROBOT, self._crew.robots),
            (EntityCategory.CATEGORY_OBJECT, self._crew.things),
        )
        return [
            name
            for kind, names in kinds
            for name in names
            if (not wanted or kind in wanted) and pattern.search(name)
        ]

    def _state_of(self, name: str) -> EntityState:
        header = ros_io.header(self._world.tick, MAP)
        if name in self._crew.things:
            pose = _pose_of_thing(self._world, self._crew.things.index(name))
            return EntityState(header=header, pose=pose, acceleration=Accel())
        robot = self._crew.robot(name)
        pose_map, twist = self._world.ground_truth()[robot]
        return EntityState(
            header=header, pose=ros_io.pose_msg(pose_map), twist=_in_map(twist, pose_map.yaw)
        )


def _pose_of_thing(world: ChangingWorld, index: int) -> PoseMsg:
    place = world.place_of(index)
    message = PoseMsg()
    point, turn = message.position, message.orientation
    point.x, point.y, point.z = place[:3, 3].tolist()
    turn.x, turn.y, turn.z, turn.w = quaternion(place[:3, :3])
    return message


def _in_map(twist: Twist, yaw: float) -> TwistMsg:
    """Return a robot's twist as seen in the map frame."""
    speed = Pose(0.0, 0.0, yaw).compose(Pose(twist.vx, twist.vy, 0.0))
    message = TwistMsg()
    message.linear.x, message.linear.y, message.angular.z = speed.x, speed.y, twist.wz
    return message
