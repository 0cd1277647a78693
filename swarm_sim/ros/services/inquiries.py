"""simulation_interfaces' questions, which are answered at once, and what is not supported."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np
import re2
from geometry_msgs.msg import Accel, Vector3
from rclpy.node import Node
from simulation_interfaces import srv
from simulation_interfaces.msg import (
    Bounds,
    EntityCategory,
    EntityFilters,
    EntityInfo,
    EntityState,
    NamedPose,
    Spawnable,
    TagsFilter,
    WorldResource,
)
from simulation_interfaces.msg import SimulatorFeatures as Can

from swarm_common.files.resources import resource_names
from swarm_common.middleware import ros_io
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import resource_in
from swarm_common.model.errors import SwarmError
from swarm_common.model.records import FloatArray, Pose
from swarm_common.model.shapes import transform_from_xyz_rpy
from swarm_common.model.sites import Sites, Spawn, SpawnArea, SpawnAreas
from swarm_describe.worlds.overlaps import points_of
from swarm_describe.worlds.scene import Body
from swarm_sim.ros.services.places import MAP, message_of, twist_in_map
from swarm_sim.ros.services.request_guard import RESULTS, Door
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.object_registry import ObjectRegistry
from swarm_sim.world.request_checks import Reason, RefusedError
from swarm_sim.world.robot_registry import RobotRegistry

LONGEST = 256  # letters of a pattern
MEMORY = 1 << 20  # [bytes] of a compiled pattern
FEATURES = (
    Can.SPAWNING, Can.DELETING, Can.NAMED_POSES, Can.POSE_BOUNDS, Can.ENTITY_TAGS,
    Can.ENTITY_BOUNDS, Can.ENTITY_BOUNDS_BOX, Can.ENTITY_CATEGORIES, Can.SPAWNING_RESOURCE_STRING,
    Can.ENTITY_STATE_GETTING, Can.ENTITY_STATE_SETTING, Can.ENTITY_INFO_GETTING, Can.SPAWNABLES,
    Can.SIMULATION_RESET, Can.SIMULATION_RESET_STATE, Can.SIMULATION_RESET_SPAWNED,
    Can.SIMULATION_STATE_GETTING, Can.SIMULATION_STATE_SETTING, Can.SIMULATION_STATE_PAUSE,
    Can.STEP_SIMULATION_SINGLE, Can.STEP_SIMULATION_MULTIPLE, Can.STEP_SIMULATION_ACTION,
    Can.WORLD_INFO_GETTING, Can.AVAILABLE_WORLDS, Can.SPAWNING_ENTITIES,
)  # fmt: skip
FORMATS = ["sdf", "urdf"]
INFO = "swarm workbench: docs/ros.md says how it differs from the standard"
# Why what is asked for cannot be; a service that is not there would let its clients wait for ever.
UNSUPPORTED = {
    "LoadWorld": "the world is chosen when the swarm is started: swarm-up --world",
    "UnloadWorld": "the world ends with the swarm",
    "SetEntityInfo": "category, description and tags follow from the model",
}
Box = tuple[FloatArray, FloatArray]  # lowest and highest x, y, z


class Inquiries:
    """The services `/sim/get_...`."""

    def __init__(
        self,
        node: Node,
        world: ChangingWorld,
        robots: RobotRegistry,
        objects: ObjectRegistry,
        rejections: Rejections,
    ) -> None:
        """Offer the services."""
        self._world, self._robots, self._objects = world, robots, objects
        self._door = Door(rejections)
        self._poses = _named_poses(world.scene.sites)
        for name, answer in {
            "GetEntities": self._find,
            "GetEntitiesStates": self._find_states,
            "GetEntityState": self._look_up,
            "GetEntityInfo": self._inform,
            "GetEntityBounds": self._measure,
            "GetSpawnables": _list_spawnables,
            "GetNamedPoses": self._list_poses,
            "GetNamedPoseBounds": self._measure_pose,
            "GetCurrentWorld": self._describe_world,
            "GetAvailableWorlds": _list_worlds,
            **{name: partial(_refuse, why) for name, why in UNSUPPORTED.items()},
        }.items():
            node.create_service(getattr(srv, name), _topic(name), partial(self._answer, answer))
        node.create_service(
            srv.GetSimulatorFeatures, "/sim/get_simulator_features", self._list_features
        )

    def _answer(self, fill: Any, request: Any, response: Any) -> Any:
        admitted = partial(self._door.admit, request, partial(fill, response))
        self._door.attempt(response, RESULTS, admitted)
        return response

    @staticmethod
    def _list_features(_: Any, response: Any) -> Any:
        features = response.features
        features.features, features.spawn_formats, features.custom_info = FEATURES, FORMATS, INFO
        return response

    def _find(self, response: Any, request: Any) -> None:
        response.entities = self._matching(request.filters)

    def _find_states(self, response: Any, request: Any) -> None:
        self._find(response, request)
        response.states = [self._state_of(name) for name in response.entities]

    def _look_up(self, response: Any, request: Any) -> None:
        response.state = self._state_of(request.entity)

    def _inform(self, response: Any, request: Any) -> None:
        response.info = self._info_of(request.entity)

    def _measure(self, response: Any, request: Any) -> None:
        response.bounds = _bounds(_box(self._points(request.entity)))

    def _list_poses(self, response: Any, request: Any) -> None:
        response.poses = [
            pose for pose, _ in self._poses.values() if _has_tags(request.tags, pose.tags)
        ]

    def _measure_pose(self, response: Any, request: Any) -> None:
        if request.name not in self._poses:
            known = ", ".join(self._poses) or "none"
            raise RefusedError(
                Reason.UNKNOWN, f"there is no pose '{request.name}'; there are {known}"
            )
        response.bounds = self._poses[request.name][1]

    def _describe_world(self, response: Any, _: Any) -> None:
        scene = self._world.scene
        response.world = _world_resource(scene.name, str(scene.file))

    def _matching(self, filters: EntityFilters) -> list[str]:
        wanted = {category.category for category in filters.categories}
        kinds = (
            (EntityCategory.CATEGORY_ROBOT, self._robots.robots),
            (EntityCategory.CATEGORY_OBJECT, self._objects.names),
        )
        names = [name for kind, names in kinds if not wanted or kind in wanted for name in names]
        try:
            names = NamePattern(filters.filter).matching(names)
        except PatternError as error:
            raise RefusedError(
                Reason.FAILED,
                f"'{filters.filter}' is no POSIX extended regular expression: {error}",
            ) from error
        if filters.tags.tags:
            names = [n for n in names if _has_tags(filters.tags, self._info_of(n).tags)]
        if filters.bounds.type != Bounds.TYPE_EMPTY:
            names = [n for n in names if _overlap(filters.bounds, self._box_in_map(n))]
        return names

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

    def _info_of(self, name: str) -> EntityInfo:
        info = EntityInfo()
        if name in self._objects.names:
            kind = "static" if self._body(name).is_static else "movable"
            info.category.category = EntityCategory.CATEGORY_OBJECT
        else:
            kind = self._world.specs[self._robots.robot(name)].model
            info.category.category = EntityCategory.CATEGORY_ROBOT
        info.description, info.tags = kind, [kind]
        return info

    def _body(self, name: str) -> Body:
        return self._world.loose[self._objects.names.index(name)]

    def _points(self, name: str) -> FloatArray:
        """Return points (n, 3), in the entity's frame, whose hull is around it."""
        if name in self._objects.names:
            body = self._body(name)
            points = np.vstack([points_of(part, body) for part in body.parts])
            place = body.world_from_body
            return (points - place[:3, 3]) @ place[:3, :3]
        spec = self._world.specs[self._robots.robot(name)]
        return np.array([(x, y, z) for x, y in spec.footprint for z in (0.0, spec.height)])

    def _box_in_map(self, name: str) -> Box:
        if name in self._objects.names:
            place = self._objects.place_of(name)
        else:
            x, y, yaw = self._world.poses[self._robots.robot(name)].tolist()
            place = transform_from_xyz_rpy(x, y, 0.0, 0.0, 0.0, yaw)
        return _box(self._points(name) @ place[:3, :3].T + place[:3, 3])


