"""The brain of a robot by `brain.plugin`: ours, or one that a user brings and that is guarded."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

from swarm_common.model.beacon import BEACON_DTYPE
from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec, Twist
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sites import Sites
from swarm_common.process.plugins import PluginError
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.behaviour.plain import PlainBrain
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, Event, Goal, GoalEnded, GoalKind, Outcome, Output
from swarm_nav.core.goals import Status as StatusRecord
from swarm_nav.core.plugins import BRAIN, check_plugins
from swarm_nav.interfaces import RobotBrain

ASKED = (  # the plug-in, if it has them; else the plain answer counts
    "on_odom", "on_scan", "on_battery", "on_reception", "feedback", "activate", "deactivate",
    "reconfigure", "steer", "end_teleop", "on_speed_limit", "on_keepout_mask", "on_directed_zones",
    "on_initial_pose", "variances", "particles", "load_map", "clear_costmap", "clear_square",
    "plan_map", "local_plan_map", "global_costmap", "local_costmap",
)  # fmt: skip


def make_brain(
    config: NavConfig,
    spec: RobotSpec,
    grid: Grid,
    sites: Sites,
    robot_id: int,
    initial_pose_map: Pose,
    names: RobotNames | None = None,
) -> RobotBrain:
    """Return the brain of a robot, by `brain.plugin`.

    Args:
        grid: The map, upright.
        sites: Sites of the world, in the same map frame.
        robot_id: From 1.
        initial_pose_map: Pose of base_footprint at the first odometry.
        names: Names of all robots, for people; None for the usual ones.

    Raises:
        ConfigError: If the plug-in is missing, or refuses the parameters.
        MapError: If the map is of no use.
    """
    place = grid, sites, robot_id, initial_pose_map
    if BRAIN.is_own(config.brain.plugin):
        if config.traffic.coordination != Coordination.DECENTRAL:
            raise ConfigError(
                f"traffic.coordination is {config.traffic.coordination}: a centre leads built-in"
                f" navigators, not brain.plugin {config.brain.plugin}"
            )
        check_plugins(config)
        return PluginBrain(config, spec, *place)
    return Navigator(config, spec, *place, names)


class PluginBrain(PlainBrain):
    """Calls the plug-in, and answers plainly for what it has not.

    If the plug-in fails, the robot stands and its goal fails.
    """

    def __init__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> None:
        """Make the plug-in; arguments as of `Brain`.

        Raises:
            ConfigError: If it is missing.
        """
        super().__init__(config, spec, grid, robot_id, initial_pose_map)
        self._fault: PluginError | None = None
        place = grid, sites, robot_id, initial_pose_map
        self._own = BRAIN.guard(config.brain.plugin, config, spec, *place)
        for name in ASKED:
            setattr(self, name, functools.partial(self._answer, name, getattr(self, name)))

    def _answer(self, name: str, plain: Any, *arguments: Any, **keywords: Any) -> Any:
        """Do what a plain brain does; return the answer of the plug-in, if it has one."""
        answer = plain(*arguments, **keywords)
        found = self._ask(name, *arguments, **keywords)
        return answer if found is None else found

    def _ask(self, method: str, *arguments: Any, **keywords: Any) -> Any:
        """Return the answer of a plug-in that has a method; None if not, or if it fails."""
        if self._own.has(method):
            try:
                return self._own.call(method, *arguments, **keywords)
            except PluginError as error:
                self._fault = error
        return None

    def _value(self, name: str, default: Any) -> Any:
        if self._own.has(name):
            try:
                return self._own.value(name)
            except PluginError as error:
                self._fault = error
        return default

    @property
    def pose_map(self) -> Pose:
        pose: Pose = self._value("pose_map", self._localiser.pose_map)
        return pose

    @property
    def map_from_odom(self) -> Pose:
        transform: Pose = self._value("map_from_odom", self._localiser.map_from_odom)
        return transform

    @property
    def is_pausing(self) -> bool:  # type: ignore[override]
        return bool(self._value("is_pausing", False))

    def status(self) -> StatusRecord:
        found = self._ask("status")
        return found if isinstance(found, StatusRecord) else super().status()

    def set_goal(self, goal: Goal) -> None:
        self._end(Outcome.CANCELED, message="preempted by a new goal")
        self._goal = goal
        if goal.kind in self._value("goal_kinds", (GoalKind.NAVIGATE,)):
            self._ask("set_goal", goal)
            return
        message = f"{self._own.what} does not know goals of {goal.kind.value}"
        self._end(Outcome.ABORTED, ErrorCode.CONTROL_UNKNOWN, message)

    def cancel_goal(self) -> None:
        """End the current goal, if any; a plug-in that cannot is sent to where it is."""
        if self._goal is None:
            return
        self._end(Outcome.CANCELED, message="canceled")
        if self._own.has("cancel_goal"):
            self._ask("cancel_goal")
        else:
            self._ask("set_goal", Goal(kind=GoalKind.NAVIGATE, poses_map=(self.pose_map,)))

    def tick(self, tick: int) -> Output:
        """Decide; without an answer of the plug-in the robot stands, and its goal fails."""
        self.tick_now = tick
        self.neighbors.refresh(tick)
        try:
            output = self._checked(self._own.call("tick", tick))
        except PluginError as error:
            self._fault = error
            output = Output(Twist(), self._beacon(), ())
        for event in output.events:
            self._record(event)
        twist = output.twist if self.is_active and self._fault is None else Twist()
        if self._fault is not None:
            self._end(Outcome.ABORTED, BRAIN.codes[self._fault.fault], str(self._fault))
            self._fault = None
        events, self._events = tuple(self._events), []
        return Output(twist, output.beacon, events)

    def _checked(self, output: Any) -> Output:
        try:
            twist = output.twist
            numbers = (twist.vx, twist.vy, twist.wz)
            is_usable = all(map(math.isfinite, numbers)) and output.beacon.dtype == BEACON_DTYPE
            if is_usable and isinstance(output, Output):
                return output
        except (AttributeError, TypeError):
            pass
        raise self._own.unusable("tick returned no Output with a finite twist and a beacon")

    def _record(self, event: Event) -> None:
        """Keep an event to be passed on; only the current goal can end."""
        if isinstance(event, GoalEnded):
            if self._goal is None or event.goal_id != self._goal.goal_id:
                return
            self._goal = None
            self._counts[event.outcome] += 1
        self._events.append(event)

    def _beacon(self) -> np.void:
        """Return the beacon of a robot that stands: it acknowledges what others ask for."""
        beacon = super()._beacon()
        beacon["radius"] += self.config.traffic.safety_margin
        beacon["heard"] = self.neighbors.heard(self.tick_now)
        return beacon
