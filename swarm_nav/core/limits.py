"""Limits of every number among a navigator's parameters, and choices of texts.

No number within its limits makes a tick, a costmap or a plan endless. What depends on two
parameters stands in the class of their group (`config`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError, UnknownNameError

CHOICES: Mapping[str, tuple[str, ...]] = {
    "holding.mode": ("circuit", "park", "auto"),
    "localisation.type": ("odometry", "amcl"),
    "traffic.coordination": tuple(
        each.value for each in Coordination if each is not Coordination.FLEET
    ),
}


class NumberRange(NamedTuple):
    """Values from `low` to `high`."""

    low: float
    high: float
    excludes_low: bool  # whether `low` itself is refused
    excludes_high: bool

    def __contains__(self, value: object) -> bool:
        """Whether a number is one of the values; nan is not."""
        assert isinstance(value, int | float)
        is_above = value > self.low if self.excludes_low else value >= self.low
        return is_above and (value < self.high if self.excludes_high else value <= self.high)

    @property
    def words(self) -> str:
        """The interval in words."""
        if not self.excludes_low and not self.excludes_high:
            return f"from {self.low:.10g} to {self.high:.10g}"
        least = "more than" if self.excludes_low else "at least"
        most = "less than" if self.excludes_high else "at most"
        return f"{least} {self.low:.10g} and {most} {self.high:.10g}"


ANY = NumberRange(0.0, 10_000.0, False, False)  # of a parameter that is not below
_NAMES: Mapping[str, str] = {
    "(0, 10000]": """rotate_to_heading_angle corner_angle costmap.cost_scaling_factor
        progress_checker.required_movement_radius progress_checker.movement_time_allowance
        behavior.wait_duration traffic.retry_time traffic.wait_time traffic.stuck_time
        traffic.patience traffic.centre_silence holding.hold_distance holding.circuit_spacing
        holding.station_patience localisation.update_min_d
        localisation.update_min_a localisation.update_period localisation.pf_err
        localisation.sigma_hit localisation.z_hit localisation.laser_likelihood_max_dist
        localisation.beam_skip_distance localisation.recovery_spread
        localisation.recovery_spread_yaw localisation.lost_deviation localisation.most_margin""",
    "[0, 1)": """battery.low localisation.pf_z localisation.beam_skip_threshold
        localisation.beam_skip_error_threshold localisation.recovery_alpha_slow
        localisation.recovery_alpha_fast localisation.lost_fit""",
    "(0, 1]": "battery.enough",
    "(0, 50]": "max_vel_x",
    "[0, 50]": "max_vel_y",
    "(0, 100]": "max_vel_theta",
    "(0, 1000]": "acc_lim_x acc_lim_theta",
    "[0, 1000]": "acc_lim_y",
    "[0, 2]": "traffic.yield_slack",
    "[0, 10]": """planner.tolerance costmap.footprint_padding costmap.static_tolerance
        costmap.unknown_body_margin""",
    "[0, 2147483647]": "localisation.random_seed",
    "[0.001, 2]": "traffic.safety_margin",
    "[0.001, 7]": "goal_checker.yaw_goal_tolerance",
    "[0.001, 10]": "goal_checker.xy_goal_tolerance",
    "[0.001, 20]": "costmap.wall_clearance behavior.backup_dist",
    "[0.001, 50]": "behavior.backup_speed",
    "[0.001, 100]": "behavior.spin_dist",
    "[0.01, 50]": "costmap.inflation_radius",
    "[0.01, 100]": "planner.lane_width",
    "[0.01, 200]": "holding.search_distance",
    "[0.01, 1000]": "holding.request_distance",
    "[0.05, 2]": "planner.resolution",
    "[0.05, 10]": "sim_time",
    "[0.05, 200]": "costmap.obstacle_max_range costmap.raytrace_max_range",
    "[0.1, 0.4]": "traffic.wanted_length",
    "[0.1, 0.8]": "traffic.held_length",
    "[0.1, 1000]": "traffic.radio_range",
    "[0.1, 10000]": "planner.replan_period",
    "[0.2, 50]": "costmap.local_size",
    "[1, 10000]": """traffic.confirmations traffic.listen_ticks traffic.lost_ticks
        traffic.dead_ticks traffic.push_ticks holding.approach_slots""",
    "[2, 100]": "vx_samples vy_samples vtheta_samples",
    "[4, 10000]": "localisation.max_beams",
    "[10, 20000]": "localisation.min_particles localisation.max_particles",
}


def _range(text: str) -> NumberRange:
    low, high = map(float, text[1:-1].split(","))
    return NumberRange(low, high, text.startswith("("), text.endswith(")"))


RANGES: Mapping[str, NumberRange] = {
    name: _range(text) for text, names in _NAMES.items() for name in names.split()
}


class ParameterGroup:
    """Parameters with a prefix, each within its limits."""

    __slots__ = ()
    group: ClassVar[str]  # prefix, and field of `NavConfig`

    def __post_init__(self) -> None:
        check(self)


def parameter_name(group: str, field: str) -> str:
    """Return the ROS name of a parameter.

    The groups are prefixes (`traffic.patience`). Those of `controller` have none, as in Nav2, but
    for `controller.plugin`.

    Args:
        group: Field of `NavConfig`.
        field: Field of the class of that group.
    """
    is_bare = group == "controller" and field != "plugin"
    return field if is_bare else f"{group}.{field}"


def check(config: Any) -> None:
    """Refuse a group of parameters with a value beyond its limits.

    Raises:
        ConfigError: Naming the parameter.
    """
    for item in dataclasses.fields(config):
        value, name = getattr(config, item.name), parameter_name(config.group, item.name)
        if value not in CHOICES.get(name, (value,)):
            raise UnknownNameError(name, value, CHOICES[name])
        limits = RANGES.get(name, ANY)
        if not isinstance(value, bool | str) and value not in limits:
            raise ConfigError(f"{name} is {value}; it must be {limits.words}")
