"""Parameters of a navigator. A field is a ROS parameter: `group.name`, the controller's bare.

Names and defaults are Nav2's where Nav2 has the parameter. `parameter_values` and
`config_from_parameters` translate between the dataclasses and the flat ROS names.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from swarm_common.files.convert import convert
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_nav.core.limits import ParameterGroup, check, parameter_name
from swarm_nav.core.localisation_config import LocalisationConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerConfig(ParameterGroup):
    """DWB's parameters (bare names, no prefix)."""

    group = "controller"
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


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannerConfig(ParameterGroup):
    """Global planner; `planner.` parameters."""

    group = "planner"
    tolerance: float = 0.5  # [m] by which a goal may be moved out of an obstacle
    allow_unknown: bool = True  # false: unknown cells of the map are walls
    resolution: float = 0.1  # [m] cell of the search lattice
    replan_period: float = 8.0  # [s] between two plans while driving
    lane_weight: float = 3.0  # extra cost of driving with the nearer wall on the left
    lane_width: float = 2.2  # [m] from a wall within which lanes exist
    plugin: str = "astar"  # finds paths: astar or module:Class


@dataclass(frozen=True, slots=True, kw_only=True)
class CostmapConfig(ParameterGroup):
    """Costmaps; `costmap.` parameters."""

    group = "costmap"
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


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalCheckerConfig(ParameterGroup):
    """When a pose counts as reached; `goal_checker.` parameters."""

    group = "goal_checker"
    xy_goal_tolerance: float = 0.25  # [m] of a reached position
    yaw_goal_tolerance: float = 0.25  # [rad] of a reached heading


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgressCheckerConfig(ParameterGroup):
    """When a robot that could move is not moving; `progress_checker.` parameters."""

    group = "progress_checker"
    required_movement_radius: float = 0.5  # [m] that a robot must move
    movement_time_allowance: float = 10.0  # [s] in which it must, or it counts as stuck
    number_of_retries: int = 6  # recoveries before a goal is given up


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviorConfig(ParameterGroup):
    """Recovery behaviours; `behavior.` parameters."""

    group = "behavior"
    spin_dist: float = 1.57  # [rad] turned by a recovery
    backup_dist: float = 0.30  # [m] driven back by a recovery
    backup_speed: float = 0.15  # [m/s] of driving back in a recovery
    wait_duration: float = 5.0  # [s] waited by a recovery


# All robots must agree on these: the safety argument counts on them. Not changeable while running.
PROTOCOL_PARAMETERS = ("traffic.confirmations", "traffic.wanted_length", "traffic.lost_ticks")
# Read once, at the start.
FIXED_PARAMETERS = (
    *PROTOCOL_PARAMETERS, "localisation.type", "localisation.random_seed",
    "controller.plugin", "planner.plugin", "localiser.plugin", "traffic.priority_plugin",
    "traffic.rules", "traffic.coordination", "brain.plugin",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class TrafficConfig(ParameterGroup):
    """Reservation and right of way; `traffic.` parameters. See ARCHITECTURE.md."""

    group = "traffic"
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
        check(self)
        if not self.rules.replace(",", " ").strip():
            raise ConfigError("traffic.rules is empty; expected all, or names of rules")


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldingConfig(ParameterGroup):
    """Stations and the holding pattern; `holding.` parameters."""

    group = "holding"
    mode: str = "auto"  # where to wait for a station: circuit | park | auto
    request_distance: float = 4.0  # [m] at which a station is asked for; left free before an aisle
    hold_distance: float = 3.0  # [m] from the station at which a robot without its turn holds
    approach_slots: int = 3  # robots on the last metres to a station, or that wait in a region
    circuit_spacing: float = 6.0  # [m] of circuit per robot below which `auto` parks
    search_distance: float = 8.0  # [m] of driving to a parking place
    region_density: float = 0.38  # [1/m²] of robots in a narrow region with stations; 0: no gate
    station_patience: float = 120.0  # [s] that what stands, or went out of sight, bars a station


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryConfig(ParameterGroup):
    """When to charge; `battery.` parameters. Without a battery they do not count."""

    group = "battery"
    low: float = 0.25  # share of charge, beyond what the way takes, at which a robot goes to charge
    enough: float = 0.9  # share of charge at which it leaves the charging station

    def __post_init__(self) -> None:
        check(self)
        if self.low >= self.enough:
            raise ConfigError(
                f"battery.low is {self.low:g} and battery.enough is {self.enough:g}; low must be"
                " less than enough"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class LocaliserConfig(ParameterGroup):
    """`localiser.` parameters."""

    group = "localiser"
    plugin: str = "by_type"  # finds the pose: by_type or module:Class


@dataclass(frozen=True, slots=True, kw_only=True)
class BrainConfig(ParameterGroup):
    """`brain.` parameters."""

    group = "brain"
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
        what = f"parameter '{name}' in {where}"
        changes.setdefault(group or "controller", {})[key] = convert(value, type(known[name]), what)
    groups = {
        group: dataclasses.replace(getattr(base, group), **items)
        for group, items in changes.items()
    }
    return dataclasses.replace(base, **groups)
