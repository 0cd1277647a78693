"""The current goal: its sequence of targets, and when each counts as reached."""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.records import Pose, wrap_angle
from swarm_nav.behaviour.given_path import GivenPath
from swarm_nav.core.goals import ErrorCode, Goal, GoalKind
from swarm_nav.planning.planner import path_length
from swarm_nav.traffic.robot_state import RobotView

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

    def __init__(self, goal: Goal, robot: RobotView) -> None:
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

    def record_plan(self, place_map: tuple[float, float] | None) -> None:
        """Remember where the plan to the target ends, if it has points."""
        self.is_planned = True
        self._moved_to = place_map or self._moved_to

    @property
    def is_passing(self) -> bool:
        """Whether the present target is only to be driven through."""
        return self.goal.kind is GoalKind.THROUGH and self.index + 1 < len(self.goal.poses_map)

    @property
    def poses_remaining(self) -> int:
        """Number of poses not reached yet."""
        return len(self.goal.poses_map) - self.index

    def distance_remaining(self, robot: RobotView) -> float:
        """Return the path length [m] to the last pose driven to without a stop."""
        rest = robot.tube.length_ahead()
        rest += math.dist(robot.tube.points[-1], self.place)
        if self.goal.kind is GoalKind.THROUGH:
            poses = [(p.x, p.y) for p in self.goal.poses_map[self.index :]]
            rest += path_length(np.array(poses))
        return rest

    @property
    def has_next(self) -> bool:
        """Whether there is another target after the present one."""
        is_again = self.goal.kind is GoalKind.WAYPOINTS and self.loop < self.goal.loops
        return self.poses_remaining > 1 or is_again

    def next_target(self, tick: int) -> None:
        """Go on to the next target, if there is one."""
        self.has_arrived = False
        self.is_planned = False
        self._moved_to = None
        self.recoveries = 0
        self.progress_tick = self.moved_tick = tick
        if self.index + 1 < len(self.goal.poses_map):
            self.index += 1
        elif self.has_next:
            self.loop += 1
            self.index = 0

    def arrives(self, robot: RobotView) -> bool:
        """Whether the position is reached; once it is, until the tolerance is left again."""
        if self.is_passing or (self.given is not None and not self.given.is_at_end):
            return self.has_arrived
        distance, tolerance = (
            robot.distance_to(*self.place),
            robot.config.goal_checker.xy_goal_tolerance,
        )
        if distance > tolerance:
            return False
        # another robot or an obstacle may block the last centimetres
        waits = robot.is_standing and robot.waited_ticks >= robot.config.traffic.push_ticks
        return self.has_arrived or distance <= STOP_SHARE * tolerance or waits

    def is_reached(self, robot: RobotView, arrives: bool) -> bool:
        """Whether the present target is reached: position first, then heading.

        Args:
            arrives: Whether the position is.
        """
        if self.is_passing:
            return robot.distance_to(*self.place) < THROUGH_RADIUS
        if self.given is not None and not self.given.is_at_end:
            return False
        if not (arrives and robot.is_standing):
            return False
        yaw, tolerance = self.target.yaw, robot.config.goal_checker.yaw_goal_tolerance
        return math.isnan(yaw) or abs(wrap_angle(yaw - robot.pose.yaw)) <= tolerance

    def record_progress(
        self, robot: RobotView, is_excused: bool, is_person_near: bool = False
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

    def record_holding(self, robot: RobotView) -> None:
        """Restart all clocks: a robot in a queue is not expected to move, however long that is."""
        self.progress_pose = robot.pose
        self.progress_tick = self.moved_tick = robot.tick

    def resume(self, robot: RobotView) -> None:
        """Go on after another errand: plan anew, from where the robot is now."""
        self.is_planned = self.has_arrived = False
        self.record_holding(robot)

    def lacks_progress(self, robot: RobotView) -> bool:
        """Whether the progress checker's time is over."""
        allowance = robot.config.progress_checker.movement_time_allowance
        return robot.tick - self.progress_tick > robot.ticks(allowance)
