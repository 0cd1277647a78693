"""The parts of a robot that can be replaced: what each gets, what it must return, and when.

A class needs the methods of its protocol, and no base class. A parameter names it, like
`controller.plugin: my_module:MyController`. Lengths are in metres, angles in radians, times in
seconds; points and poses are in the frame that ends their name. Simulated time counts in ticks of
0.1 s. Arrays that a method gets are to be read only.

A method that raises, returns NaN or another shape, or takes longer than 1 s makes the robot's goal
fail, and the robot stand; one that was late is not called again. Time in which numba compiles does
not count, and the constructor may take 60 s.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.battery import BatteryReading
from swarm_common.model.beacon import Reception
from swarm_common.model.central import RobotReport, TeamOrder
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.sites import Sites
from swarm_common.model.zones import DirectedZone
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import (
    ErrorCode,
    Feedback,
    Goal,
    GoalEnded,
    Outcome,
    Output,
    PlanError,
    Status,
)
from swarm_nav.core.localisation_config import START_DEVIATION

__all__ = [
    "BatteryReading", "Brain", "Charged", "Controller", "CostGrid", "Costmap", "DriveLimits",
    "ErrorCode", "Feedback", "FloatArray", "GlobalPlanner", "Goal", "GoalEnded", "Grid", "Led",
    "Localised", "Localiser", "Mapped", "NavConfig", "Odometry", "Operated", "OtherRobot",
    "Outcome", "Output", "PathAhead", "PlanError", "Pose", "Priority", "Proposal", "RankedGoal",
    "Reception", "RobotReport", "RobotSpec", "Rule", "RuleEvent", "RuleEventKind", "RuleState",
    "Scan", "Served", "Services", "Sites", "Staged", "Status", "TeamOrder", "Twist",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """Largest speeds [m/s], [rad/s] and accelerations [m/s²], [rad/s²] of a drive.

    Those of y are 0 unless it is omnidirectional. Accelerations hold for braking, too.
    """

    max_vel_x: float
    max_vel_y: float
    max_vel_theta: float
    acc_lim_x: float
    acc_lim_y: float
    acc_lim_theta: float


@dataclass(frozen=True, slots=True)
class PathAhead:
    """The piece of path that a robot follows now, and how fast it may be on it.

    The piece ends at the next sharp corner, where the robot stops and turns, or at the goal. Points
    beyond the space that the robot holds belong to it too, to steer by.

    Attributes:
        points_map: (n, 2) [m], 0.05 m apart; n is 2 or more, the first is nearest to the robot.
        length: [m] from the robot to the last point in its own space: there it must stop.
        top_speed: [m/s] that the drive has, and from which it stops there; faster twists are
            slowed down to it.
    """

    points_map: FloatArray
    length: float
    top_speed: float


class Controller(Protocol):
    """Follows paths; `controller.plugin`. One per robot, made as `Controller(spec)`.

    A recovery, or a robot that backs out of the way, uses it too: backwards it gets pose and twist
    turned by half a turn, and its answer is turned back.
    """

    def __init__(self, spec: RobotSpec) -> None:
        """Start at standstill.

        Args:
            spec: Model of the robot: drive, footprint, wheels.
        """

    def follow(self, path: PathAhead, pose_map: Pose, twist: Twist, limits: DriveLimits) -> Twist:
        """Return the twist of the next tick.

        Called in each tick in which the robot may move along a path, also while it waits for
        space (`length` is 0): it may turn then. Heading at the goal is not its matter.

        Args:
            path: Path (n, 2) [m] in map to follow.
            pose_map: Pose of base_footprint now.
            twist: Measured, in base_footprint.
            limits: Limits of the drive; each part of the result is clipped to its own.

        Returns:
            The twist in base_footprint; vy counts for omnidirectional drives only.
        """


@dataclass(frozen=True, slots=True)
class Costmap:
    """Costs of Nav2's scale, uint8 (height, width) in map, row 0 at the lowest y; metres."""

    cells: NDArray[np.uint8]
    resolution: float
    origin_x: float
    origin_y: float


