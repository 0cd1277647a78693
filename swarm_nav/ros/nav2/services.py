"""Nav2's services on the node: lifecycle, costmaps, map."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from nav2_msgs.srv import (
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCostmap,
    LoadMap,
    ManageLifecycleNodes,
)
from std_srvs.srv import Trigger

from swarm_common.files.map_io import load_map
from swarm_common.files.resources import file_of
from swarm_common.middleware import ros_io
from swarm_common.model.errors import MapError, MapImageError, SwarmError
from swarm_nav.interfaces import Costmap, Services
from swarm_nav.ros.nav2.costmaps import costmap_msg
from swarm_nav.ros.nav2.demand import OnDemand
from swarm_nav.ros.nav2.served_node import ServedNode

# By number in the request.
COMMANDS = ("startup", "pause", "resume", "reset", "shutdown", "configure", "cleanup")


class NavServices:
    """All services of one navigator beside its parameters'."""

    def __init__(self, body: ServedNode, services: Services, on_demand: OnDemand) -> None:
        """Offer the services; none is created yet."""
        self._body = body
        self._services = services

        def make(
            kind: Any, name: str, answer: Callable[[Any, Any], Any], *, is_rare: bool = False
        ) -> None:
            """Offer one service.

            Args:
                answer: Gets request and response, and returns the response.
                is_rare: Whether it needs a client in a small swarm, too.
            """
            create = partial(body.node.create_service, kind, name, answer)
            on_demand.offer([name], create, is_rare=is_rare)

        make(ManageLifecycleNodes, "lifecycle_manager_navigation/manage_nodes", self._manage)
        make(Trigger, "lifecycle_manager_navigation/is_active", self._is_active)
        make(LoadMap, "map_server/load_map", self._load_map)
        for name, compose in (
            ("global", services.global_costmap),
            ("local", services.local_costmap),
        ):
            space = f"{name}_costmap"
            make(ClearEntireCostmap, f"{space}/clear_entirely_{space}", self._clear)
            make(GetCostmap, f"{space}/get_costmap", self._costmap_answer(compose))
            # Nav2's costmaps and nav2_simple_commander do not agree about these names.
            for kind, what, commanders in (
                (ClearCostmapAroundRobot, "around", "around_robot"),
                (ClearCostmapAroundPose, "around_pose", "around_pose"),
                (ClearCostmapExceptRegion, "except", "except_region"),
            ):
                answer = partial(self._clear_part, what == "except")
                make(kind, f"{space}/clear_{what}_{space}", answer, is_rare=True)
                make(kind, f"{space}/clear_costmap_{commanders}", answer, is_rare=True)

    def _manage(self, request: Any, response: Any) -> Any:
        if request.command < len(COMMANDS):
            response.success = self._body.change_lifecycle(COMMANDS[request.command])
        return response

    def _is_active(self, _: Any, response: Any) -> Any:
        response.success = self._body.lifecycle.is_active
        return response

    def _load_map(self, request: Any, response: Any) -> Any:
        try:
            path = file_of(request.map_url)
            if not path.is_file():
                response.result = LoadMap.Response.RESULT_MAP_DOES_NOT_EXIST
                return response
            grid = load_map(path)
            upright = grid.upright().refined()
        except (SwarmError, OSError, ValueError, MemoryError) as error:
            self._body.rejections.reject("load_map", "a client", error)
            is_text = isinstance(error, MapError) and not isinstance(error, MapImageError)
            response.result = (
                LoadMap.Response.RESULT_INVALID_MAP_METADATA
                if is_text
                else LoadMap.Response.RESULT_INVALID_MAP_DATA
            )
            return response
        self._body.receive_map(upright)
        response.map = ros_io.grid_msg(grid, self._body.tick)
        response.result = LoadMap.Response.RESULT_SUCCESS
        return response

    def _clear(self, _: Any, response: Any) -> Any:
        self._services.clear_costmap()
        return response

    def _clear_part(self, is_except: bool, request: Any, response: Any) -> Any:
        """Forget marks in a square around the robot or a pose, or all others."""
        try:
            pose = getattr(request, "pose", None)
            centre = self._services.pose_map if pose is None else self._body.to_map(pose)
        except ValueError as error:
            self._body.rejections.reject("clear_costmap", "a client", error)
            return response
        if math.isfinite(request.reset_distance):
            self._services.clear_square(centre, 0.5 * request.reset_distance, is_except)
        return response

    def _costmap_answer(self, compose: Callable[[], Costmap]) -> Callable[[Any, Any], Any]:
        def answer(_: Any, response: Any) -> Any:
            """Return the response with the costmap as it is now."""
            response.map = costmap_msg(compose(), self._body.tick)
            return response

        return answer
