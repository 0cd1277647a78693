"""simulation_interfaces' services about entities: spawn, delete, list, move, reset.

Questions are answered at once. Changes wait until `apply` is called, between two ticks.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Protocol

from geometry_msgs.msg import Accel
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
from swarm_common.records import Pose
from swarm_common.ros_poll import PolledService
from swarm_sim.changing_world import ChangingWorld
from swarm_sim.crew import Arrival, Crew
from swarm_sim.object_source import is_object
from swarm_sim.refusal import Reason, RefusedError
from swarm_sim.ros_places import (
    MAP,
    check_frame,
    message_of,
    place_in_map,
    pose_in_map,
    twist_in_map,
)
from swarm_sim.stock import Stock

SPAWN = "spawn"  # frame id of a robot's pose: any free place of the start area
GROUND = "ground"  # frame id of a thing's pose: in the map, z such that it stands on the ground
RESULTS = {
    Reason.UNKNOWN: Result.RESULT_NOT_FOUND,
    Reason.UNSUPPORTED: Result.RESULT_FEATURE_UNSUPPORTED,
    Reason.FAILED: Result.RESULT_OPERATION_FAILED,
    Reason.NAME_TAKEN: SpawnEntity.Response.NAME_NOT_UNIQUE,
    Reason.NAME_INVALID: SpawnEntity.Response.NAME_INVALID,
    Reason.NO_MODEL: SpawnEntity.Response.NO_RESOURCE,
    Reason.BAD_MODEL: SpawnEntity.Response.RESOURCE_PARSE_ERROR,
    Reason.MISSING_FILES: SpawnEntity.Response.MISSING_ASSETS,
    Reason.BAD_FORMAT: SpawnEntity.Response.UNSUPPORTED_FORMAT,
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

    def on_things(self) -> None:
        """Things have come, gone or been put elsewhere."""


class Entities:
    """The services `/sim/spawn_entity`, `delete_entity`, `get_entities`, ..."""

    def __init__(
        self, node: Node, world: ChangingWorld, crew: Crew, stock: Stock, host: Host
    ) -> None:
        """Offer the services."""
        self._world, self._crew, self._stock, self._host = world, crew, stock, host
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
        uri, text = request.entity_resource.uri, request.entity_resource.resource_string
        if is_object(uri, text, request.name, self._stock.folder):
            response.entity_name = self._spawn_thing(request)
            return
        name = request.name
        if request.entity_namespace and name and request.entity_namespace.strip("/") != name:
            response.result.result = SpawnEntity.Response.NAMESPACE_INVALID
            response.result.error_message = "a robot's namespace is its name; leave it empty"
            return
        stamped = request.initial_pose
        at_start = stamped.header.frame_id == SPAWN
        pose = None if at_start else pose_in_map(stamped.header.frame_id, stamped.pose)
        arrival = self._crew.spawn(
            name or request.entity_namespace.strip("/"),
            request.allow_renaming,
            uri.removeprefix("file://"),
            pose,
        )
        self._host.on_arrival(arrival)
        response.entity_name = arrival.name

    def _spawn_thing(self, request: Any) -> str:
        stamped, resource = request.initial_pose, request.entity_resource
        is_floored = stamped.header.frame_id == GROUND
        if not is_floored:
            check_frame(stamped.header.frame_id)
        name = self._stock.spawn(
            request.name,
            request.allow_renaming,
            resource.uri,
            resource.resource_string,
            place_in_map(stamped.pose),
            is_floored=is_floored,
        )
        self._host.on_things()
        return name

    def _delete(self, request: Any, _: Any) -> None:
        if request.entity in self._stock.names:
            self._stock.remove(request.entity)
            self._host.on_things()
        else:
            self._host.on_removal(self._crew.remove(request.entity))

    def _move(self, request: Any, response: Any) -> None:
        name, state = request.entity, request.state
        try:
            if name in self._stock.names:
                check_frame(state.header.frame_id)
                self._stock.move(name, place_in_map(state.pose))
                self._host.on_things()
            else:
                pose = pose_in_map(state.header.frame_id, state.pose)
                self._host.on_move(self._crew.move(name, pose), pose)
        except RefusedError as error:
            if error.reason is not Reason.BAD_PLACE:
                raise
            response.result.result = SetEntityState.Response.INVALID_POSE
            response.result.error_message = str(error)

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
            for name in self._stock.spawned:
                self._stock.remove(name)
        if scope & STATE:
            self._stock.check_homes()
            for robot, home in self._crew.send_home():
                self._host.on_move(robot, home)
            self._stock.send_home()
        self._host.on_things()

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
            (EntityCategory.CATEGORY_OBJECT, self._stock.names),
        )
        return [
            name
            for kind, names in kinds
            for name in names
            if (not wanted or kind in wanted) and pattern.search(name)
        ]

    def _state_of(self, name: str) -> EntityState:
        header = ros_io.header(self._world.tick, MAP)
        if name in self._stock.names:
            pose = message_of(self._stock.place_of(name))
            return EntityState(header=header, pose=pose, acceleration=Accel())
        robot = self._crew.robot(name)
        pose_map, twist = self._world.ground_truth()[robot]
        return EntityState(
            header=header, pose=ros_io.pose_msg(pose_map), twist=twist_in_map(twist, pose_map.yaw)
        )