@dataclass(frozen=True, slots=True)
class CostGrid:
    """Cost of a metre in each cell; row 0 is at the lowest y.

    The centre of a cell lies at x = origin_x + (column + 0.5) * step, y likewise with its row.

    Attributes:
        costs: (h, w) per metre, 1 or more; inf where the robot's centre cannot be.
        step: [m] edge of a cell.
        origin_x: [m] in map.
        origin_y: [m] in map.
    """

    costs: FloatArray
    step: float
    origin_x: float
    origin_y: float


class GlobalPlanner(Protocol):
    """Finds paths to goals; `planner.plugin`. One per robot, made as `GlobalPlanner(spec)`.

    Places where robots wait or make way are still found by the built-in search.
    """

    def __init__(self, spec: RobotSpec) -> None:
        """Start without a map.

        Args:
            spec: Model of the robot.
        """

    def plan(
        self, grid: CostGrid, start_map: tuple[float, float], goal_map: tuple[float, float]
    ) -> FloatArray:
        """Return a path.

        Called when a goal begins, every `planner.replan_period`, and when the way is blocked.

        Args:
            grid: Walls, keepout zones, distance from walls, and what other robots add at present.
            start_map: (x, y) [m] where the path begins; its cell may be closed.
            goal_map: (x, y) [m], where the robot has room.

        Returns:
            (n, 2) [m] in map, from within 0.5 m of the start to within 0.5 m of the goal, any
            distance apart; it is smoothed and lifted off walls. n = 0: there is no way.

        Raises:
            PlanError: With Nav2's code, in place of n = 0.
        """


