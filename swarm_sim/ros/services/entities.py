"""simulation_interfaces' services that change who and what is there: spawn, delete, move, reset.

Changes wait until `apply` is called, between two ticks; questions: see `inquiries`. What a request
may hold is decided in `request_checks`; models are read by another process (`model_loader`) while
the world goes on. Whatever goes wrong with a request becomes its answer.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from rclpy.node import Node
from simulation_interfaces.msg import Result, SpawnResult
from simulation_interfaces.srv import (
    DeleteEntity,
    ResetSimulation,
    SetEntityState,
    SpawnEntities,
    SpawnEntity,
)

from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import resource_in
from swarm_common.middleware.ros_poll import PolledService
from swarm_common.model.records import Pose
from swarm_describe.robots.loading import Robot
from swarm_describe.worlds.scene import Body
from swarm_sim.ros.services.model_loader import ModelLoader
from swarm_sim.ros.services.places import check_frame, place_in_map, pose_in_map
from swarm_sim.ros.services.request_guard import RESULTS, Codes, Door
from swarm_sim.world.model_reader import Model, ModelRequest
from swarm_sim.world.object_registry import ObjectRegistry
from swarm_sim.world.request_checks import PlacementArea, Reason, RefusedError
from swarm_sim.world.robot_registry import Arrival, RobotRegistry

SPAWN = "spawn"  # frame id of a robot's pose: any free place of the start area
GROUND = "ground"  # frame id of a thing's pose: in the map, z such that it stands on the ground
BUDGET = 0.2  # [s] of wall time for changes between two ticks; the others wait for the next
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
    """Is told of changes of the world."""

    def on_arrival(self, arrival: Arrival) -> None:
        """A robot has come."""

    def on_removal(self, robot: int) -> None:
        """A robot has been taken out."""

    def on_move(self, robot: int, pose_map: Pose) -> None:
        """A robot has been put elsewhere."""

    def on_things(self) -> None:
        """Things have come, gone or been put elsewhere."""


class Entities:
    """The services `/sim/spawn_entity`, `spawn_entities`, `delete_entity`, ..."""

    def __init__(
        self,
        node: Node,
        robots: RobotRegistry,
        objects: ObjectRegistry,
        reach: PlacementArea,
        host: Host,
        rejections: Rejections,
    ) -> None:
        """Offer the services."""
        self._robots, self._objects, self._host = robots, objects, host
        self._reach = reach
        self._loader = ModelLoader()
        self._door = Door(rejections)
        self._queue: deque[tuple[Any, Any, Callable[[Any], None]]] = deque()  # of batches
        self._spawns = PolledService(node, SpawnEntity, "/sim/spawn_entity")
        self._batches = PolledService(node, SpawnEntities, "/sim/spawn_entities")
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
        for service in (self._spawns, self._batches, *(service for service, *_ in self._changes)):
            service.destroy()
        self._loader.close()

    def apply(self) -> None:
        """Make the changes that were asked for; call it between two ticks."""
        end = time.monotonic() + BUDGET
        while (taken := self._spawns.take()) is not None:
            request, request_id = taken
            self._begin_spawn(
                request, SpawnEntity.Response(), partial(self._spawns.answer, request_id=request_id)
            )
        while (taken := self._batches.take()) is not None:
            self._begin_batch(*taken)
        while self._queue and self._loader.has_room:
            self._begin_spawn(*self._queue.popleft())
        for (request, response, answer), model in self._loader.poll():
            spawn = partial(self._spawn, request, response, model)
            self._door.attempt(response, SPAWN_RESULTS, spawn)
            answer(response)
        for service, kind, handle, codes in self._changes:
            while time.monotonic() < end and (taken := service.take()) is not None:
                request, request_id = taken
                response = kind.Response()
                self._door.attempt(response, codes, partial(self._door.admit, request, handle))
                service.answer(response, request_id)

    # Changes

    def _begin_spawn(self, request: Any, response: Any, answer: Callable[[Any], None]) -> None:
        """Start reading the model; what is rejected before is answered at once."""
        ask = partial(self._ask_for_model, response, answer)
        if not self._door.attempt(response, SPAWN_RESULTS, partial(self._door.admit, request, ask)):
            answer(response)

    def _begin_batch(self, batch: Any, request_id: Any) -> None:
        """Spawn one after the other; answered when the last one is there or refused."""
        response = SpawnEntities.Response()
        admit = partial(self._door.admit, batch, lambda _: None)
        if not self._door.attempt(response, RESULTS, admit):
            self._batches.answer(response, request_id)
            return
        requests = batch.spawn_requests
        response.results = [SpawnResult() for _ in requests]
        missing = len(requests)

        def note(_: Any) -> None:
            nonlocal missing
            missing -= 1
            if missing > 0:
                return
            count = sum(r.result.result != Result.RESULT_OK for r in response.results)
            if count:
                response.result.result = SpawnEntities.Response.ENTITIES_SPAWN_FAILED
                response.result.error_message = f"{count} of {len(requests)} are refused"
            self._batches.answer(response, request_id)

        if not requests:
            note(None)
        self._queue.extend(
            (one, result, note) for one, result in zip(requests, response.results, strict=True)
        )

    def _ask_for_model(self, response: Any, answer: Any, request: Any) -> None:
        stamped, resource = request.initial_pose, resource_in(request)
        if stamped.header.frame_id != SPAWN:
            position = stamped.pose.position
            self._reach.check((position.x, position.y, position.z))
        wanted = ModelRequest(
            resource.uri,
            resource.resource_string,
            self._objects.is_robots(request.name),
            self._objects.folder,
        )
        self._loader.ask((request, response, answer), wanted)

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
        model = resource_in(request).uri.removeprefix("file://")
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
        if not getattr(request, "set_pose", True):  # 2.1 has flags for what is to be set
            raise RefusedError(Reason.UNSUPPORTED, "poses are set only; set_pose is false")
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