def _topic(name: str) -> str:
    words = "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name)
    return f"/sim/{words[1:]}"


def _refuse(why: str, response: Any, request: Any) -> None:
    del response, request
    raise RefusedError(Reason.UNSUPPORTED, why)


def _list_spawnables(response: Any, request: Any) -> None:
    for name in resource_names("robot", "robot.yaml"):
        entry = Spawnable(description=f"robot {name}, with a navigator of its own")
        resource_in(entry).uri = name
        response.spawnables.append(entry)
    _record_sources(response, request.sources)


def _list_worlds(response: Any, request: Any) -> None:
    if request.filter.tags:
        raise RefusedError(Reason.UNSUPPORTED, "worlds have no tags")
    response.worlds = [_world_resource(name, name) for name in resource_names("world", "world.sdf")]
    _record_sources(response, request.additional_sources)


def _record_sources(response: Any, sources: Iterable[str]) -> None:
    if names := ", ".join(sources):
        response.result.error_message = f"not searched: {names}"


def _world_resource(name: str, uri: str) -> WorldResource:
    world = WorldResource(name=name)
    resource_in(world).uri = uri
    return world


def _named_poses(sites: Sites) -> dict[str, tuple[NamedPose, Bounds]]:
    """Return the stations, places and starts of a world, and the room around each."""
    found: dict[str, tuple[NamedPose, Bounds]] = {}

    def add(name: str, pose: Pose, tags: list[str], bounds: Bounds) -> None:
        """Add a pose.

        Args:
            tags: The first one is the description, too.
            bounds: Room around it, in its frame; empty for a mere point.
        """
        entry = NamedPose(name=name, description=tags[0], tags=tags, pose=ros_io.pose_msg(pose))
        found[name] = entry, bounds

    for name, pose in sites.stations.items():
        add(name, pose, ["station", "navigation_goal"], Bounds())
    for number, pose in enumerate(sites.places, 1):
        add(f"place_{number}", pose, ["place", "navigation_goal"], Bounds())
    starts: dict[str, Spawn | None] = {"spawn": sites.spawn, **sites.spawns}
    for name, spawn in starts.items():
        areas = spawn.areas if isinstance(spawn, SpawnAreas) else (spawn,)
        for number, area in enumerate(areas, 1):
            if isinstance(area, SpawnArea):
                high = np.array([area.x_max - area.x_min, area.y_max - area.y_min, 0.0]) / 2.0
                centre = Pose(area.x_min + high[0], area.y_min + high[1], area.yaw)
                title = name if len(areas) == 1 else f"{name}_{number}"
                add(title, centre, ["spawn"], _bounds((-high, high)))
    return found