class Localiser(Protocol):
    """Finds the pose; `localiser.plugin`. One per robot, made as `Localiser(spec, grid, pose_map)`.

    The robot follows the estimate by 5 mm per tick, and a large correction once it stands.
    """

    def __init__(self, spec: RobotSpec, grid: Grid, pose_map: Pose) -> None:
        """Start at a pose; anew with another map, and when an operator says where the robot is.

        Args:
            spec: Model of the robot; `spec.lidar` has the place of base_scan.
            grid: The map.
            pose_map: Pose of base_footprint at the start.
        """

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan, after the odometry of its tick.

        Args:
            scan: One revolution; ranges [m] of angles that rise counter-clockwise.
        """

    def on_odom(self, odom: Odometry) -> tuple[Pose, float]:
        """Return where the robot is; called in each tick.

        Args:
            odom: Pose in odom, and measured twist. The first one belongs to the given pose.

        Returns:
            Pose of base_footprint in map, and the standard deviation of its position [m], 0 or
            more. With it grows the distance that the robot keeps; above
            `localisation.lost_deviation` it stands.
        """


@dataclass(frozen=True, slots=True)
class RankedGoal:
    """A goal that is to be ranked.

    Attributes:
        robot_id: From 1.
        tick: Now.
        last_goal_tick: Tick at which the robot reached its last target; 0 before the first.
        pose_map: Pose of the robot.
        target_map: Pose to drive to; None without a goal.
    """

    robot_id: int
    tick: int
    last_goal_tick: int
    pose_map: Pose
    target_map: Pose | None


class Priority(Protocol):
    """Ranks robots; `traffic.priority_plugin`. One per robot, made as `Priority(spec)`.

    All robots of a swarm need the same. The higher one goes first, and others make way for it. A
    robot that waits for a station ranks below those that drive, one without a goal below both.
    """

    def __init__(self, spec: RobotSpec) -> None:
        """Start.

        Args:
            spec: Model of the robot.
        """

    def seniority(self, task: RankedGoal) -> int:
        """Return the rank, which holds for the whole way to a target.

        Called once for each target, and once when the robot has none any more. Of equal ones
        the smaller id goes first. Whoever waits must rank above the others after some of their
        goals, or it may wait forever: so ranks fall with `last_goal_tick`, or with `tick`.

        Args:
            task: The target, and when the last one was reached.

        Returns:
            From 0 to 2**32 - 1. The built-in one is 2**32 - 1 - last_goal_tick.
        """


class RuleEventKind(enum.Enum):
    """Changes of goal and state that a rule asks for."""

    INTERRUPTED = "interrupted"  # the robot makes way, or leaves for others
    RESUMED = "resumed"  # it goes on with what was interrupted
    LED = "led"  # a centre decides: it gives up waiting, making way and recovering
    BEHAVIOR_ENDED = "behavior ended"  # or a recovery, with the code of its end
    ARRIVED = "arrived"  # within the tolerance of the target, so that it stops and turns
    STRAYED = "strayed"  # out of it again
    REACHED = "reached"  # the target
    TURN_AWAITED = "turn awaited"  # at a station, or before a full region
    QUEUED = "queued"  # it waits, and is not expected to get on
    TURN_GRANTED = "turn granted"
    UNUSED = "unused"  # space that it held: the way is to be planned anew
    FOLLOWED = "followed"  # a path that was given to it
    PLANNED = "planned"  # the way to the target, which ends at `place_map`
    NO_WAY = "no way"  # to the target
    DRIVEN = "driven"  # for a tick, in which it was to get on
    EXCUSED = "excused"  # from getting on: it waits for another robot
    CAUTIOUS = "cautious"  # near a person
    UNLED = "unled"  # it waits for a centre that gives no way
    FAILED = "failed"  # to get to the target


@dataclass(frozen=True, slots=True)
class RuleEvent:
    """One change that a rule asks for; applied before the rest of its proposal."""

    kind: RuleEventKind
    code: ErrorCode = ErrorCode.NONE  # why it failed
    message: str = ""  # likewise, for people
    is_final: bool = False  # whether no recovery helps
    place_map: tuple[float, float] | None = None  # [m]


@dataclass(frozen=True, slots=True)
class Proposal:
    """Request of a rule. Without any of it the robot goes on along the path that it has.

    The arbiter applies the fields in this order.

    Attributes:
        events: Changes of goal and state; for built-in rules only.
        is_obstructed: Whether something stands in the held space.
        keep_until: Index of the last path point that stays held; None for all.
        keep_ahead: Path points ahead of the robot that stay held; None for all.
        drops_path: Whether the path beyond the stop point is given up.
        holds_place: Whether only the robot's place stays held.
        path: (n, 2) [m] in map, to be followed from the stop point on; None for no new one.
        more: (n, 2) [m] in map, with which the path goes on from its end; None for nothing.
        is_reverse: Whether it is driven backwards; None if the robot chooses that.
        stands: Whether the robot stops and stays, whatever its path.
        yaw: [rad] in map to turn to while it stands; None to stand still.
        most_speed: [m/s] along the path at most.
        most_rate: [rad/s] of a turn to `yaw` at most.
        is_final: Whether lower rules are not asked any more.
        why: In one sentence, what people are told if this proposal is the final one; a function is
            called when they ask.
    """

    events: tuple[RuleEvent, ...] = ()
    is_obstructed: bool = False
    keep_until: int | None = None
    keep_ahead: int | None = None
    drops_path: bool = False
    holds_place: bool = False
    path: FloatArray | None = None
    more: FloatArray | None = None
    is_reverse: bool | None = None
    stands: bool = False
    yaw: float | None = None
    most_speed: float = math.inf
    most_rate: float = math.inf
    is_final: bool = True
    why: str | Callable[[], str] = ""


@dataclass(frozen=True, slots=True)
class OtherRobot:
    """A neighbour, as known from its last beacon."""

    robot_id: int
    pose_map: Pose
    radius: float  # [m] of the disc that it keeps free, its margin included
    priority: int
    blocked_by: int  # id of the robot that it waits for, 0 for none


@dataclass(frozen=True, slots=True)
class RuleState:
    """The robot at the present tick, as far as a rule may know it."""

    robot_id: int
    tick: int
    pose_map: Pose
    twist: Twist  # in base_footprint
    radius: float  # [m] of the disc that it keeps free, its margin included
    priority: int  # as in its last beacon, with what it inherited
    stop_point_map: tuple[float, float]  # [m], the end of the held space, where paths begin
    path_map: FloatArray  # (n, 2) [m], from the robot on; the held space first
    held_points: int  # how many points of that path are held
    blocked_by: int  # id of the robot that it waits for, 0 for none
    blocked_ticks: int  # for which it has waited
    obstacle_ticks: int  # for which something else was in the way
    others: tuple[OtherRobot, ...]  # the robots that it hears, by id


class Rule(Protocol):
    """Asks for something in each tick; a name in `traffic.rules`. Made as `Rule(spec)`.

    The arbiter asks the rules in the order of that list, and the first final proposal wins.
    """

    def __init__(self, spec: RobotSpec) -> None:
        """Start.

        Args:
            spec: Model of the robot.
        """

    def propose(self, state: RuleState) -> Proposal | None:
        """Return the request of the rule in this tick, None for nothing.

        Args:
            state: State of the robot now.
        """


class Brain(Protocol):
    """Decides for a whole robot; `brain.plugin`, or `--method` of the bench. One per robot.

    In each tick `on_odom` and `on_reception` come first, `on_scan` when a scan is due, then
    `tick`. It may have methods of `Charged`, `Operated`, `Localised` and `Mapped`, too. Where it
    has not, `swarm_nav.behaviour.plain` answers: the pose is that of the odometry, plans are those
    of the built-in planner, and costmaps show the map.
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
        """Stand at a pose without a goal.

        Args:
            config: All parameters of the robot.
            spec: Its model.
            grid: The map.
            sites: Stations, circuits and zones of the world, in map.
            robot_id: From 1.
            initial_pose_map: Pose of base_footprint at the first odometry.
        """

    def on_odom(self, odom: Odometry) -> None:
        """Receive the odometry of this tick.

        Args:
            odom: Pose in odom, and twist in base_footprint.
        """

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan.

        Args:
            scan: In base_scan, as the LiDAR is mounted.
        """

    def on_reception(self, reception: Reception) -> None:
        """Receive the beacons heard in this tick.

        Args:
            reception: `reception.beacons` is (k,) of `BEACON_DTYPE`, ascending by id; it does not
                change in this tick.
        """

    def set_goal(self, goal: Goal) -> None:
        """Accept a goal, effective from its start tick on.

        Args:
            goal: It replaces one that has not ended, which ends as canceled.
        """

    def tick(self, tick: int) -> Output:
        """Decide.

        Args:
            tick: Now, later than at the last call.

        Returns:
            The twist to drive, the beacon to send, and what happened since the last tick: a goal
            has ended when a `GoalEnded` is among the events. `swarm_nav.behaviour.plain` makes a
            beacon; bench and radio read at least id, tick, radius, pose, twist and one held point.
        """

    def status(self) -> Status:
        """Return the state with its counters, for the operator and the result."""


@runtime_checkable
class Charged(Protocol):
    """A brain that is told of its battery."""

    def on_battery(self, reading: BatteryReading) -> None:
        """Receive a reading of the battery, once a second where the robot has one.

        Args:
            reading: Charge now, and whether the robot stands on a charger.
        """


@runtime_checkable
class Staged(Protocol):
    """A brain that can decide in stages, between which others decide: the same, but faster."""

    def stages(self, tick: int) -> Iterator[Output | None]:
        """Decide in a number of stages that is the same for all brains of its kind.

        Args:
            tick: Now, as in `tick`.

        Yields:
            None after each stage, at last what `tick` returns.
        """


@runtime_checkable
class Led(Protocol):
    """A brain that reports to a centre and takes its orders."""

    def report(self) -> RobotReport | None:
        """Return the report to the centre after a tick; None where the robot decides alone."""

    def take_order(self, order: TeamOrder) -> None:
        """Receive an order.

        Args:
            order: Points to drive to; a newer one may have come first.
        """


class Operated(Protocol):
    """Commands of an operator beside goals, and what it asks for."""

    @property
    def goal_id(self) -> int | None:
        """Id of the current or pending goal, None without one."""

    @property
    def is_pausing(self) -> bool:
        """Whether the robot is served where it was sent, until its next goal takes effect."""

    def feedback(self) -> Feedback | None:
        """Return the progress of the current or pending goal, None without one."""

    def cancel_goal(self) -> None:
        """End the current goal, if any."""

    def activate(self) -> None:
        """Start to drive."""

    def deactivate(self) -> None:
        """Stop, and end the current goal."""

    def reconfigure(self, config: NavConfig) -> None:
        """Apply new parameters, effective from the next tick.

        Args:
            config: All parameters of the robot.
        """

    def steer(self, twist: Twist) -> None:
        """Receive the twist that an operator wants in the current assisted teleoperation.

        Args:
            twist: In base_footprint; it is limited to what is free.
        """

    def end_teleop(self, reason: str = "") -> None:
        """End the current assisted teleoperation, if any.

        Args:
            reason: Why it failed; empty for a success.
        """

    def on_speed_limit(self, limit: float, *, is_percentage: bool) -> None:
        """Set the operator's speed limit, which counts beside those of zones.

        Args:
            limit: [m/s], or [%] of the largest speed of the controller; 0 for none.
            is_percentage: Whether it is in percent.
        """

    def on_keepout_mask(self, mask: Grid) -> None:
        """Set the filter mask of places where the robot must not be, besides those of the world.

        Args:
            mask: Upright, in map; 100 is forbidden, 1 to 99 costs more.

        Raises:
            MapError: If the mask lies beside the map.
        """

    def on_directed_zones(self, zones: Iterable[DirectedZone]) -> None:
        """Set the zones through which ways to goals lead in a direction, in place of those before.

        Args:
            zones: In map; none for none.
        """


class Localised(Protocol):
    """Knowledge of the place of the robot."""

    @property
    def pose_map(self) -> Pose:
        """Estimated pose of base_footprint in map."""

    @property
    def map_from_odom(self) -> Pose:
        """The transform map → odom."""

    def on_initial_pose(
        self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION
    ) -> None:
        """Set the pose that the operator states.

        Args:
            pose_map: Pose of base_footprint.
            deviation: Standard deviations of position [m] and heading [rad].
        """

    def variances(self) -> tuple[float, float, float]:
        """Return the variances of the estimated x, y [m²] and yaw [rad²]."""

    def particles(self) -> FloatArray:
        """Return hypotheses (k, 3) of the pose in map."""


class Mapped(Protocol):
    """Maps, plans and costmaps."""

    def load_map(self, grid: Grid) -> None:
        """Replace the map.

        Args:
            grid: Occupancy, in the same map frame.

        Raises:
            MapError: If the map has too many cells when it is divided into finer ones, or a zone
                lies beside it.
        """

    def clear_costmap(self) -> None:
        """Forget what the LiDAR saw."""

    def clear_square(self, centre: Pose, half: float, is_except: bool) -> None:
        """Forget what the LiDAR saw in a square, or outside it.

        Args:
            centre: In map; the square's sides are along its axes.
            half: [m] of an edge.
            is_except: Whether it is the rest that is forgotten.
        """

    def make_plan(self, start: Pose | None, goals: Sequence[Pose]) -> FloatArray:
        """Return a path (n, 2) [m] in map.

        Args:
            start: Start of the path; None for the pose of the robot.
            goals: Poses in map that it goes through.

        Raises:
            PlanError: With Nav2's code, if there is none.
        """

    def smooth(self, points: FloatArray) -> FloatArray:
        """Return a polyline (n, 2) smoothed and lifted off walls, as plans are.

        Args:
            points: (n, 2) [m] in map.
        """

    def is_clear(self, points: FloatArray) -> bool:
        """Whether the robot's body fits everywhere on a polyline, by the map.

        Args:
            points: (n, 2) [m] in map.
        """

    def plan_map(self) -> FloatArray:
        """Return the path ahead (n, 2) [m] in map; it may be empty."""

    def local_plan_map(self) -> FloatArray:
        """Return predicted positions (n, 2) [m] in map; there may be none."""

    def global_costmap(self) -> Costmap:
        """Return the costmap of the whole map."""

    def local_costmap(self) -> Costmap:
        """Return the costmap around the robot."""


class Services(Operated, Localised, Mapped, Protocol):
    """Everything that a node of Nav2 offers beside goals."""


@runtime_checkable
class Served(Protocol):
    """A brain with all services of Nav2."""

    @property
    def services(self) -> Services:
        """Its services; the same object each time."""


@runtime_checkable
class Reserving(Served, Protocol):
    """A brain that drives only inside space that it has reserved, and knows its pose."""

    @property
    def reservation_config(self) -> NavConfig:
        """Parameters of its reservations."""


class RobotBrain(Brain, Charged, Served, Protocol):
    """A brain as a node drives it: `swarm_nav.behaviour.plugin_brain.make_brain`."""
