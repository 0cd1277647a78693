"""The current goal: its sequence of targets, and when each counts as reached."""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.records import FloatArray, Pose, wrap_angle
from swarm_nav.behaviour.given_path import GivenPath
from swarm_nav.core.goals import ErrorCode, Goal, GoalKind
from swarm_nav.planning.planner import path_length
from swarm_nav.traffic.robot_state import RobotState

STOP_SHARE = 0.8  # of the tolerances at which the robot settles
THROUGH_RADIUS = 0.7  # [m] around an intermediate pose of NavigateThroughPoses


class GoalProgress:
    """A navigation goal with its progress.

    Attributes:
        index: The present target's index in the goal's poses.
        has_arrived: Whether the position is reached and only the heading is missing.
        recoveries: Recoveries spent on this goal.
        is_planned: Whether a first plan was made for the present target.
    """

    def __init__(self, goal: Goal, robot: RobotState) -> None:
        """Start at the first target of the goal, at the present tick.

        Args:
            goal: A goal of a kind that navigates, with a pose or a path at least.
        """
        self.goal = goal
        self.start_tick = robot.tick
        self.index = goal.first_index
        self.loop = 0
        self.has_arrived = False
        self.recoveries = 0
        self.is_planned = False
        self.missed: list[tuple[int, ErrorCode]] = []
        self.given: GivenPath | None = None
        if goal.kind is GoalKind.FOLLOW_PATH:
            self.given = GivenPath(goal.path_map)
        self._moved_to: tuple[float, float] | None = None
        self.progress_pose = robot.pose
        self.progress_tick = robot.tick
        self.moved_tick = robot.tick

    @property
    def target(self) -> Pose:
        """The present target in map."""
        if self.goal.kind is GoalKind.FOLLOW_PATH:
            x, y = self.goal.path_map[-1]
            return Pose(float(x), float(y), math.nan)
        return self.goal.poses_map[self.index]

    @property
    def place(self) -> tuple[float, float]:
        """Goal (x, y) of the path: the target, moved off a wall by the planner's tolerance."""
        return self._moved_to or (self.target.x, self.target.y)

    def record_plan(self, path: FloatArray) -> None:
        """Remember where the plan (n, 2) to the target ends.

        Args:
            path: (n, 2) [m] in map; may be empty.
        """
        self.is_planned = True
        if len(path) > 0:
            self._moved_to = (float(path[-1, 0]), float(path[-1, 1]))

    @property
    def is_passing(self) -> bool:
        """Whether the present target is only to be driven through."""
        return self.goal.kind is GoalKind.THROUGH and self.index + 1 < len(self.goal.poses_map)

    @property
    def poses_remaining(self) -> int:
        """Number of poses not reached yet."""
        return len(self.goal.poses_map) - self.index

    def distance_remaining(self, robot: RobotState) -> float:
        """Return the path length [m] to the last pose driven to without a stop."""
        rest = robot.tube.length_ahead()
        rest += math.dist(robot.tube.points[-1], self.place)
        if self.goal.kind is GoalKind.THROUGH:
            poses = [(p.x, p.y) for p in self.goal.poses_map[self.index :]]
            rest += path_length(np.array(poses))
        return rest

    def next_target(self, tick: int) -> bool:
        """Go on to the next target; False if there is none."""
        self.has_arrived = False
        self.is_planned = False
        self._moved_to = None
        self.recoveries = 0
        self.progress_tick = self.moved_tick = tick
        if self.index + 1 < len(self.goal.poses_map):
            self.index += 1
            return True
        if self.goal.kind is GoalKind.WAYPOINTS and self.loop < self.goal.loops:
            self.loop += 1
            self.index = 0
            return True
        return False

    def is_reached(self, robot: RobotState) -> bool:
        """Whether the present target is reached; position first, then heading (stateful)."""
        target = self.target
        distance = robot.distance_to(*self.place)
        if self.is_passing:
            return distance < THROUGH_RADIUS
        if self.given is not None and not self.given.is_at_end:
            return False
        checker = robot.config.goal_checker
        if distance > checker.xy_goal_tolerance:
            self.has_arrived = False
        elif distance <= STOP_SHARE * checker.xy_goal_tolerance or _cannot_go_on(robot):
            self.has_arrived = True
        if not self.has_arrived:
            return False
        if not robot.is_standing:
            return False
        if math.isnan(target.yaw):
            return True
        return abs(wrap_angle(target.yaw - robot.pose.yaw)) <= checker.yaw_goal_tolerance

    def record_progress(
        self, robot: RobotState, is_excused: bool, is_person_near: bool = False
    ) -> None:
        """Restart the progress checker's clock when the robot moved or could not be expected to.

        While it drives slowly near a person, the clock pauses but does not restart: otherwise a
        person who comes by repeatedly would excuse a robot that another obstacle blocks.

        Args:
            is_excused: Whether it could not be expected to move.
            is_person_near: Whether it drives slowly for a person.
        """
        radius = robot.config.progress_checker.required_movement_radius
        if robot.pose.distance(self.progress_pose) >= radius:
            self.progress_pose = robot.pose
            self.progress_tick = self.moved_tick = robot.tick
        elif is_excused:
            self.progress_tick = robot.tick
        elif is_person_near:
            self.progress_tick = min(self.progress_tick + 1, robot.tick)

    def record_holding(self, robot: RobotState) -> None:
        """Restart all clocks: a robot in a queue is not expected to move, however long that is."""
        self.progress_pose = robot.pose
        self.progress_tick = self.moved_tick = robot.tick

    def resume(self, robot: RobotState) -> None:
        """Go on after another errand: plan anew, from where the robot is now."""
        self.is_planned = self.has_arrived = False
        self.record_holding(robot)

    def lacks_progress(self, robot: RobotState) -> bool:
        """Whether the progress checker's time is over."""
        allowance = robot.config.progress_checker.movement_time_allowance
        return robot.tick - self.progress_tick > robot.ticks(allowance)


def _cannot_go_on(robot: RobotState) -> bool:
    """Report whether another robot or an obstacle blocks the last centimetres."""
    return robot.is_standing and robot.waited_ticks >= robot.config.traffic.push_ticks
