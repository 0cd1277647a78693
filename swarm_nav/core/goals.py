"""Goals that an operator sends to a navigator, and the navigator's answers."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

import numpy as np

from swarm_common.model.errors import SwarmError
from swarm_common.model.records import FloatArray, Pose, Twist, value_type


class GoalKind(enum.Enum):
    """The Nav2 action that a goal belongs to."""

    NAVIGATE = "navigate_to_pose"
    THROUGH = "navigate_through_poses"
    WAYPOINTS = "follow_waypoints"
    FOLLOW_PATH = "follow_path"
    SPIN = "spin"
    BACKUP = "backup"
    DRIVE_ON_HEADING = "drive_on_heading"
    WAIT = "wait"
    TELEOP = "assisted_teleop"


class Outcome(enum.Enum):
    """Result of a goal."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


@dataclass(frozen=True, slots=True, kw_only=True)
class Goal:
    """One request."""

    kind: GoalKind  # action
    goal_id: int = 0  # chosen by the caller, echoed in events
    # targets of NAVIGATE (1), THROUGH and WAYPOINTS (1 or more); a yaw of NaN is any heading
    poses_map: tuple[Pose, ...] = ()
    # points (n, 2) of FOLLOW_PATH
    path_map: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    angle: float = 0.0  # [rad] of SPIN, relative, signed
    distance: float = 0.0  # [m] of BACKUP and DRIVE_ON_HEADING, positive
    # whether FOLLOW_PATH or DRIVE_ON_HEADING is driven backwards; BACKUP always is
    is_reverse: bool = False
    speed: float = 0.0  # [m/s] of BACKUP and DRIVE_ON_HEADING, positive
    # [s] to wait (WAIT), or the time allowance of the other behaviours (0: none)
    duration: float = 0.0
    # pose that the first round of WAYPOINTS begins with; further rounds begin at 0
    first_index: int = 0
    loops: int = 0  # additional rounds through WAYPOINTS
    start_tick: int = 0  # tick at which the goal takes effect; the past means at once


class ErrorCode(enum.IntEnum):
    """Nav2's error codes (Jazzy) as far as this navigator can end with them."""

    NONE = 0
    CONTROL_UNKNOWN = 100
    INVALID_PATH = 103
    FAILED_TO_MAKE_PROGRESS = 105
    NO_VALID_CONTROL = 106
    CONTROLLER_TIMED_OUT = 107
    PLAN_UNKNOWN = 200
    PLAN_TF_ERROR = 202
    START_OUTSIDE_MAP = 203
    GOAL_OUTSIDE_MAP = 204
    START_OCCUPIED = 205
    GOAL_OCCUPIED = 206
    PLAN_TIMEOUT = 207
    NO_VALID_PATH = 208
    NO_VIAPOINTS_GIVEN = 309
    SMOOTH_BAD_ID = 501
    SMOOTH_COLLISION = 503
    SMOOTH_BAD_PATH = 505
    WAYPOINTS_UNKNOWN = 600
    SPIN_UNKNOWN = 700
    SPIN_TIMEOUT = 701
    BACKUP_UNKNOWN = 710
    BACKUP_TIMEOUT = 711
    BACKUP_COLLISION_AHEAD = 714
    DRIVE_UNKNOWN = 720
    DRIVE_TIMEOUT = 721
    DRIVE_COLLISION_AHEAD = 723
    TELEOP_UNKNOWN = 730
    TELEOP_TIMEOUT = 731
    WAIT_UNKNOWN = 740


# What a goal without poses ends with; Jazzy's FollowWaypoints has no code of its own for it.
NO_POSES_CODES = {
    GoalKind.THROUGH: ErrorCode.NO_VIAPOINTS_GIVEN,
    GoalKind.WAYPOINTS: ErrorCode.WAYPOINTS_UNKNOWN,
    GoalKind.FOLLOW_PATH: ErrorCode.INVALID_PATH,
}


# What a goal ends with that is aborted for no fault of its own, by a new one for example.
UNKNOWN_CODES = {
    GoalKind.NAVIGATE: ErrorCode.CONTROL_UNKNOWN,
    GoalKind.THROUGH: ErrorCode.CONTROL_UNKNOWN,
    GoalKind.WAYPOINTS: ErrorCode.WAYPOINTS_UNKNOWN,
    GoalKind.FOLLOW_PATH: ErrorCode.CONTROL_UNKNOWN,
    GoalKind.SPIN: ErrorCode.SPIN_UNKNOWN,
    GoalKind.BACKUP: ErrorCode.BACKUP_UNKNOWN,
    GoalKind.DRIVE_ON_HEADING: ErrorCode.DRIVE_UNKNOWN,
    GoalKind.WAIT: ErrorCode.WAIT_UNKNOWN,
    GoalKind.TELEOP: ErrorCode.TELEOP_UNKNOWN,
}


class PlanError(SwarmError):
    """No plan exists.

    Attributes:
        code: Nav2 error code of ComputePathToPose.
        is_final: Whether the map alone decided it, so that no recovery helps.
    """

    def __init__(self, code: ErrorCode, message: str, *, is_final: bool = False) -> None:
        """Start with the reason for which there is no plan.

        Args:
            code: Nav2 error code, for the result of the action.
            is_final: Whether the map alone decided it, so that no recovery helps.
        """
        self.code = code
        self.is_final = is_final
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class GoalEnded:
    """A goal has reached its terminal state, at control tick `tick`.

    Each missed waypoint comes as its index in the goal's poses and the reason's code.
    """

    goal_id: int
    outcome: Outcome
    tick: int
    error_code: ErrorCode = ErrorCode.NONE
    message: str = ""
    missed_waypoints: tuple[tuple[int, ErrorCode], ...] = ()


@dataclass(frozen=True, slots=True)
class StateChanged:
    """The navigator's state as shown in `status` has changed."""

    state: str
    tick: int


Event = GoalEnded | StateChanged


@dataclass(frozen=True, slots=True)
class Feedback:
    """Progress of the current goal; times in seconds of simulated time."""

    goal_id: int
    pose_map: Pose
    navigation_time: float
    estimated_time_remaining: float
    number_of_recoveries: int
    distance_remaining: float
    poses_remaining: int
    current_waypoint: int
    distance_traveled: float
    angle_traveled: float
    speed: float


@dataclass(frozen=True, slots=True)
class Status:
    """Counterpart of swarm_interfaces/RobotStatus; `goal_map` is None without a goal."""

    state: str
    detail: str
    pose_map: Pose
    goal_map: Pose | None
    station: str
    queue_place: int
    distance_remaining: float
    estimated_time_remaining: float
    holding_since_tick: int
    hold_time: float
    wait_time: float
    number_of_recoveries: int
    goals_reached: int
    goals_failed: int
    pushes: int
    retreats: int
    deadlocks_resolved: int
    replans: int
    battery: float = math.nan  # charge by capacity, 0 to 1; NaN without a battery
    reach: float = math.inf  # [m] that it can drive before it goes to charge; 0 once it does


@value_type
class Output:
    """Result of one tick: the command, the beacon (record of BEACON_DTYPE) and events."""

    twist: Twist
    beacon: np.void
    events: tuple[Event, ...]
