"""Values that cross a topic, as plain dataclasses: what the brains and the world core exchange.

Lengths in metres, angles in radians, times in seconds unless a name says otherwise.
Simulated time is counted in control ticks of `CONTROL_PERIOD`.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from typing import Annotated, Any, TypeVar, dataclass_transform

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError
from swarm_common.model.schema import Name, NotNegative, told
from swarm_common.model.sensors import IDEAL, SensorErrors

CONTROL_PERIOD = 0.1  # [s] of simulated time between two commands (REP-free choice: 10 Hz)
TICK_NANOSECONDS = 100_000_000
OBLONG_SHARE = 1.7  # circle to half width from which ways are planned with the polygon

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]
T = TypeVar("T")
OnRobot = Annotated[float, Meta(ge=-50.0, le=50.0)]  # [m]
Height = Annotated[
    float, told("[m] of the scan plane above the ground: 0.01 to 50", ge=0.01, le=50.0)
]


@dataclass_transform(frozen_default=True)
def value_type(cls: type[T]) -> type[T]:
    """Make a dataclass that is frozen for mypy only, for values that are created in every tick.

    Freezing at run time would make their creation three times as expensive.
    """
    made = dataclass(slots=True, unsafe_hash=True)(cls)
    if sys.version_info >= (3, 13):
        setattr(made, "__eq__", _equal_as_tuples)  # noqa: B010
    return made


def _equal_as_tuples(self: Any, other: Any) -> Any:
    """Compare as dataclasses did before Python 3.13: a yaw that is the one NaN equals itself."""
    if other.__class__ is not self.__class__:
        return NotImplemented
    names: tuple[str, ...] = self.__slots__
    return [getattr(self, name) for name in names] == [getattr(other, name) for name in names]


def tick_from_stamp(sec: int, nanosec: int) -> int:
    """Return the control tick nearest to a ROS time stamp."""
    return round((sec * 1_000_000_000 + nanosec) / TICK_NANOSECONDS)


def stamp_from_tick(tick: int) -> tuple[int, int]:
    """Return (sec [s], nanosec [ns]) of a control tick."""
    return divmod(tick * TICK_NANOSECONDS, 1_000_000_000)


@value_type
class Pose:
    """Planar pose; the frame is in the name of the variable that holds it."""

    x: float
    y: float
    yaw: float

    def compose(self, other: Pose) -> Pose:
        """Return self ∘ other: `a_from_b.compose(b_from_c)` is a_from_c.

        Args:
            other: In the frame whose pose this one is.
        """
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            wrap_angle(self.yaw + other.yaw),
        )

    def inverse(self) -> Pose:
        """Return the pose that undoes this one."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(
            -cos * self.x - sin * self.y, sin * self.x - cos * self.y, wrap_angle(-self.yaw)
        )

    def distance(self, other: Pose) -> float:
        """Return the Euclidean distance [m] between the two positions."""
        return math.hypot(self.x - other.x, self.y - other.y)


def wrap_angle(angle: float) -> float:
    """Return the angle in (-π, π]."""
    return -((-angle + math.pi) % (2.0 * math.pi) - math.pi)


@value_type
class Twist:
    """Velocity in base_footprint: vx forward, vy left [m/s], wz counter-clockwise [rad/s]."""

    vx: float = 0.0
    vy: float = 0.0
    wz: float = 0.0


@value_type
class Odometry:
    """odom → base_footprint at a tick, and the twist in base_footprint."""

    tick: int
    pose_odom: Pose
    twist: Twist


@value_type
class Scan:
    """One LiDAR revolution in base_scan, which lies as the LiDAR is mounted.

    `ranges` is float32 (n,), inf where nothing is hit.
    """

    tick: int
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: NDArray[np.float32]

    def from_above(self, lidar: LidarSpec) -> Scan:
        """Return the scan as an upright LiDAR at the same place would have taken it.

        The rays of one that hangs upside down turn clockwise, seen from above.

        Returns:
            The scan itself if the LiDAR stands upright.
        """
        if not lidar.upside_down:
            return self
        last = self.angle_min + (len(self.ranges) - 1) * self.angle_increment
        limits = (self.range_min, self.range_max)
        return Scan(self.tick, -last, self.angle_increment, *limits, self.ranges[::-1])


@dataclass(frozen=True, slots=True)
class LidarSpec:
    """LiDAR as mounted: pose of its frame in base_footprint, rays and rate."""

    x: OnRobot
    y: OnRobot
    z: Height
    yaw: float = 0.0
    rays: Annotated[int, Meta(ge=1, le=100_000)] = 360
    angle_min: float = 0.0
    angle_increment: Annotated[float, Meta(ge=1e-6)] = 2.0 * math.pi / 360.0
    range_min: NotNegative = 0.12
    range_max: float = 3.5
    rate: Annotated[float, Meta(ge=0.01, le=1000.0)] = 5.0  # [Hz]
    sigma: NotNegative = 0.01  # [m] standard deviation of the range noise
    frame: Name = "base_scan"  # its link in the description
    upside_down: bool = False  # rays turn clockwise, seen from above

    def __post_init__(self) -> None:
        if self.range_max <= self.range_min:
            raise ConfigError(
                f"range_max is {self.range_max:g} m; expected more than range_min, "
                f"{self.range_min:g} m"
            )

    @property
    def period_ticks(self) -> int:
        """Control ticks from one scan to the next: the nearest to the rate."""
        return max(1, round(1.0 / (CONTROL_PERIOD * self.rate)))


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """Properties of a robot model on which the navigator and the world must agree."""

    model: str
    drive: str  # differential | skid | omni
    max_vel_x: float  # [m/s]
    max_vel_theta: float  # [rad/s]
    acc_lim_x: float  # [m/s²]
    acc_lim_theta: float  # [rad/s²]
    wheel_radius: float
    wheel_separation: float
    footprint: tuple[tuple[float, float], ...]  # convex polygon in base_footprint, CCW
    lidar: LidarSpec
    height: float
    max_vel_y: float = 0.0  # [m/s] sideways; 0 unless omni
    acc_lim_y: float = 0.0  # [m/s²]
    wheel_base: float = 0.0  # [m] between the front and the rear axle
    wheels_left: tuple[str, ...] = ("wheel_left_joint",)  # joints, front to rear
    wheels_right: tuple[str, ...] = ("wheel_right_joint",)
    sensors: SensorErrors = IDEAL  # of the real robot; the world decides whether they count
    battery: BatterySpec | None = None  # None: energy does not count

    def is_same_model(self, other: RobotSpec) -> bool:
        """Whether another robot differs by its battery at most, which a fleet may change."""
        return replace(self, battery=None) == replace(other, battery=None)

    @property
    def is_omni(self) -> bool:
        """Whether the robot drives in any direction."""
        return self.drive == "omni"

    @property
    def half_width(self) -> float:
        """Largest distance of a footprint corner from the line straight ahead."""
        return max(abs(y) for _, y in self.footprint)

    @property
    def is_oblong(self) -> bool:
        """Whether it fits straight through much narrower passages than its circle does."""
        return not self.is_omni and self.circumscribed_radius > OBLONG_SHARE * self.half_width

    @property
    def circumscribed_radius(self) -> float:
        """Largest distance of a footprint corner from base_footprint."""
        return max(math.hypot(x, y) for x, y in self.footprint)

    @property
    def inscribed_radius(self) -> float:
        """Smallest distance of a footprint side from base_footprint."""
        sides = zip(self.footprint, (*self.footprint[1:], self.footprint[0]), strict=True)
        return min(abs(a[0] * b[1] - a[1] * b[0]) / math.dist(a, b) for a, b in sides)