def _has_tags(wanted: TagsFilter, tags: Iterable[str]) -> bool:
    is_all = wanted.filter_mode == TagsFilter.FILTER_MODE_ALL
    return not wanted.tags or (all if is_all else any)(tag in tags for tag in wanted.tags)


def _box(points: FloatArray) -> Box:
    return points.min(axis=0), points.max(axis=0)


def _bounds(box: Box) -> Bounds:
    corners = [Vector3(x=x, y=y, z=z) for x, y, z in (box[1].tolist(), box[0].tolist())]
    return Bounds(type=Bounds.TYPE_BOX, points=corners)


def _overlap(bounds: Bounds, box: Box) -> bool:
    """Whether a sphere or box in the map frame and another box overlap."""
    points = np.array([(point.x, point.y, point.z) for point in bounds.points])
    if bounds.type not in (Bounds.TYPE_BOX, Bounds.TYPE_SPHERE):
        raise RefusedError(Reason.UNSUPPORTED, "bounds are boxes and spheres")
    if len(points) != 2:
        raise RefusedError(Reason.FAILED, f"bounds have {len(points)} points; expected two")
    low, high = box
    if bounds.type == Bounds.TYPE_SPHERE:
        nearest = np.clip(points[0], low, high)
        return bool(np.linalg.norm(nearest - points[0]) <= points[1][0])
    return bool(np.all(points.min(axis=0) <= high) and np.all(points.max(axis=0) >= low))


class PatternError(SwarmError):
    """A filter is not a valid pattern, or needs too much memory."""


class NamePattern:
    """A filter on names: a POSIX extended regular expression; any part of a name may match.

    `simulation_interfaces` says that filters are such expressions. They come from anybody, and a
    matcher that backtracks, as Python's does, may need years for `(a+)+$`. RE2 (Cox 2010) follows
    all ways through an expression at once, and refuses one that needs too much memory.
    """

    def __init__(self, text: str) -> None:
        r"""Compile it.

        Args:
            text: In POSIX's syntax for extended regular expressions, with `\d`, `\w` and `\s`.
        """
        if len(text) > LONGEST:
            raise PatternError(f"it has {len(text)} letters; expected at most {LONGEST}")
        options = re2.Options()
        options.posix_syntax = options.perl_classes = options.one_line = True
        options.max_mem = MEMORY
        options.log_errors = False
        try:
            self._pattern = re2.compile(text, options)
        except (re2.error, UnicodeError) as error:
            raise PatternError(_reason(error)) from error

    def matching(self, names: Iterable[str]) -> list[str]:
        """Return those of some names that match."""
        return [name for name in names if self._pattern.search(name)]


def _reason(error: Exception) -> str:
    reason = error.args[0] if error.args else error
    return reason.decode("utf-8", "replace") if isinstance(reason, bytes) else str(reason)
