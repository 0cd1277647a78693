"""Parameters of a navigator. A field is a ROS parameter: `group.name`, the controller's bare.

Names and defaults are Nav2's where Nav2 has the parameter. `parameter_values` and
`config_from_parameters` translate between the dataclasses and the flat ROS names.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from swarm_common.model.coordination import Coordination
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_nav.core import limits
from swarm_nav.core.checks import at_most as _at_most
from swarm_nav.core.checks import not_negative as _not_negative
from swarm_nav.core.checks import positive as _positive
from swarm_nav.core.limits import parameter_name
from swarm_nav.core.localisation_config import LocalisationConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerConfig:
    """DWB's parameters (bare names, no prefix)."""

    max_vel_x: float = 0.26  # [m/s] largest speed forwards
    max_vel_theta: float = 1.82  # [rad/s] largest turning rate
    acc_lim_x: float = 1.0  # [m/s²] largest acceleration, also when braking
    acc_lim_theta: float = 3.2  # [rad/s²] largest acceleration of a turn, also when braking
    max_vel_y: float = 0.0  # [m/s] largest speed sideways, of omnidirectional drives
    acc_lim_y: float = 0.0  # [m/s²] largest acceleration sideways, of omnidirectional drives
    vx_samples: int = 8  # speeds that a tick compares
    vy_samples: int = 8  # speeds sideways that a tick compares, of omnidirectional drives
    vtheta_samples: int = 20  # turning rates that a tick compares
    sim_time: float = 0.8  # [s] horizon; shorter than Nav2's 1.7 because the tube must be followed
    path_distance_scale: float = 32.0  # PathDist: mean squared distance to the path
    goal_distance_scale: float = 24.0  # GoalDist: path length still to go at the horizon
    path_align_scale: float = 4.0  # PathAlign: heading against the path at the horizon
    oscillation_scale: float = 0.05  # Oscillation: change of turning rate
    rotate_to_heading_angle: float = 0.4  # [rad] off the path beyond which it turns in place first
    corner_angle: float = 0.7  # [rad] bend of the path that is turned on the spot
    plugin: str = "dwb"  # follows paths: dwb or module:Class

    def __post_init__(self) -> None:
        _positive("", self, "max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "sim_time")
        _positive("", self, "rotate_to_heading_angle", "corner_angle")
        _at_most("", self, "sim_time", 10.0)
        _not_negative(
            "",
            self,
            "path_distance_scale",
            "goal_distance_scale",
            "path_align_scale",
            "oscillation_scale",
        )
        _not_negative("", self, "max_vel_y", "acc_lim_y")
        for name in ("vx_samples", "vy_samples", "vtheta_samples"):
            if not 2 <= getattr(self, name) <= 100:
                raise ConfigError(f"{name} is {getattr(self, name)}; it must be from 2 to 100")


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannerConfig:
    """Global planner; `planner.` parameters."""

    tolerance: float = 0.5  # [m] by which a goal may be moved out of an obstacle
    allow_unknown: bool = True  # false: unknown cells of the map are walls
    resolution: float = 0.1  # [m] cell of the search lattice
    replan_period: float = 8.0  # [s] between two plans while driving
    lane_weight: float = 3.0  # extra cost of driving with the nearer wall on the left
    lane_width: float = 2.2  # [m] from a wall within which lanes exist
    plugin: str = "astar"  # finds paths: astar or module:Class

    def __post_init__(self) -> None:
        _positive("planner.", self, "resolution", "replan_period", "lane_width")
        _not_negative("planner.", self, "tolerance", "lane_weight")


@dataclass(frozen=True, slots=True, kw_only=True)
class CostmapConfig:
    """Costmaps; `costmap.` parameters."""

    inflation_radius: float = 0.55  # [m] around obstacles in the costmaps
    cost_scaling_factor: float = 3.0  # [1/m] how fast costs fall with the distance from obstacles
    footprint_padding: float = 0.01  # [m] kept from obstacles beyond the body
    obstacle_max_range: float = 2.5  # [m] up to which a hit marks
    raytrace_max_range: float = 3.0  # [m] up to which a ray clears
    local_size: float = 3.0  # [m] width and height of the rolling local costmap
    wall_clearance: float = 0.30  # [m] that paths keep from walls; no room for two: a single lane
    static_tolerance: float = 0.20  # [m] from a mapped wall within which a hit is that wall
    scan_timeout: float = 1.0  # [s] without a scan after which the robot stands; 0: no LiDAR
    unknown_body_margin: float = 0.25  # [m] that a body may extend beyond what the LiDAR sees

    def __post_init__(self) -> None:
        _positive("costmap.", self, "inflation_radius", "cost_scaling_factor", "local_size")
        _positive("costmap.", self, "obstacle_max_range", "raytrace_max_range", "wall_clearance")
        _not_negative("costmap.", self, "scan_timeout")
        _at_most("costmap.", self, "local_size", 50.0)
        _not_negative(
            "costmap.", self, "footprint_padding", "static_tolerance", "unknown_body_margin"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalCheckerConfig:
    """When a pose counts as reached; `goal_checker.` parameters."""

    xy_goal_tolerance: float = 0.25  # [m] of a reached position
    yaw_goal_tolerance: float = 0.25  # [rad] of a reached heading

    def __post_init__(self) -> None:
        _positive("goal_checker.", self, "xy_goal_tolerance", "yaw_goal_tolerance")


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgressCheckerConfig:
    """When a robot that could move is not moving; `progress_checker.` parameters."""

    required_movement_radius: float = 0.5  # [m] that a robot must move
    movement_time_allowance: float = 10.0  # [s] in which it must, or it counts as stuck
    number_of_retries: int = 6  # recoveries before a goal is given up

    def __post_init__(self) -> None:
        _positive("progress_checker.", self, "required_movement_radius", "movement_time_allowance")
        if self.number_of_retries < 0:
            raise ConfigError(
                f"progress_checker.number_of_retries is {self.number_of_retries};"
                " it must be 0 or more"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviorConfig:
    """Recovery behaviours; `behavior.` parameters."""

    spin_dist: float = 1.57  # [rad] turned by a recovery
    backup_dist: float = 0.30  # [m] driven back by a recovery
    backup_speed: float = 0.15  # [m/s] of driving back in a recovery
    wait_duration: float = 5.0  # [s] waited by a recovery

    def __post_init__(self) -> None:
        _positive("behavior.", self, "spin_dist", "backup_dist", "backup_speed", "wait_duration")


# All robots must agree on these: the safety argument counts on them. Not changeable while running.
PROTOCOL_PARAMETERS = ("traffic.confirmations", "traffic.wanted_length", "traffic.lost_ticks")
# Read once, at the start.
FIXED_PARAMETERS = (
    *PROTOCOL_PARAMETERS, "localisation.type", "localisation.random_seed",
    "controller.plugin", "planner.plugin", "localiser.plugin", "traffic.priority_plugin",
    "traffic.rules", "traffic.coordination", "brain.plugin",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class TrafficConfig:
    """Reservation and right of way; `traffic.` parameters. See ARCHITECTURE.md."""

    safety_margin: float = 0.047  # [m] beyond the circumscribed radius: tracking + localisation
    yield_slack: float = 0.02  # [m] of safety_margin that a robot making way may use up
    confirmations: int = 1  # beacons in which space was requested before it is taken (M)
    held_length: float = 0.35  # [m] of path held ahead
    wanted_length: float = 0.35  # [m] of path requested beyond the held one
    listen_ticks: int = 16  # ticks of listening before the first claim
    lost_ticks: int = 16  # ticks without a beacon after which a robot is silent: dead, mute or gone
    dead_ticks: int = 100  # ticks without a beacon after which a silent robot has stopped
    radio_range: float = 6.0  # [m] within which beacons are heard
    push_ticks: int = 3  # ticks of being blocked before a blocker that stands makes way
    retry_time: float = 1.0  # [s] blocked, or not pushed any more, before a robot tries another way
    wait_time: float = 2.0  # [s] before a blocker that drives makes way, or a pusher steps back
    stuck_time: float = 4.0  # [s] without moving before a refuge or a claim is given up
    patience: float = 600.0  # [s] without any progress before a goal is given up
    rules: str = "all"  # asked in this order: names, or module:Class; all: every built-in one
    priority_plugin: str = "oldest_goal"  # ranks robots: oldest_goal or module:Class
    coordination: str = "decentral"  # decentral | central | central-with-fallback
    centre_silence: float = 2.0  # [s] without a centre before a robot goes on alone

    def __post_init__(self) -> None:
        known = [name.value for name in Coordination if name is not Coordination.FLEET]
        if self.coordination not in known:
            raise UnknownNameError("traffic.coordination", self.coordination, known)
        _positive("traffic.", self, "centre_silence")
        _positive("traffic.", self, "safety_margin", "held_length", "wanted_length", "radio_range")
        _positive("traffic.", self, "retry_time", "wait_time", "stuck_time", "patience")
        if not 0.1 <= self.held_length <= 0.8:
            raise ConfigError(f"traffic.held_length is {self.held_length} m; from 0.1 to 0.8")
        if not 0.1 <= self.wanted_length <= 0.4:
            raise ConfigError(f"traffic.wanted_length is {self.wanted_length} m; from 0.1 to 0.4")
        if not self.rules.replace(",", " ").strip():
            raise ConfigError("traffic.rules is empty; expected all, or names of rules")
        for name in ("confirmations", "listen_ticks", "lost_ticks", "dead_ticks", "push_ticks"):
            if getattr(self, name) < 1:
                raise ConfigError(f"traffic.{name} is {getattr(self, name)}; it must be 1 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldingConfig:
    """Stations and the holding pattern; `holding.` parameters."""

    mode: str = "auto"  # where to wait for a station: circuit | park | auto
    request_distance: float = 4.0  # [m] at which a station is asked for; left free before an aisle
    hold_distance: float = 3.0  # [m] from the station at which a robot without its turn holds
    approach_slots: int = 3  # robots that may be on the last metres to a station
    circuit_spacing: float = 6.0  # [m] of circuit per robot below which `auto` parks
    search_distance: float = 8.0  # [m] of driving to a parking place
    gate_density: float = 0.25  # [1/m²] of robots at the mouth of a narrow region; 0: no gate
    region_density: float = 0.38  # [1/m²] of robots in all of a narrow region with stations
    station_patience: float = 120.0  # [s] that what stands, or went out of sight, bars a station

    def __post_init__(self) -> None:
        if self.mode not in ("circuit", "park", "auto"):
            raise UnknownNameError("holding.mode", self.mode, ("circuit", "park", "auto"))
        _positive("holding.", self, "request_distance", "hold_distance", "circuit_spacing")
        _positive("holding.", self, "search_distance", "station_patience", "region_density")
        _not_negative("holding.", self, "gate_density")
        if self.approach_slots < 1:
            raise ConfigError(
                f"holding.approach_slots is {self.approach_slots}; it must be 1 or more"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryConfig:
    """When to charge; `battery.` parameters. Without a battery they do not count."""

    low: float = 0.25  # share of charge, beyond what the way takes, at which a robot goes to charge
    enough: float = 0.9  # share of charge at which it leaves the charging station

    def __post_init__(self) -> None:
        if not 0.0 <= self.low < self.enough <= 1.0:
            raise ConfigError(
                f"battery.low is {self.low:g} and battery.enough is {self.enough:g}; they must be"
                " from 0 to 1, and low less than enough"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class LocaliserConfig:
    """`localiser.` parameters."""

    plugin: str = "by_type"  # finds the pose: by_type or module:Class


@dataclass(frozen=True, slots=True, kw_only=True)
class BrainConfig:
    """`brain.` parameters."""

    plugin: str = "navigator"  # decides: navigator or module:Class


@dataclass(frozen=True, slots=True, kw_only=True)
class NavConfig:
    """All parameters of one navigator."""

    controller: ControllerConfig = field(default_factory=ControllerConfig)
    planner: PlannerConfig = field(default_factory=PlannerConfig)
    costmap: CostmapConfig = field(default_factory=CostmapConfig)
    goal_checker: GoalCheckerConfig = field(default_factory=GoalCheckerConfig)
    progress_checker: ProgressCheckerConfig = field(default_factory=ProgressCheckerConfig)
    behavior: BehaviorConfig = field(default_factory=BehaviorConfig)
    traffic: TrafficConfig = field(default_factory=TrafficConfig)
    holding: HoldingConfig = field(default_factory=HoldingConfig)
    battery: BatteryConfig = field(default_factory=BatteryConfig)
    localisation: LocalisationConfig = field(default_factory=LocalisationConfig)
    localiser: LocaliserConfig = field(default_factory=LocaliserConfig)
    brain: BrainConfig = field(default_factory=BrainConfig)

    def __post_init__(self) -> None:
        limits.check(self)


def parameter_values(config: NavConfig) -> dict[str, Any]:
    """Return the flat ROS parameters {name: value} of a configuration.

    Returns:
        Values by name, in the order of the classes; see `limits.parameter_name`.
    """
    values: dict[str, Any] = {}
    for group in dataclasses.fields(config):
        for item in dataclasses.fields(getattr(config, group.name)):
            name = parameter_name(group.name, item.name)
            values[name] = getattr(getattr(config, group.name), item.name)
    return values


def config_from_parameters(
    values: Mapping[str, Any], base: NavConfig | None = None, where: str = "the parameters"
) -> NavConfig:
    """Return `base` with the given flat ROS parameters replaced.

    Args:
        values: By flat name, as `parameter_values` has them; whole numbers do for floats.
        base: Has the values of the other parameters. None: the defaults.
        where: Origin of the values, for messages.

    Raises:
        ConfigError: If a name is unknown, a type is wrong or a value impossible.
    """
    base = base or NavConfig()
    known = parameter_values(base)
    changes: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        if name not in known:
            raise UnknownNameError("parameter", name, known, where)
        group, _, key = name.rpartition(".")
        changes.setdefault(group or "controller", {})[key] = _typed(name, value, known[name], where)
    groups = {
        group: dataclasses.replace(getattr(base, group), **items)
        for group, items in changes.items()
    }
    return dataclasses.replace(base, **groups)


def _typed(name: str, value: Any, default: Any, where: str) -> Any:
    if isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if type(value) is not type(default):
        raise ConfigError(
            f"parameter '{name}' in {where} is {value!r} ({type(value).__name__});"
            f" it must be a {type(default).__name__}"
        )
    return value
