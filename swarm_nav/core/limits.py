"""Between which values every number among a navigator's parameters lies.

The checks of a group (`config`) say what makes sense for a parameter beside others. These say
what any of them may be at most, so that no number makes a tick, a costmap or a plan endless: one
rule for all, and narrower ones where a cell, a particle or a point is made for each unit.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from swarm_common.model.errors import ConfigError

MOST = 10_000.0  # of a parameter without a rule: m, s, rad, or any other unit
ANY = (0.0, MOST)  # of a parameter without a rule
RANGES: Mapping[str, tuple[float, float]] = {
    "max_vel_x": (0.0, 50.0),
    "max_vel_y": (0.0, 50.0),
    "max_vel_theta": (0.0, 100.0),
    "acc_lim_x": (0.0, 1000.0),
    "acc_lim_y": (0.0, 1000.0),
    "acc_lim_theta": (0.0, 1000.0),
    "vx_samples": (2, 100),
    "vy_samples": (2, 100),
    "vtheta_samples": (2, 100),
    "sim_time": (0.05, 10.0),
    "planner.resolution": (0.05, 2.0),
    "planner.replan_period": (0.1, MOST),
    "planner.tolerance": (0.0, 10.0),
    "planner.lane_width": (0.01, 100.0),
    "costmap.inflation_radius": (0.01, 50.0),
    "costmap.local_size": (0.2, 50.0),
    "costmap.obstacle_max_range": (0.05, 200.0),
    "costmap.raytrace_max_range": (0.05, 200.0),
    "costmap.footprint_padding": (0.0, 10.0),
    "costmap.unknown_body_margin": (0.0, 10.0),
    "costmap.static_tolerance": (0.0, 10.0),
    "costmap.wall_clearance": (0.001, 20.0),
    "goal_checker.xy_goal_tolerance": (0.001, 10.0),
    "goal_checker.yaw_goal_tolerance": (0.001, 7.0),
    "behavior.spin_dist": (0.001, 100.0),
    "behavior.backup_dist": (0.001, 20.0),
    "behavior.backup_speed": (0.001, 50.0),
    "traffic.safety_margin": (0.001, 2.0),
    "traffic.yield_slack": (0.0, 2.0),
    "traffic.radio_range": (0.1, 1000.0),
    "traffic.held_length": (0.1, 0.8),
    "traffic.wanted_length": (0.1, 0.4),
    "traffic.confirmations": (1, MOST),
    "traffic.listen_ticks": (1, MOST),
    "traffic.lost_ticks": (1, MOST),
    "traffic.dead_ticks": (1, MOST),
    "traffic.push_ticks": (1, MOST),
    "holding.approach_slots": (1, MOST),
    "holding.request_distance": (0.01, 1000.0),
    "holding.search_distance": (0.01, 200.0),
    "battery.low": (0.0, 1.0),
    "battery.enough": (0.0, 1.0),
    "localisation.random_seed": (0, 2**31 - 1),
    "localisation.min_particles": (10, 20_000),
    "localisation.max_particles": (10, 20_000),
    "localisation.max_beams": (4, 10_000),
    "localisation.pf_z": (0.0, 1.0),
    "localisation.beam_skip_threshold": (0.0, 1.0),
    "localisation.beam_skip_error_threshold": (0.0, 1.0),
    "localisation.recovery_alpha_slow": (0.0, 1.0),
    "localisation.recovery_alpha_fast": (0.0, 1.0),
    "localisation.lost_fit": (0.0, 1.0),
}


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
    """Refuse a configuration with a number beyond its limits.

    Raises:
        ConfigError: Naming the parameter.
    """
    for group in dataclasses.fields(config):
        values = getattr(config, group.name)
        for item in dataclasses.fields(values):
            value = getattr(values, item.name)
            if isinstance(value, (bool, str)):
                continue
            name = parameter_name(group.name, item.name)
            low, high = RANGES.get(name, ANY)
            if not low <= value <= high or not math.isfinite(value):
                between = _between(type(values)(), item.name, low, high)
                raise ConfigError(f"{name} is {value}; it must be {between}")


def takes(group: Any, field: str, value: float) -> bool:
    """Report whether a group of parameters accepts a value, the others being as they are."""
    try:
        dataclasses.replace(group, **{field: value})
    except ConfigError:
        return False
    return True


def _between(group: Any, field: str, low: float, high: float) -> str:
    """Return a range in words; an end that the group itself refuses does not belong to it."""
    is_whole = isinstance(getattr(group, field), int)
    has_low, has_high = (is_whole or takes(group, field, end) for end in (low, high))
    if has_low and has_high:
        return f"from {low:.10g} to {high:.10g}"
    least = "at least" if has_low else "more than"
    most = "at most" if has_high else "less than"
    return f"{least} {low:.10g} and {most} {high:.10g}"
