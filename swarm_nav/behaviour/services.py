"""Commands of an operator and services of Nav2 for a navigator; see `interfaces.Services`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Pose, RobotSpec, Twist
from swarm_common.model.zones import DirectedZone, with_mask
from swarm_nav.behaviour import costmap as costmaps
from swarm_nav.behaviour.announcement import compose_feedback
from swarm_nav.behaviour.behaviors import BehaviorEnd
from swarm_nav.behaviour.parts import Parts
from swarm_nav.control.controller import Controller
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, Feedback, GoalKind, Outcome
from swarm_nav.core.localisation_config import START_DEVIATION
from swarm_nav.interfaces import Costmap
from swarm_nav.localisation.localiser import Localiser
from swarm_nav.traffic.gate import narrow_region
from swarm_nav.traffic.speed_limits import SpeedLimits


class NavigatorServices:
    """Requests that a navigator serves between two ticks."""

    def __init__(
        self,
        parts: Parts,
        spec: RobotSpec,
        localiser: Localiser,
        controller: Controller,
        speed_limits: SpeedLimits,
    ) -> None:
        self._p, self._s, self._spec = parts, parts.robot, spec
        self._localiser, self._controller = localiser, controller
        self._speed_limits = speed_limits
        self._keepout_mask: Grid | None = None

    @property
    def goal_id(self) -> int | None:
        return self._p.goal_manager.goal_id

    @property
    def is_pausing(self) -> bool:
        return self._p.goal_manager.is_pausing

    def feedback(self) -> Feedback | None:
        goals = self._p.goal_manager
        if goals.goal_id is None:
            return None
        return compose_feedback(self._s, goals.goal_id, goals.asked, goals.behavior)

    def cancel_goal(self) -> None:
        self._p.goal_manager.end(Outcome.CANCELED, message="canceled")

    def activate(self) -> None:
        if not self._p.is_active:
            self._p.is_active = True
            self._p.senses.listen_anew()
            self._p.arbiter.hold_place()

    def deactivate(self) -> None:
        self._p.goal_manager.end_all("the navigator was deactivated")
        self._p.is_active = False

    def reconfigure(self, config: NavConfig) -> None:
        terrain = self._s.terrain
        self._controller.configure(config.controller)
        self._p.arbiter.configure(config)
        if self._s.terrain is not terrain:  # of other cells
            self._find_region()
        self._localiser.configure(config.localisation)

    def steer(self, twist: Twist) -> None:
        behavior = self._p.goal_manager.behavior
        if behavior is not None:
            behavior.steer(twist, self._s.tick)

    def end_teleop(self, reason: str = "") -> None:
        behavior = self._p.goal_manager.behavior
        if behavior is not None and behavior.goal.kind is GoalKind.TELEOP:
            code = ErrorCode.TELEOP_TIMEOUT if reason else ErrorCode.NONE
            behavior.finish(BehaviorEnd(code, reason))

    def on_speed_limit(self, limit: float, *, is_percentage: bool) -> None:
        self._speed_limits.set(limit, is_percentage=is_percentage)

    def on_keepout_mask(self, mask: Grid) -> None:
        self._keepout_mask = mask
        self._mark(replace(self._s.terrain.grid, keepout=None))

    def on_directed_zones(self, zones: Iterable[DirectedZone]) -> None:
        self._p.arbiter.direct(tuple(zones))

    @property
    def pose_map(self) -> Pose:
        return self._localiser.pose_map

    @property
    def map_from_odom(self) -> Pose:
        return self._localiser.map_from_odom

    def on_initial_pose(
        self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION
    ) -> None:
        self._localiser.initialise(pose_map, deviation)
        self._p.adopt_pose(self._localiser.pose_map)

    def variances(self) -> tuple[float, float, float]:
        return self._localiser.variances()

    def particles(self) -> FloatArray:
        return self._localiser.particles()

    def load_map(self, grid: Grid) -> None:
        self._mark(grid)
        self._localiser.load_map(self._s.terrain)

    def _mark(self, grid: Grid) -> None:
        """Apply a map, with zones and mask."""
        grid = self._p.sites.zones.mark(grid)
        if self._keepout_mask is not None:
            grid = with_mask(grid, self._keepout_mask)
        self._p.arbiter.load_map(grid)
        self._find_region()

    def _find_region(self) -> None:
        """Leave the narrow region, and find those of the terrain."""
        s, gate = self._s, self._p.gate
        gate.leave()
        gate.region = narrow_region(s.terrain, s.stations, s.usual_radius)

    def clear_costmap(self) -> None:
        self._s.obstacles.clear()

    def clear_square(self, centre: Pose, half: float, is_except: bool) -> None:
        self._s.obstacles.clear_square(centre.x, centre.y, half, is_except)

    def make_plan(self, start: Pose | None, goals: Sequence[Pose]) -> FloatArray:
        return self._s.planner.plan_through([(p.x, p.y) for p in (start or self._s.pose, *goals)])

    def smooth(self, points: FloatArray) -> FloatArray:
        return self._s.planner.smooth(points)

    def is_clear(self, points: FloatArray) -> bool:
        terrain, radius = self._s.terrain, self._spec.inscribed_radius
        return all(terrain.clearance(x, y) >= radius for x, y in points.tolist())

    def plan_map(self) -> FloatArray:
        return self._s.tube.points[self._s.tube.near :].copy()

    def local_plan_map(self) -> FloatArray:
        return self._controller.arc[:, :2].copy()

    def global_costmap(self) -> Costmap:
        return costmaps.compose(self._s, self._spec.inscribed_radius, None)

    def local_costmap(self) -> Costmap:
        size = self._s.config.costmap.local_size
        return costmaps.compose(self._s, self._spec.inscribed_radius, size)
