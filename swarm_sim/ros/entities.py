"""simulation_interfaces' services about entities: spawn, delete, list, move, reset.

Questions are answered at once. Changes wait until `apply` is called, between two ticks. What a
request may hold is decided in `request_checks`; models are read by another process
(`model_loader`) while the world goes on. Whatever goes wrong with a request becomes its answer.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
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

from swarm_common.middleware import ros_io
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import PolledService
from swarm_common.model.records import Pose
from swarm_common.process.last_resort import FaultLog
from swarm_common.robots.loading import Robot
from swarm_sim.ros.model_loader import ModelLoader
from swarm_sim.ros.name_pattern import NamePattern, PatternError
from swarm_sim.ros.places import (
    MAP,
    check_frame,
    message_of,
    place_in_map,
    pose_in_map,
    twist_in_map,
)
from swarm_sim.scene.scene import Body
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.model_reader import Model, ModelRequest
from swarm_sim.world.object_registry import ObjectRegistry
from swarm_sim.world.refusal import Reason, RefusedError
from swarm_sim.world.request_checks import Reach, check_request
from swarm_sim.world.robot_registry import Arrival, RobotRegistry

SPAWN = "spawn"  # frame id of a robot's pose: any free place of the start area
GROUND = "ground"  # frame id of a thing's pose: in the map, z such that it stands on the ground
BUDGET = 0.2  # [s] of wall time for changes between two ticks; the others wait for the next
Codes = Mapping[Reason, int]
RESULTS: Codes = {
    Reason.UNKNOWN: Result.RESULT_NOT_FOUND,
    Reason.UNSUPPORTED: Result.RESULT_FEATURE_UNSUPPORTED,
}
MOVE_RESULTS: Codes = {**RESULTS, Reason.BAD_PLACE: SetEntityState.Response.INVALID_POSE}
SPAWN_RESULTS: Codes = {
    **RESULTS,
    Reason.NAME_TAKEN: SpawnEntity.Response.NAME_NOT_UNIQUE,
    Reason.NAME_INVALID: SpawnEntity.Response.NAME_INVALID,
    Reason.NO_MODEL: SpawnEntity.Response.NO_RESOURCE,
    Reason.BAD_MODEL: SpawnEntity.Response.RESOURCE_PARSE_ERROR,
    Reason.MISSING_FILES: SpawnEntity.Response.MISSING_ASSETS,
    Reason.BAD_FORMAT: SpawnEntity.Response.UNSUPPORTED_FORMAT,
    Reason.BAD_PLACE: SpawnEntity.Response.INVALID_POSE,
    Reason.BAD_NAMESPACE: SpawnEntity.Response.NAMESPACE_INVALID,
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
        self,
        node: Node,
        world: ChangingWorld,
        robots: RobotRegistry,
        objects: ObjectRegistry,
        reach: Reach,
        host: Host,
        rejections: Rejections,
    ) -> None:
        """Offer the services.

        Args:
            node: Of the world.
            world: To ask for poses.
            robots: The robots.
            objects: The things.
            reach: Where things may be put.
            host: Is told of changes.
            rejections: Count what is not let in.
        """
        self._world, self._robots, self._objects, self._host = world, robots, objects, host
        self._reach = reach
        self._loader = ModelLoader()
        self._rejections = rejections
        self._faults = FaultLog("request")
        ask = node.create_service
        ask(GetEntities, "/sim/get_entities", self._list)
        ask(GetEntitiesStates, "/sim/get_entities_states", self._list_states)
        ask(GetEntityState, "/sim/get_entity_state", self._state)
        self._spawns = PolledService(node, SpawnEntity, "/sim/spawn_entity")
        changes: tuple[tuple[Any, str, Callable[[Any], None], Codes], ...] = (
            (DeleteEntity, "/sim/delete_entity", self._delete, RESULTS),
            (SetEntityState, "/sim/set_entity_state", self._move, MOVE_RESULTS),
            (ResetSimulation, "/sim/reset_simulation", self._reset, RESULTS),
        )
        self._changes = [
            (PolledService(node, kind, name), kind, handle, codes)
            for kind, name, handle, codes in changes
        ]

    def destroy(self) -> None:
        """Withdraw what the node does not destroy itself."""
        for service in (self._spawns, *(service for service, *_ in self._changes)):
            service.destroy()
        self._loader.close()

    def apply(self) -> None:
        """Make the changes that were asked for; call it between two ticks."""
        end = time.monotonic() + BUDGET
        while (taken := self._spawns.take()) is not None:
            self._begin_spawn(*taken)
        for (request, request_id), model in self._loader.poll():
            self._end_spawn(request, request_id, model)
        for service, kind, handle, codes in self._changes:
            while time.monotonic() < end and (taken := service.take()) is not None:
                request, request_id = taken
                response = kind.Response()
                self._attempt(response, codes, partial(self._admit, request, handle))
                service.answer(response, request_id)

    def _attempt(self, response: Any, codes: Codes, do: Callable[[], None]) -> bool:
        """Do what is asked; whatever goes wrong becomes the answer. Return whether it was done."""
        try:
            do()
        except RefusedError as error:
            response.result.result = codes.get(error.reason, Result.RESULT_OPERATION_FAILED)
            response.result.error_message = str(error)
            return False
        except Exception as error:  # a fault of ours: it must not end the world
            response.result.result = Result.RESULT_OPERATION_FAILED
            response.result.error_message = self._faults.note(error)
            self._rejections.reject("/sim", "a client", response.result.error_message)
            return False
        response.result.result = Result.RESULT_OK
        return True

    def _admit(self, request: Any, handle: Callable[[Any], None]) -> None:
        """Go on with a request that passes the door."""
        try:
            check_request(request)
        except RefusedError as error:
            self._rejections.reject("/sim", "a client", error)
            raise
        handle(request)

    # Changes

    def _begin_spawn(self, request: Any, request_id: Any) -> None:
        """Have the model read; what is refused before is answered at once."""
        response = SpawnEntity.Response()
        ask = partial(self._ask_for_model, request_id)
        if not self._attempt(response, SPAWN_RESULTS, partial(self._admit, request, ask)):
            self._spawns.answer(response, request_id)

    def _ask_for_model(self, request_id: Any, request: Any) -> None:
        stamped, resource = request.initial_pose, request.entity_resource
        if stamped.header.frame_id != SPAWN:
            position = stamped.pose.position
            self._reach.check((position.x, position.y, position.z))
        wanted = ModelRequest(
            resource.uri, resource.resource_string, request.name, self._objects.folder
        )
        self._loader.ask((request, request_id), wanted)

    def _end_spawn(self, request: Any, request_id: Any, model: Model | RefusedError) -> None:
        response = SpawnEntity.Response()
        self._attempt(response, SPAWN_RESULTS, partial(self._spawn, request, response, model))
        self._spawns.answer(response, request_id)

    def _spawn(self, request: Any, response: Any, model: Model | RefusedError) -> None:
        if isinstance(model, RefusedError):
            raise model
        if isinstance(model, Robot):
            response.entity_name = self._spawn_robot(request, model)
        else:
            response.entity_name = self._spawn_thing(request, model)

    def _spawn_robot(self, request: Any, robot: Robot) -> str:
        name, space = request.name, request.entity_namespace.strip("/")
        if space and name and space != name:
            raise RefusedError(
                Reason.BAD_NAMESPACE, "a robot's namespace is its name; leave it empty"
            )
        stamped = request.initial_pose
        at_start = stamped.header.frame_id == SPAWN
        pose = None if at_start else pose_in_map(stamped.header.frame_id, stamped.pose)
        model = request.entity_resource.uri.removeprefix("file://")
        arrival = self._robots.spawn(name or space, request.allow_renaming, model, robot, pose)
        self._host.on_arrival(arrival)
        return arrival.name

    def _spawn_thing(self, request: Any, body: Body) -> str:
        stamped = request.initial_pose
        is_floored = stamped.header.frame_id == GROUND
        if not is_floored:
            check_frame(stamped.header.frame_id)
        name = self._objects.spawn(
            request.name,
            request.allow_renaming,
            body,
            place_in_map(stamped.pose),
            is_floored=is_floored,
        )
        self._host.on_things()
        return name

    def _delete(self, request: Any) -> None:
        if request.entity in self._objects.names:
            self._objects.remove(request.entity)
            self._host.on_things()
        else:
            self._host.on_removal(self._robots.remove(request.entity))

    def _move(self, request: Any) -> None:
        name, state = request.entity, request.state
        position = state.pose.position
        self._reach.check((position.x, position.y, position.z))
        if name in self._objects.names:
            check_frame(state.header.frame_id)
            self._objects.move(name, place_in_map(state.pose))
            self._host.on_things()
        else:
            pose = pose_in_map(state.header.frame_id, state.pose)
            self._host.on_move(self._robots.move(name, pose), pose)

    def _reset(self, request: Any) -> None:
        scope = request.scope or STATE | SPAWNED
        if scope & ~(STATE | SPAWNED):
            raise RefusedError(
                Reason.UNSUPPORTED,
                "simulated time cannot begin again; the scopes are 2 (poses), 4 (what was "
                "spawned) or both, which is the default",
            )
        if scope & SPAWNED:
            for name in self._robots.spawned:
                self._host.on_removal(self._robots.remove(name))
            for name in self._objects.spawned:
                self._objects.remove(name)
        if scope & STATE:
            self._objects.check_homes()
            for robot, home in self._robots.send_home():
                self._host.on_move(robot, home)
            self._objects.send_home()
        self._host.on_things()

    # Questions

    def _list(self, request: Any, response: Any) -> Any:
        find = partial(self._find, response)
        self._attempt(response, RESULTS, partial(self._admit, request, find))
        return response

    def _list_states(self, request: Any, response: Any) -> Any:
        find = partial(self._find_states, response)
        self._attempt(response, RESULTS, partial(self._admit, request, find))
        return response

    def _state(self, request: Any, response: Any) -> Any:
        look_up = partial(self._look_up, response)
        self._attempt(response, RESULTS, partial(self._admit, request, look_up))
        return response

    def _find(self, response: Any, request: Any) -> None:
        response.entities = self._matching(request.filters)

    def _find_states(self, response: Any, request: Any) -> None:
        self._find(response, request)
        response.states = [self._state_of(name) for name in response.entities]

    def _look_up(self, response: Any, request: Any) -> None:
        response.state = self._state_of(request.entity)

    def _matching(self, filters: EntityFilters) -> list[str]:
        if filters.tags.tags or filters.bounds.points:
            raise RefusedError(Reason.UNSUPPORTED, "filters by tags and bounds are not supported")
        wanted = {category.category for category in filters.categories}
        kinds = (
            (EntityCategory.CATEGORY_ROBOT, self._robots.robots),
            (EntityCategory.CATEGORY_OBJECT, self._objects.names),
        )
        names = [name for kind, names in kinds if not wanted or kind in wanted for name in names]
        try:
            return NamePattern(filters.filter).matching(names)
        except PatternError as error:
            raise RefusedError(
                Reason.FAILED,
                f"'{filters.filter}' is no POSIX extended regular expression: {error}",
            ) from error

    def _state_of(self, name: str) -> EntityState:
        header = ros_io.header(self._world.tick, MAP)
        if name in self._objects.names:
            pose = message_of(self._objects.place_of(name))
            return EntityState(header=header, pose=pose, acceleration=Accel())
        robot = self._robots.robot(name)
        pose_map, twist = self._world.ground_truth()[robot]
        return EntityState(
            header=header, pose=ros_io.pose_msg(pose_map), twist=twist_in_map(twist, pose_map.yaw)
        )
